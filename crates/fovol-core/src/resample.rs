use crate::memory::{self, SMALLER_VOLUME};
use crate::volume::bytes::Plain;
use crate::{Error, Grid, Placement, Result, Volume, Voxel, stop, with_voxel_type};
use bytemuck::Zeroable;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// How the voxels of one volume lie in another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alignment {
    /// Voxel by voxel the same places.
    Same,
    /// By the positions that both files declare in one space.
    Space,
    /// Both fill the same box; at least one file declares no position in the space of the other.
    Box,
}

/// Largest distance between voxels that count as one place, in voxels.
const SAME: f64 = 0.01;

impl Volume {
    /// How the voxels of this volume lie in `onto`.
    pub fn alignment(&self, onto: &Self) -> Alignment {
        let has_space = spaces(self, onto).is_some();
        let map = Map::new(self, onto);
        let dims = onto.grid().dims();
        let ends = [[0; 3], dims.map(|dim| dim - 1)].map(|end| DVec3::from_array(end.map(|at| at as f64)));
        let is_same = self.grid().dims() == dims
            && ends.iter().all(|end| (map.at(*end) - *end).abs().max_element() < SAME);
        match (is_same, has_space) {
            (true, _) => Alignment::Same,
            (false, true) => Alignment::Space,
            (false, false) => Alignment::Box,
        }
    }

    /// Resamples this volume to the voxels of `onto`: see [`Self::alignment`]. The shown range stays.
    ///
    /// Label maps keep their type and get the nearest value, and 0 beyond this volume. Others are interpolated as f32, and are
    /// NaN beyond it.
    ///
    /// # Errors
    /// Volumes that do not overlap, too little memory.
    pub fn resampled(&self, onto: &Self) -> Result<Self> {
        if self.alignment(onto) == Alignment::Same {
            return Ok(self.clone());
        }
        let map = Map::new(self, onto);
        if !map.meets(self.grid(), onto.grid()) {
            return Err(Error::Layers(
                "by the positions in their files they do not overlap; choose files of one examination, or leave out the positions of one of them"
                    .into(),
            ));
        }
        let made = if self.is_label_map() {
            with_voxel_type!(self.dtype(), T => {
                let values = self.put_at::<T>(onto.grid(), |voxel| self.nearest(map.at(voxel)).map(T::from_f64))?;
                Self::from_values(*onto.grid(), values)?
            })
        } else {
            let value = |voxel| Some(self.interpolated(map.at(voxel)).map_or(f32::NAN, |value| value as f32));
            Self::from_values(*onto.grid(), self.put_at::<f32>(onto.grid(), value)?)?
        };
        let made = made.with_notes_of(self).with_range(self.range())?;
        Ok(match onto.placement() {
            Some(placement) => made.with_placement(*placement),
            None => made,
        })
    }

    /// Values of all voxels of `grid`; zero where `value` has none.
    fn put_at<T: Voxel + Plain + Zeroable>(
        &self,
        grid: &Grid,
        value: impl Fn(DVec3) -> Option<T> + Sync,
    ) -> Result<Vec<T>> {
        let [nx, ny, _] = grid.dims();
        let mut values = memory::zeroed::<T>(grid.voxels(), "the resampled volume", SMALLER_VOLUME)?;
        values.par_chunks_mut(nx).enumerate().for_each(|(row, line)| {
            stop::point();
            let [y, z] = [row % ny, row / ny].map(|at| at as f64);
            for (x, out) in line.iter_mut().enumerate() {
                if let Some(value) = value(DVec3::new(x as f64, y, z)) {
                    *out = value;
                }
            }
        });
        Ok(values)
    }

    /// Raw value of the voxel nearest to `voxel`; `None` beyond the volume.
    fn nearest(&self, voxel: DVec3) -> Option<f64> {
        let at = inside(voxel, self.grid())?.round();
        let value = self.value(at.to_array().map(|at| at as usize));
        Some((value - self.rescale().intercept) / self.rescale().slope)
    }

    /// Trilinear value at `voxel`; `None` beyond the volume.
    fn interpolated(&self, voxel: DVec3) -> Option<f64> {
        let at = inside(voxel, self.grid())?;
        let low = at.floor();
        let f = at - low;
        let low = low.to_array().map(|at| at as usize);
        let high: [usize; 3] = std::array::from_fn(|a| (low[a] + 1).min(self.grid().dims()[a] - 1));
        let corner = |corner: usize| {
            let pick = |a: usize| if corner >> a & 1 == 1 { (high[a], f[a]) } else { (low[a], 1.0 - f[a]) };
            let [x, y, z] = [pick(0), pick(1), pick(2)];
            let weight = x.1 * y.1 * z.1;
            if weight == 0.0 { 0.0 } else { weight * self.value([x.0, y.0, z.0]) }
        };
        Some((0..8).map(corner).sum())
    }
}

/// `voxel` clamped to the centres of the voxels of `grid`; `None` beyond the box.
fn inside(voxel: DVec3, grid: &Grid) -> Option<DVec3> {
    let last = DVec3::from_array(grid.dims().map(|dim| (dim - 1) as f64));
    let is_inside = voxel.cmpge(DVec3::splat(-0.5 - SAME)).all() && voxel.cmple(last + 0.5 + SAME).all();
    is_inside.then(|| voxel.clamp(DVec3::ZERO, last))
}

/// Placements of `volume` and `onto`, if they are in one space.
fn spaces<'a>(volume: &'a Volume, onto: &'a Volume) -> Option<[&'a Placement; 2]> {
    let [own, other] = [volume.placement()?, onto.placement()?];
    (own.space() == other.space()).then_some([own, other])
}

/// Map from continuous indices of one grid to those of another.
struct Map {
    matrix: DMat3,
    first: DVec3,
}

impl Map {
    /// Map from indices of `onto` to those of `volume`.
    fn new(volume: &Volume, onto: &Volume) -> Self {
        let sides = |grid: &Grid| DVec3::from_array(grid.spacing());
        if let Some([own, other]) = spaces(volume, onto) {
            let to_voxels = DMat3::from_diagonal(sides(volume.grid()).recip()) * own.directions().inverse();
            return Self {
                matrix: to_voxels * other.directions() * DMat3::from_diagonal(sides(onto.grid())),
                first: to_voxels * (other.origin() - own.origin()),
            };
        }
        let dims = |volume: &Volume| DVec3::from_array(volume.grid().dims().map(|dim| dim as f64));
        let ratio = dims(volume) / dims(onto);
        Self { matrix: DMat3::from_diagonal(ratio), first: 0.5 * ratio - 0.5 }
    }

    fn at(&self, voxel: DVec3) -> DVec3 {
        self.matrix * voxel + self.first
    }

    /// Whether any of some thousand places of `onto` lies in `grid`.
    fn meets(&self, grid: &Grid, onto: &Grid) -> bool {
        /// Places along each axis.
        const PLACES: usize = 24;
        let last = DVec3::from_array(onto.dims().map(|dim| (dim - 1) as f64));
        let part = |at: usize| at as f64 / (PLACES - 1) as f64;
        (0..PLACES.pow(3)).any(|i| {
            let place = [i % PLACES, i / PLACES % PLACES, i / PLACES.pow(2)].map(part);
            inside(self.at(DVec3::from_array(place) * last), grid).is_some()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contents, Space};

    fn ramp(dims: [usize; 3], spacing: f64) -> Volume {
        let grid = Grid::new(dims, [spacing; 3]).unwrap();
        let values = (0..grid.voxels()).map(|i| ((i % dims[0]) as f64 * spacing + 0.5 * spacing) as f32);
        Volume::from_values(grid, values.collect()).unwrap()
    }

    fn placed(volume: Volume, directions: DMat3, origin: [f64; 3]) -> Volume {
        volume.with_placement(Placement::new(directions, origin.into(), Space::Patient).unwrap())
    }

    #[test]
    fn volumes_without_positions_fill_the_same_box() {
        let (coarse, fine) = (ramp([4, 3, 2], 2.0), ramp([8, 6, 4], 1.0));
        assert_eq!(coarse.alignment(&fine), Alignment::Box);
        let resampled = coarse.resampled(&fine).unwrap();
        assert_eq!(resampled.grid(), fine.grid());
        for x in 1..7 {
            assert!((resampled.value([x, 2, 1]) - fine.value([x, 2, 1])).abs() < 1e-6, "{x}");
        }
        assert_eq!(fine.alignment(&fine), Alignment::Same);
        assert_eq!(resampled.range(), coarse.range());
    }

    #[test]
    fn positions_in_one_space_decide_and_nothing_lies_beyond() {
        let first = placed(ramp([8, 4, 4], 1.0), DMat3::IDENTITY, [0.0; 3]);
        // Mirrored along x and begun two voxels later: voxel i lies at 9 − i.
        let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let other = placed(ramp([8, 4, 4], 1.0), mirrored, [9.0, 0.0, 0.0]);
        assert_eq!(other.alignment(&first), Alignment::Space);
        let resampled = other.resampled(&first).unwrap();
        assert!(resampled.value([0, 0, 0]).is_nan() && resampled.value([1, 0, 0]).is_nan());
        for x in 2..8 {
            assert_eq!(resampled.value([x, 1, 1]), 9.0 - x as f64 + 0.5, "{x}");
        }
        let far = placed(ramp([8, 4, 4], 1.0), DMat3::IDENTITY, [100.0, 0.0, 0.0]);
        assert!(far.resampled(&first).unwrap_err().to_string().contains("do not overlap"));
    }

    #[test]
    fn labels_stay_labels() {
        let grid = Grid::new([4, 1, 1], [2.0; 3]).unwrap();
        let contents = Contents { are_labels: true, ..Contents::default() };
        let labels = Volume::from_values(grid, vec![7u8, 0, 3, 3]).unwrap().with_contents(contents);
        let labels = placed(labels, DMat3::IDENTITY, [0.5, 0.0, 0.0]);
        let first = placed(ramp([9, 1, 1], 1.0), DMat3::IDENTITY, [0.0; 3]);
        let resampled = labels.resampled(&first).unwrap();
        assert!(resampled.is_label_map());
        let values: Vec<f64> = (0..9).map(|x| resampled.value([x, 0, 0])).collect();
        assert_eq!(values, [7.0, 7.0, 0.0, 0.0, 3.0, 3.0, 3.0, 3.0, 0.0]);
    }
}
