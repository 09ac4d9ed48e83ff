use super::brick_layout::BRICK;
use super::bricks::Bricks;
use fovol_core::memory::{self, SMALLER_VOLUME, Shortage};
use fovol_core::{Camera, ClipBox, FrameSize, Grid, RayMode, Region, TransferFunction, stop};
use glam::DVec3;
use rayon::prelude::*;

/// The edge of macrocells is 2 voxels up to the first number of voxels, 4 up to the second, and else a whole brick, to
/// keep updates quick.
const SMALL_AND_LARGE: [usize; 2] = [1 << 25, 1 << 27];
/// Parts of [0, 1] that opacity is examined in.
const BUCKETS: usize = 4096;
/// Distances are counted up to here.
const FAR: u8 = 63;
/// The most beams along y and along z that the volume is cut into to find its visible parts.
///
/// Every frame visits each beam.
const BEAMS: usize = 32;
/// Above this share of occupied cells looking for empty ones costs more than it saves.
const DENSE: f64 = 0.9;
/// Bytes after the last distance: lanes read distances as 32-bit words.
const SPARE: usize = 4;

/// Minimum and maximum of small blocks of the volume, and how far each is from anything visible.
///
/// A cell covers `edge`³ interpolation cells. It is visible, with distance 0, where the transfer function gives opacity
/// to any value that interpolation can produce in it. Other cells hold the chessboard distance to the nearest visible
/// cell. A ray in a cell at distance d may leave the surrounding box of 2d − 1 cells at once.
#[derive(Debug, Clone)]
pub struct Macrocells {
    cells: [usize; 3],
    shift: u32,
    ranges: Vec<[u16; 2]>,
    /// For each cell, whether interpolation can give NaN in it or beside it; empty for volumes without NaN.
    gaps: Vec<bool>,
    distances: Vec<u8>,
    occupied: f64,
    /// The bounding boxes of the visible cells, first and last along each axis, of up to [`BEAMS`]² beams along x.
    /// Beams without visible cells have none.
    visible: Vec<[[usize; 3]; 2]>,
}

impl Macrocells {
    /// The macrocells of `bricks`, all of them occupied until [`Self::classify`].
    ///
    /// # Errors
    /// No memory for them.
    pub fn new(bricks: &Bricks) -> Result<Self, Shortage> {
        let (cells, shift) = cells_of(bricks.layout().dims);
        let [nx, ny, nz] = cells;
        let mut ranges = memory::zeroed::<[u16; 2]>(nx * ny * nz, "empty space", SMALLER_VOLUME)?;
        ranges.par_iter_mut().enumerate().for_each(|(i, range)| {
            stop::point();
            let cell = [i % nx, i / nx % ny, i / (nx * ny)];
            let [low, high] = bricks.value_range(cell.map(|c| c << shift), 1 << shift);
            // Rounded outwards: a cell may be thought visible, never wrongly invisible.
            *range = [(low * 65535.0).floor() as u16, (high * 65535.0).ceil() as u16];
        });
        let gaps = if bricks.has_gaps() { near_gaps(bricks, cells, shift) } else { Vec::new() };
        let distances = memory::zeroed(ranges.len() + SPARE, "empty space", SMALLER_VOLUME)?;
        let visible = vec![[[0; 3], cells.map(|count| count - 1)]];
        Ok(Self { cells, shift, ranges, gaps, distances, occupied: 1.0, visible })
    }

    /// The memory that the macrocells of a volume of `dims` voxels take, in bytes; volumes with NaN take more.
    pub fn bytes_of(dims: [usize; 3]) -> u64 {
        let count: usize = cells_of(dims).0.iter().product();
        (count * (size_of::<[u16; 2]>() + 1) + SPARE) as u64
    }

    /// Finds the cells in which rays in `mode` may meet anything that `transfer` shows, and all distances.
    ///
    /// Call it whenever the transfer function or the mode changes.
    pub fn classify(&mut self, transfer: &TransferFunction, mode: RayMode) {
        self.classify_with(transfer, mode, []);
    }

    /// [`Self::classify`] for several volumes at the same points: these and `others`, each with its transfer function.
    pub fn classify_with<'a>(
        &mut self,
        transfer: &TransferFunction,
        mode: RayMode,
        others: impl IntoIterator<Item = (&'a Self, &'a TransferFunction)>,
    ) {
        let mut distances = std::mem::take(&mut self.distances);
        distances[..self.ranges.len()].fill(FAR);
        self.mark(transfer, mode, &mut distances);
        others.into_iter().for_each(|(cells, transfer)| cells.mark(transfer, mode, &mut distances));
        self.distances = distances;
        let occupied = self.distances[..self.ranges.len()].par_iter().filter(|&&d| d == 0).count();
        self.occupied = occupied as f64 / self.ranges.len() as f64;
        let count = self.ranges.len();
        self.visible = visible(&self.distances[..count], self.cells);
        spread(&mut self.distances[..count], self.cells);
    }

    /// Sets `distances` to 0 where rays in `mode` may meet anything that `transfer` shows.
    fn mark(&self, transfer: &TransferFunction, mode: RayMode, distances: &mut [u8]) {
        let next = next_visible(&visible_buckets(transfer, mode));
        let bucket = |v: u16| usize::from(v) * BUCKETS / 65536;
        distances[..self.ranges.len()].par_iter_mut().zip(&self.ranges).for_each(|(d, &[low, high])| {
            *d = if next[bucket(low)] as usize <= bucket(high) { 0 } else { *d };
        });
        if transfer.nan()[3] > 0.0 && !matches!(mode, RayMode::Isosurface(_)) {
            let cells = distances.iter_mut().zip(&self.gaps);
            cells.filter(|(_, has_gaps)| **has_gaps).for_each(|(d, _)| *d = 0);
        }
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

    /// Boxes that enclose everything visible, in positions of [`Grid::world_to_grid`](fovol_core::Grid).
    ///
    /// They may enclose somewhat more, never less.
    pub fn visible(&self) -> impl Iterator<Item = [DVec3; 2]> {
        // Interpolation cell i lies between the centres of voxels i and i + 1; those at the border reach on to it.
        let position = |cells: [usize; 3], more: f64| {
            DVec3::from_array(cells.map(|cell| (cell << self.shift) as f64 + more))
        };
        self.visible
            .iter()
            .map(move |&[first, last]| [position(first, -0.5), position(last.map(|cell| cell + 1), 1.5)])
    }

    /// The region of a frame of `size`, seen by `camera`, in which something can be visible; `grid` and `clip` are those of
    /// the volume. It may be somewhat too large, never too small.
    pub fn visible_region(
        &self,
        (grid, clip): (&Grid, &ClipBox),
        camera: &Camera,
        size: FrameSize,
    ) -> Option<Region> {
        let [low, high] = clip.in_world(grid);
        let boxes = self.visible().map(|bounds| bounds.map(|at| grid.grid_to_world(at).clamp(low, high)));
        Region::of_boxes(&camera.rays(size), boxes, size)
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

/// The cells along each axis of a volume of `dims` voxels, and log₂ of their edge.
fn cells_of(dims: [usize; 3]) -> ([usize; 3], u32) {
    let voxels: usize = dims.iter().product();
    let shift = BRICK.ilog2() - SMALL_AND_LARGE.iter().filter(|&&most| voxels <= most).count() as u32;
    (dims.map(|d| d.div_ceil(1 << shift)), shift)
}

/// Whether interpolation can give NaN in each of `cells` of `bricks`, or in one beside it: the step of a ray that
/// begins in NaN ends there.
fn near_gaps(bricks: &Bricks, cells: [usize; 3], shift: u32) -> Vec<bool> {
    let [nx, ny, nz] = cells;
    let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
    let all = (0..nx * ny * nz).into_par_iter();
    let gaps: Vec<bool> =
        all.clone().map(|i| bricks.has_gaps_in(place(i).map(|c| c << shift), 1 << shift)).collect();
    let beside = |c: usize, count: usize| c.saturating_sub(1)..(c + 2).min(count);
    let near = all.map(|i| {
        let [x, y, z] = place(i);
        beside(z, nz).any(|z| beside(y, ny).any(|y| beside(x, nx).any(|x| gaps[(z * ny + y) * nx + x])))
    });
    near.collect()
}

/// The bounding boxes of the cells at distance 0, first and last along each axis, of up to [`BEAMS`]² beams along x.
fn visible(distances: &[u8], cells: [usize; 3]) -> Vec<[[usize; 3]; 2]> {
    let [high, deep] = [cells[1], cells[2]].map(|count| count.div_ceil(BEAMS));
    let both = |[a, b]: [[usize; 3]; 2], [c, d]: [[usize; 3]; 2]| {
        [std::array::from_fn(|i| a[i].min(c[i])), std::array::from_fn(|i| b[i].max(d[i]))]
    };
    let slabs = distances.par_chunks(cells[0] * cells[1] * deep).enumerate();
    let found = slabs.flat_map_iter(|(slab, distances)| {
        let mut beams: Vec<Option<[[usize; 3]; 2]>> = vec![None; cells[1].div_ceil(high)];
        for (number, row) in distances.chunks(cells[0]).enumerate() {
            let Some(first) = row.iter().position(|&d| d == 0) else { continue };
            let last = row.iter().rposition(|&d| d == 0).unwrap_or(first);
            let [y, z] = [number % cells[1], slab * deep + number / cells[1]];
            let more = [first, last].map(|x| [x, y, z]);
            let beam = &mut beams[y / high];
            *beam = Some(beam.map_or(more, |beam| both(beam, more)));
        }
        beams.into_iter().flatten()
    });
    found.collect()
}

/// Whether each bucket holds values that must not be skipped by rays in `mode`.
fn visible_buckets(transfer: &TransferFunction, mode: RayMode) -> Vec<bool> {
    let ends = |bucket: usize| [bucket, bucket + 1].map(|b| b as f64 / BUCKETS as f64);
    let buckets = 0..BUCKETS;
    if let RayMode::Isosurface(iso) = mode {
        let iso = f64::from(iso);
        return buckets.map(|bucket| ends(bucket)[0] <= iso && iso <= ends(bucket)[1]).collect();
    }
    let visible: Vec<bool> =
        buckets.map(|bucket| transfer.max_opacity(ends(bucket)[0], ends(bucket)[1]) > 0.0).collect();
    // The greatest value may be skipped only if all greater ones that are met show nothing either.
    let is_whole = match mode {
        RayMode::Mip => visible.is_sorted(),
        RayMode::Minip => visible.is_sorted_by(|a, b| a >= b),
        RayMode::Average => false,
        RayMode::Composite | RayMode::Isosurface(_) => true,
    };
    // Among gaps that show, a ray must know whether it meets anything else.
    let shows_gaps = mode.is_projection() && transfer.nan()[3] > 0.0;
    if is_whole && !shows_gaps { visible } else { vec![true; BUCKETS] }
}

/// For each bucket the first visible one at or after it; `BUCKETS` if there is none.
fn next_visible(visible: &[bool]) -> Vec<u32> {
    let mut next = vec![BUCKETS as u32; BUCKETS + 1];
    for bucket in (0..BUCKETS).rev() {
        next[bucket] = if visible[bucket] { bucket as u32 } else { next[bucket + 1] };
    }
    next
}

/// Chessboard distance transform in place, saturating at [`FAR`]: along rows, then between rows, then between slices.
///
/// Steps between rows and slices include the diagonal neighbours, so the transform is exact (after Rosenfeld & Pfaltz
/// 1968). These steps vectorise; only the pass along rows is serial.
fn spread(distances: &mut [u8], [nx, ny, _]: [usize; 3]) {
    let plane = nx * ny;
    distances.par_chunks_mut(plane).for_each(|slice| spread_slice(slice, nx));
    let (mut rows, mut nearest) = (vec![0; plane], vec![0; plane]);
    let mut step = |from: &[u8], to: &mut [u8]| {
        least_of_rows(from, nx, &mut rows);
        rows.chunks(nx).zip(nearest.chunks_mut(nx)).for_each(|(row, out)| least_of_three(row, out));
        approach(to, &nearest);
    };
    sweep(distances, plane, &mut step);
}

/// Chessboard distance transform of one slice in place; `nx` is the length of its rows in cells.
fn spread_slice(slice: &mut [u8], nx: usize) {
    for row in slice.chunks_mut(nx) {
        for x in 1..nx {
            row[x] = row[x].min(row[x - 1] + 1);
        }
        for x in (1..nx).rev() {
            row[x - 1] = row[x - 1].min(row[x] + 1);
        }
    }
    let mut nearest = vec![0; nx];
    let mut step = |from: &[u8], to: &mut [u8]| {
        least_of_three(from, &mut nearest);
        approach(to, &nearest);
    };
    sweep(slice, nx, &mut step);
}

/// Calls `step` with each part of `length` and the next one, forwards, and then backwards.
fn sweep(cells: &mut [u8], length: usize, step: &mut impl FnMut(&[u8], &mut [u8])) {
    let count = cells.len() / length;
    for i in 1..count {
        let (before, from) = cells.split_at_mut(i * length);
        step(&before[(i - 1) * length..], &mut from[..length]);
    }
    for i in (1..count).rev() {
        let (before, from) = cells.split_at_mut(i * length);
        step(&from[..length], &mut before[(i - 1) * length..]);
    }
}

/// Lowers every distance of `cells` to at most one more than that in `nearest`.
fn approach(cells: &mut [u8], nearest: &[u8]) {
    cells.iter_mut().zip(nearest).for_each(|(cell, &near)| *cell = (*cell).min(near + 1));
}

/// The minimum of every cell of a row and its two neighbours.
fn least_of_three(row: &[u8], out: &mut [u8]) {
    out.copy_from_slice(row);
    out[1..].iter_mut().zip(row).for_each(|(out, &cell)| *out = (*out).min(cell));
    out.iter_mut().zip(&row[1..]).for_each(|(out, &cell)| *out = (*out).min(cell));
}

/// The minimum of every cell of a slice and its neighbours in the rows before and after.
fn least_of_rows(slice: &[u8], nx: usize, out: &mut [u8]) {
    out.copy_from_slice(slice);
    out[nx..].iter_mut().zip(slice).for_each(|(out, &cell)| *out = (*out).min(cell));
    out.iter_mut().zip(&slice[nx..]).for_each(|(out, &cell)| *out = (*out).min(cell));
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ControlPoint, Grid, Volume};
    use proptest::prelude::*;

    fn threshold(at: f64) -> TransferFunction {
        let p = |v, a| ControlPoint::new(v, [1.0; 3], a);
        TransferFunction::new(vec![p(0.0, 0.0), p(at, 0.0), p(at, 0.5), p(1.0, 0.5)]).unwrap()
    }

    fn one_bright_voxel(dims: [usize; 3], bright: [usize; 3]) -> Bricks {
        let mut values = vec![0u8; dims.iter().product()];
        values[(bright[2] * dims[1] + bright[1]) * dims[0] + bright[0]] = 200;
        Bricks::of_volume(&Volume::from_values(Grid::new(dims, [1.0; 3]).unwrap(), values).unwrap()).unwrap()
    }

    proptest! {
        #[test]
        fn distances_are_chessboard_distances(
            size in prop::array::uniform3(1usize..9),
            seeds in prop::collection::vec(prop::array::uniform3(0usize..9), 1..4),
        ) {
            let [nx, ny, nz] = size;
            let seeds: Vec<[usize; 3]> = seeds.iter().map(|s| [s[0] % nx, s[1] % ny, s[2] % nz]).collect();
            let mut distances = vec![FAR; nx * ny * nz];
            seeds.iter().for_each(|&[x, y, z]| distances[(z * ny + y) * nx + x] = 0);
            spread(&mut distances, size);
            for (at, &distance) in distances.iter().enumerate() {
                let cell = [at % nx, at / nx % ny, at / (nx * ny)];
                let to = |s: &[usize; 3]| (0..3).map(|a| s[a].abs_diff(cell[a])).max().unwrap();
                prop_assert_eq!(usize::from(distance), seeds.iter().map(to).min().unwrap());
            }
        }
    }

    #[test]
    fn distances_end_at_the_farthest() {
        let mut distances = vec![FAR; 200];
        distances[0] = 0;
        spread(&mut distances, [1, 1, 200]);
        assert_eq!((distances[62], distances[63], distances[199]), (62, FAR, FAR));
    }

    #[test]
    fn everything_visible_lies_in_one_of_few_boxes() {
        let cells = [40, 7, 70];
        let bright = |i: usize| i.wrapping_mul(2_654_435_761) >> 7 & 31 == 0 || i < 3;
        let distances: Vec<u8> = (0..40 * 7 * 70).map(|i| if bright(i) { 0 } else { FAR }).collect();
        let boxes = visible(&distances, cells);
        assert!(boxes.len() > 100 && boxes.len() <= 7 * 24, "{}", boxes.len());
        let is_in = |at: [usize; 3], [first, last]: &[[usize; 3]; 2]| {
            (0..3).all(|axis| (first[axis]..=last[axis]).contains(&at[axis]))
        };
        for (i, &distance) in distances.iter().enumerate() {
            let at = [i % 40, i / 40 % 7, i / 280];
            let count = boxes.iter().filter(|bounds| is_in(at, bounds)).count();
            assert!(count <= 1 && (distance > 0 || count == 1), "{at:?} {count}");
        }
        assert!(visible(&[FAR; 8], [2; 3]).is_empty());
    }

    #[test]
    fn a_voxel_on_a_border_occupies_both_sides() {
        let mut cells = Macrocells::new(&one_bright_voxel([16, 8, 8], [8, 1, 1])).unwrap();
        cells.classify(&threshold(0.5), RayMode::Composite);
        assert_eq!(&cells.distances()[..8], [3, 2, 1, 0, 0, 1, 2, 3]);
    }

    #[test]
    fn nothing_visible_is_far_everywhere_and_all_visible_is_dense() {
        let mut cells = Macrocells::new(&one_bright_voxel([64, 64, 64], [1, 1, 1])).unwrap();
        let bytes = cells.ranges.len() * 4 + cells.distances.len();
        assert_eq!(Macrocells::bytes_of([64; 3]), bytes as u64);
        cells.classify(&threshold(0.9), RayMode::Composite);
        assert_eq!(cells.occupied(), 0.0);
        assert!(cells.distances()[..4096].iter().all(|&d| d == FAR));
        let haze = TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], 0.1)]).unwrap();
        cells.classify(&haze, RayMode::Composite);
        assert!(cells.is_dense());
    }
}
