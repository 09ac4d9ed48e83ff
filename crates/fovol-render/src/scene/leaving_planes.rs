use fovol_core::{ClipPlanes, Grid};

/// Planes that light crosses on its way out of what is shown, for points in voxel-centre coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeavingPlanes {
    /// Weights of x, y, z and a constant. Their sum is the number of primary steps from a point to the plane.
    steps: [[f32; 4]; ClipPlanes::MOST],
    count: usize,
}

impl LeavingPlanes {
    /// Planes of `planes` that light crosses outwards; `delta` is a primary step towards it, in voxels of `grid`.
    pub fn new(planes: &ClipPlanes, grid: &Grid, delta: [f32; 3]) -> Self {
        let mut all = Self { steps: [[0.0; 4]; ClipPlanes::MOST], count: 0 };
        for plane in planes.in_voxels(grid) {
            let nearer: f64 = (0..3).map(|a| plane[a] * f64::from(delta[a])).sum();
            if nearer < 0.0 {
                all.steps[all.count] = plane.map(|weight| (weight / -nearer) as f32);
                all.count += 1;
            }
        }
        all
    }

    /// One array for each plane.
    pub fn as_slice(&self) -> &[[f32; 4]] {
        &self.steps[..self.count]
    }
}
