use super::bricks::{Bricks, half_resolution};
use super::march::{March, SampleCount};
use super::segment::LightPath;

/// The transmittance towards the light on a grid of half the volume's resolution, by the rule of shadow
/// rays: voxel *i* stands at the common corner of the volume's voxels 2i and 2i + 1.
///
/// Stored in 8 bits: this is the cheap alternative to shadow rays, never the reference.
pub fn shadow_grid(march: &March<'_>) -> Bricks {
    let light = LightPath::new(&march.shading.light, march.grid, march.step);
    Bricks::of_unit_values(half_resolution(march.grid), |voxel| {
        let p = voxel.map(|i| 2.0 * i as f32 + 0.5);
        march.transmittance(p, &light, &mut SampleCount::default())
    })
}
