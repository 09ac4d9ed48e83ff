use super::light_sweep::LightSweep;
use crate::scene::{Bricks, FIRST_STRETCH, LightPath, LightSlices, SWEEP_STEP, TransferTable};
use fovol_core::memory::Shortage;
use fovol_core::{ClipBox, Grid, TransferFunction};
use fovol_simd::Simd;
use std::time::{Duration, Instant};

/// Transmittance towards the light of every voxel, in 8 bits.
///
/// Light is swept through the volume slice by slice. The grid is a cheap alternative to shadow rays, never the reference.
#[derive(Debug)]
pub struct ShadowGrid {
    /// The transmittances.
    pub voxels: Bricks,
    /// How long they took to make.
    pub took: Duration,
}

impl ShadowGrid {
    /// Sweeps light along `path`, whose step is [`SWEEP_STEP`].
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(
        bricks: &Bricks,
        (grid, clip): (&Grid, &ClipBox),
        path: &LightPath,
        (transfer, table): (&TransferFunction, &TransferTable),
        simd: Simd,
    ) -> Result<Self, Shortage> {
        let started = Instant::now();
        let slices = LightSlices::new(bricks.layout().dims, path);
        let of =
            |slices_passed: f64| table.transmittance(transfer, SWEEP_STEP * slices.steps * slices_passed);
        let [transmittance, near_transmittance] = [1.0, FIRST_STRETCH].map(of);
        let planes: Vec<[f32; 4]> =
            clip.planes().in_voxels(grid).map(|plane| plane.map(|weight| weight as f32)).collect();
        let sweep = LightSweep {
            bricks,
            slices,
            clip: clip.in_voxels(),
            planes: &planes,
            transmittance: &transmittance,
            near_transmittance: &near_transmittance,
            first_sample: path.delta.map(|delta| slices.near() * slices.steps as f32 * delta),
            simd,
        };
        let swept = sweep.swept()?;
        let voxels = Bricks::of_bytes(bricks.layout().dims, |voxel, line| swept.put(voxel, line))?;
        Ok(Self { voxels, took: started.elapsed() })
    }
}
