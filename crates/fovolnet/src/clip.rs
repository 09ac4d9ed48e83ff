use crate::{Error, Result};
use fovol_core::{Camera, Volume};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// A part of a volume that is shown instead of the whole, as if the rest were empty.
///
/// The part is a volume of its own, whose longest side is 1 like that of any other: cameras around the whole become cameras
/// around the part that see the same.
#[derive(Debug, Clone)]
pub struct Clip {
    volume: Arc<Volume>,
    /// The middle of the part in the world of the whole.
    centre: DVec3,
    /// How much larger things are in the world of the part.
    scale: f64,
}

impl Clip {
    /// The part of `volume` within `sides`: from and to along x, then y, then z, as fractions of its box, rounded to whole
    /// voxels; the whole where there are none.
    ///
    /// # Errors
    /// Sides that are not within 0 and 1, or do not rise.
    pub fn new(volume: &Arc<Volume>, sides: Option<[f64; 6]>) -> Result<Self> {
        let whole = Self { volume: Arc::clone(volume), centre: DVec3::ZERO, scale: 1.0 };
        let Some(sides) = sides else { return Ok(whole) };
        let dims = volume.grid().dims();
        let part = voxels(sides, dims)?;
        if part.iter().zip(dims).all(|(range, dim)| range.len() == dim) {
            return Ok(whole);
        }
        let cut = volume.part(&part)?;
        let ends = part.map(|range| [range.start, range.end].map(|end| end as f64));
        let middle = DVec3::from_array(ends.map(|[from, to]| 0.5 * (from + to)));
        Ok(Self {
            centre: volume.grid().grid_to_world(middle),
            scale: cut.grid().smallest_voxel() / volume.grid().smallest_voxel(),
            volume: Arc::new(cut),
        })
    }

    /// The part, as a volume.
    pub fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// The camera that sees the part as `camera` sees it in the whole.
    pub fn camera(&self, camera: &Camera) -> Camera {
        let moved = |point: DVec3| (point - self.centre) * self.scale;
        Camera { eye: moved(camera.eye), target: moved(camera.target), ..*camera }
    }

    /// The distance in the world of the whole that is `distance` in that of the part.
    pub fn distance(&self, distance: f32) -> f32 {
        (f64::from(distance) / self.scale) as f32
    }
}

/// The voxels within `sides`, at least one along each axis.
fn voxels(sides: [f64; 6], dims: [usize; 3]) -> Result<[Range<usize>; 3]> {
    let mut part = [const { 0..0 }; 3];
    for axis in 0..3 {
        let [from, to] = [sides[2 * axis], sides[2 * axis + 1]];
        if !(0.0 <= from && from < to && to <= 1.0) {
            return Err(Error::Setting(format!(
                "{from},{to} is no part along {}; --clip takes X0,X1,Y0,Y1,Z0,Z1, each pair rising within 0 and 1",
                ["x", "y", "z"][axis]
            )));
        }
        let [start, end] = [from, to].map(|side| (side * dims[axis] as f64).round() as usize);
        let start = start.min(dims[axis] - 1);
        part[axis] = start..end.max(start + 1);
    }
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;

    fn volume() -> Arc<Volume> {
        let grid = Grid::new([10, 20, 5], [1.0, 0.5, 2.0]).unwrap();
        Arc::new(Volume::from_values(grid, (0..1000u16).collect()).unwrap())
    }

    #[test]
    fn parts_are_whole_voxels_and_keep_colours() {
        let whole = volume();
        let clip = Clip::new(&whole, Some([0.2, 0.5, 0.0, 1.0, 0.39, 0.81])).unwrap();
        let part = clip.volume();
        assert_eq!(part.grid().dims(), [3, 20, 2]);
        assert_eq!(part.range(), whole.range());
        assert_eq!(part.value([1, 7, 1]), whole.value([3, 7, 3]));
        let thin = Clip::new(&whole, Some([0.5, 0.5001, 0.999, 1.0, 0.0, 0.0001])).unwrap();
        assert_eq!(thin.volume().grid().dims(), [1, 1, 1]);
        assert_eq!(thin.volume().value([0; 3]), whole.value([5, 19, 0]));
        assert!(Arc::ptr_eq(
            Clip::new(&whole, Some([0.0, 1.0, 0.0, 1.0, 0.0, 1.0])).unwrap().volume(),
            &whole
        ));
    }

    #[test]
    fn cameras_see_the_same_places() {
        let whole = volume();
        let clip = Clip::new(&whole, Some([0.2, 0.5, 0.25, 0.75, 0.4, 0.8])).unwrap();
        let world = DVec3::new(0.1, -0.2, 0.3);
        let seen = clip.camera(&Camera::at(world, DVec3::ZERO, 30.0)).eye;
        let (whole_at, part_at) =
            (whole.grid().world_to_grid(world), clip.volume().grid().world_to_grid(seen));
        assert!((part_at + DVec3::new(2.0, 5.0, 2.0) - whole_at).length() < 1e-9);
    }

    #[test]
    fn sides_that_are_none_are_refused() {
        for bad in [[0.5, 0.2], [-0.1, 1.0], [0.0, 1.1], [0.3, 0.3], [f64::NAN, 1.0]] {
            let [from, to] = bad;
            let error = Clip::new(&volume(), Some([0.0, 1.0, from, to, 0.0, 1.0])).unwrap_err().to_string();
            assert!(error.contains("along y") && error.contains("--clip"), "{error}");
        }
    }
}
