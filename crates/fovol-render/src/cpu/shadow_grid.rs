use super::light_sweep::LightSweep;
use crate::scene::{Bricks, FIRST_STRETCH, LightPath, LightSlices, TransferTable};
use fovol_core::memory::Shortage;
use fovol_core::{ClipBox, TransferFunction};
use fovol_simd::Simd;

/// Transmittance towards the light of every voxel, in 8 bits.
///
/// Light is swept through the volume slice by slice. The grid is a cheap alternative to shadow rays, never the reference.
///
/// # Errors
/// Too little memory.
pub fn shadow_grid(
    bricks: &Bricks,
    clip: &ClipBox,
    path: &LightPath,
    (transfer, table, step): (&TransferFunction, &TransferTable, f64),
    simd: Simd,
) -> Result<Bricks, Shortage> {
    let slices = LightSlices::new(bricks.layout().dims, path);
    let of = |slices_passed: f64| table.transmittance(transfer, step * slices.steps * slices_passed);
    let [transmittance, near_transmittance] = [1.0, FIRST_STRETCH].map(of);
    let sweep = LightSweep {
        bricks,
        slices,
        clip: clip.in_voxels(),
        transmittance: &transmittance,
        near_transmittance: &near_transmittance,
        first_sample: path.delta.map(|delta| slices.near() * slices.steps as f32 * delta),
        simd,
    };
    let swept = sweep.swept()?;
    Bricks::of_bytes(bricks.layout().dims, |voxel, line| swept.put(voxel, line))
}
