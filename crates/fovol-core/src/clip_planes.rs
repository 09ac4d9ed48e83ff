use crate::{Error, Grid, Result};
use glam::{DMat3, DVec3};

/// Plane that cuts away the side where normal·x is less than `distance`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClipPlane {
    /// Direction towards the side that is kept; of any length.
    pub normal: DVec3,
    /// Least normal·x of what is kept.
    pub distance: f64,
}

/// Up to [`ClipPlanes::MOST`] planes, in the world space of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClipPlanes {
    planes: [ClipPlane; Self::MOST],
    count: usize,
}

impl ClipPlanes {
    /// Most planes.
    pub const MOST: usize = 6;

    /// All of `planes`.
    ///
    /// # Errors
    /// More than [`Self::MOST`], numbers that are not finite, a normal of length 0.
    pub fn new(planes: &[ClipPlane]) -> Result<Self> {
        if planes.len() > Self::MOST {
            return Err(Error::Extent {
                what: "clip planes".into(),
                found: planes.len().to_string(),
                expected: format!("at most {}", Self::MOST),
            });
        }
        let mut all = Self { count: planes.len(), ..Self::default() };
        for (to, plane) in all.planes.iter_mut().zip(planes) {
            let DVec3 { x, y, z } = plane.normal;
            let is_known = plane.normal.is_finite() && plane.distance.is_finite();
            if !is_known || plane.normal.length_squared() < 1e-24 {
                return Err(Error::Extent {
                    what: "clip plane".into(),
                    found: format!("{x},{y},{z},{}", plane.distance),
                    expected: "a normal that is not zero and a distance, all finite".into(),
                });
            }
            *to = *plane;
        }
        Ok(all)
    }

    /// The planes.
    pub fn as_slice(&self) -> &[ClipPlane] {
        &self.planes[..self.count]
    }

    /// These planes in the space that `turn`, an orthogonal matrix, leads to.
    #[must_use]
    pub fn turned(&self, turn: &DMat3) -> Self {
        self.map(|plane| ClipPlane { normal: *turn * plane.normal, ..plane })
    }

    /// These planes in the space whose points are (x − `centre`)·`scale`.
    #[must_use]
    pub fn moved(&self, centre: DVec3, scale: f64) -> Self {
        self.map(|plane| ClipPlane { distance: (plane.distance - plane.normal.dot(centre)) * scale, ..plane })
    }

    /// Each plane as a weight of each coordinate and a constant, for voxel-centre coordinates of `grid` (voxel *i* at
    /// *i*). Their sum is 0 on the plane, and rises by 1 for each world unit along a unit normal.
    pub fn in_voxels(&self, grid: &Grid) -> impl Iterator<Item = [f64; 4]> {
        let (voxel, half) = (grid.voxel_size(), grid.world_extent() * 0.5);
        self.as_slice().to_vec().into_iter().map(move |plane| {
            let ClipPlane { normal, distance } = plane;
            let weights = normal * voxel;
            let [x, y, z] = weights.to_array();
            [x, y, z, weights.element_sum() * 0.5 - normal.dot(half) - distance]
        })
    }

    fn map(&self, change: impl Fn(ClipPlane) -> ClipPlane) -> Self {
        let mut changed = *self;
        changed.planes[..self.count].iter_mut().for_each(|plane| *plane = change(*plane));
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(x: f64, y: f64, z: f64, distance: f64) -> ClipPlane {
        ClipPlane { normal: DVec3::new(x, y, z), distance }
    }

    #[test]
    fn planes_are_the_same_in_every_space() {
        let grid = Grid::new([7, 30, 11], [0.3, 1.1, 0.7]).unwrap();
        let all = [plane(0.6, 0.8, 0.0, 0.1), plane(-1.0, 2.0, 0.5, -0.2)];
        let planes = ClipPlanes::new(&all).unwrap();
        let point = DVec3::new(0.12, -0.3, 0.05);
        let beyond = |planes: &ClipPlanes, point: DVec3| -> Vec<f64> {
            planes.as_slice().iter().map(|plane| plane.normal.dot(point) - plane.distance).collect()
        };
        let right = beyond(&planes, point);
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let at = grid.world_to_grid(point) - 0.5;
        let found: Vec<f64> =
            planes.in_voxels(&grid).map(|[x, y, z, w]| at.dot(DVec3::new(x, y, z)) + w).collect();
        assert!(near(&found, &right), "{found:?} {right:?}");
        let turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_Z, DVec3::X);
        assert!(near(&beyond(&planes.turned(&turn), turn * point), &right));
        let (centre, scale) = (DVec3::new(0.2, 0.1, -0.3), 2.5);
        let moved = beyond(&planes.moved(centre, scale), (point - centre) * scale);
        assert!(near(&moved, &right.iter().map(|x| x * scale).collect::<Vec<_>>()));
    }

    #[test]
    fn planes_that_are_none_are_refused() {
        for bad in
            [plane(0.0, 0.0, 0.0, 0.1), plane(f64::NAN, 0.0, 1.0, 0.0), plane(1.0, 0.0, 0.0, f64::INFINITY)]
        {
            assert!(ClipPlanes::new(&[bad]).is_err(), "{bad:?}");
        }
        assert!(ClipPlanes::new(&[plane(1.0, 0.0, 0.0, 0.0); 7]).is_err());
        assert_eq!(ClipPlanes::new(&[]).unwrap(), ClipPlanes::default());
    }
}
