use super::march::{March, SampleCount};
use crate::scene::{Bricks, half_resolution};
use fovol_core::memory::Shortage;

/// Computes the transmittance towards the light by shadow rays on a grid of half the volume's resolution, in 8 bits.
///
/// Voxel *i* stands at the common corner of the volume's voxels 2i and 2i + 1. Voxels outside the crop box have the
/// transmittance at the nearest point of its faces.
///
/// The grid is a cheap alternative to shadow rays, never the reference. Large volumes take minutes, so this is
/// [`fovol_core::LongWork`].
///
/// # Errors
/// Too little memory.
pub fn shadow_grid(march: &March<'_>) -> Result<Bricks, Shortage> {
    let light = march.light_path();
    let [low, high] = march.clip.in_voxels();
    Bricks::of_unit_values("parts of the cached shadows", half_resolution(march.grid), |voxel| {
        let p = std::array::from_fn(|a| (2.0 * voxel[a] as f32 + 0.5).clamp(low[a], high[a]));
        march.transmittance(p, &light, &mut SampleCount::default())
    })
}
