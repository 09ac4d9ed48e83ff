use super::bricks::{BRICK, Bricks};
use fovol_core::TransferFunction;
use rayon::prelude::*;

/// Above this many voxels macrocells are whole bricks, to keep updates quick.
const LARGE: usize = 1 << 27;
/// Parts of [0, 1] that opacity is examined in.
const BUCKETS: usize = 4096;
/// Distances are counted up to here.
const FAR: u8 = 63;
/// Above this share of occupied cells looking for empty ones costs more than it saves.
const DENSE: f64 = 0.9;

/// Minimum and maximum of small blocks of the volume, and how far each is from anything visible.
///
/// A cell covers `edge`³ interpolation cells. Its distance is 0 where the transfer function shows
/// anything that interpolation can give there, else the chessboard distance to the nearest such cell:
/// a ray in a cell at distance d may leave the surrounding box of 2d − 1 cells at once.
#[derive(Debug, Clone)]
pub struct Macrocells {
    cells: [usize; 3],
    shift: u32,
    ranges: Vec<[u16; 2]>,
    distances: Vec<u8>,
    occupied: f64,
}

impl Macrocells {
    /// The macrocells of `bricks`, all of them occupied until [`Self::classify`].
    pub fn new(bricks: &Bricks) -> Self {
        let dims = bricks.layout().dims;
        let shift = if dims.iter().product::<usize>() > LARGE { BRICK.ilog2() } else { BRICK.ilog2() - 1 };
        let edge = 1usize << shift;
        let cells = dims.map(|d| d.div_ceil(edge));
        let [nx, ny, nz] = cells;
        let ranges: Vec<[u16; 2]> = (0..nx * ny * nz)
            .into_par_iter()
            .map(|i| {
                let cell = [i % nx, i / nx % ny, i / (nx * ny)];
                let [low, high] = bricks.value_range(cell.map(|c| c << shift), edge);
                // Rounded outwards: a cell may be thought visible, never wrongly invisible.
                [(low * 65535.0).floor() as u16, (high * 65535.0).ceil() as u16]
            })
            .collect();
        // Four spare bytes: lanes read distances as 32-bit words.
        let distances = vec![0; ranges.len() + 4];
        Self { cells, shift, ranges, distances, occupied: 1.0 }
    }

    /// Finds what `transfer` shows; to be called whenever the transfer function changes.
    pub fn classify(&mut self, transfer: &TransferFunction) {
        let next = next_visible(transfer);
        let bucket = |v: u16| usize::from(v) * BUCKETS / 65536;
        self.distances[..self.ranges.len()].par_iter_mut().zip(&self.ranges).for_each(|(d, &[low, high])| {
            *d = if next[bucket(low)] as usize <= bucket(high) { 0 } else { FAR };
        });
        let occupied = self.distances[..self.ranges.len()].par_iter().filter(|&&d| d == 0).count();
        self.occupied = occupied as f64 / self.ranges.len() as f64;
        spread(&mut self.distances, self.cells);
    }

    /// Cells along x, y, z.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// log₂ of the edge of a cell in voxels.
    pub fn shift(&self) -> u32 {
        self.shift
    }

    /// One distance per cell, x fastest, and four spare bytes.
    pub fn distances(&self) -> &[u8] {
        &self.distances
    }

    /// The share of cells that show anything, 0…1.
    pub fn occupied(&self) -> f64 {
        self.occupied
    }

    /// Whether so little is empty that looking for it would not pay.
    pub fn is_dense(&self) -> bool {
        self.occupied > DENSE
    }
}

/// For each bucket the first one at or after it in which anything is visible; `BUCKETS` if none is.
fn next_visible(transfer: &TransferFunction) -> Vec<u32> {
    let mut next = vec![BUCKETS as u32; BUCKETS + 1];
    for bucket in (0..BUCKETS).rev() {
        let ends = [bucket, bucket + 1].map(|b| b as f64 / BUCKETS as f64);
        let visible = transfer.max_opacity(ends[0], ends[1]) > 0.0;
        next[bucket] = if visible { bucket as u32 } else { next[bucket + 1] };
    }
    next
}

/// Chessboard distance transform in place: two raster scans over the 26 neighbours, exact for this metric
/// (Rosenfeld & Pfaltz 1968), saturating at [`FAR`].
fn spread(distances: &mut [u8], [nx, ny, nz]: [usize; 3]) {
    let relax = |distances: &mut [u8], x: usize, y: usize, z: usize, sign: isize| {
        let at = (z * ny + y) * nx + x;
        let mut best = distances[at];
        if best <= 1 {
            return;
        }
        let (x, y, z) = (x as isize, y as isize, z as isize);
        for (dx, dy, dz) in BEFORE {
            let (x, y, z) = (x + sign * dx, y + sign * dy, z + sign * dz);
            if x >= 0 && y >= 0 && z >= 0 && x < nx as isize && y < ny as isize && z < nz as isize {
                best = best.min(distances[(z as usize * ny + y as usize) * nx + x as usize] + 1);
            }
        }
        distances[at] = best;
    };
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                relax(distances, x, y, z, 1);
            }
        }
    }
    for z in (0..nz).rev() {
        for y in (0..ny).rev() {
            for x in (0..nx).rev() {
                relax(distances, x, y, z, -1);
            }
        }
    }
}

/// The 13 neighbours that a raster scan has passed.
const BEFORE: [(isize, isize, isize); 13] = [
    (-1, 0, 0),
    (-1, -1, 0),
    (0, -1, 0),
    (1, -1, 0),
    (-1, -1, -1),
    (0, -1, -1),
    (1, -1, -1),
    (-1, 0, -1),
    (0, 0, -1),
    (1, 0, -1),
    (-1, 1, -1),
    (0, 1, -1),
    (1, 1, -1),
];

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ControlPoint, Grid, Volume};

    fn threshold(at: f64) -> TransferFunction {
        let p = |v, a| ControlPoint::new(v, [1.0; 3], a);
        TransferFunction::new(vec![p(0.0, 0.0), p(at, 0.0), p(at, 0.5), p(1.0, 0.5)]).unwrap()
    }

    fn one_bright_voxel(dims: [usize; 3], bright: [usize; 3]) -> Bricks {
        let mut values = vec![0u8; dims.iter().product()];
        values[(bright[2] * dims[1] + bright[1]) * dims[0] + bright[0]] = 200;
        Bricks::of_volume(&Volume::from_values(Grid::new(dims, [1.0; 3]).unwrap(), values).unwrap())
    }

    #[test]
    fn distances_are_chessboard_distances() {
        let mut cells = Macrocells::new(&one_bright_voxel([64, 40, 50], [30, 22, 17]));
        cells.classify(&threshold(0.5));
        let [nx, ny, nz] = cells.cells();
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let d = [(x, 30 / 4), (y, 22 / 4), (z, 17 / 4)].map(|(a, b)| a.abs_diff(b));
                    let expected = *d.iter().max().unwrap();
                    assert_eq!(usize::from(cells.distances()[(z * ny + y) * nx + x]), expected);
                }
            }
        }
    }

    #[test]
    fn a_voxel_on_a_border_occupies_both_sides() {
        let mut cells = Macrocells::new(&one_bright_voxel([16, 8, 8], [8, 1, 1]));
        cells.classify(&threshold(0.5));
        assert_eq!(&cells.distances()[..4], [1, 0, 0, 1]);
    }

    #[test]
    fn nothing_visible_is_far_everywhere_and_all_visible_is_dense() {
        let mut cells = Macrocells::new(&one_bright_voxel([64, 64, 64], [1, 1, 1]));
        cells.classify(&threshold(0.9));
        assert_eq!(cells.occupied(), 0.0);
        assert!(cells.distances()[..4096].iter().all(|&d| d == FAR));
        cells.classify(&TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], 0.1)]).unwrap());
        assert!(cells.is_dense());
    }
}
