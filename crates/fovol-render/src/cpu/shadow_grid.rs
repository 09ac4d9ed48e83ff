use super::light_sweep::{LightSweep, Swept};
use super::prepared::ColouredVolume;
use crate::scene::{Bricks, FIRST_STRETCH, LightPath, LightSlices, SWEEP_STEP};
use fovol_core::memory::Shortage;
use fovol_core::{ClipBox, Grid};
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
    /// Sweeps light through all of `volumes` along `path`, whose step is [`SWEEP_STEP`].
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(
        volumes: &[ColouredVolume<'_>],
        (grid, clip): (&Grid, &ClipBox),
        path: &LightPath,
        simd: Simd,
    ) -> Result<Self, Shortage> {
        let started = Instant::now();
        let slices = LightSlices::new(grid.dims(), path);
        let planes: Vec<[f32; 4]> =
            clip.planes().in_voxels(grid).map(|plane| plane.map(|weight| weight as f32)).collect();
        let mut swept = Vec::with_capacity(volumes.len());
        for ColouredVolume { bricks, transfer, table, gradient } in volumes {
            let of = |passed: f64| {
                let length = SWEEP_STEP * slices.steps * passed;
                match gradient {
                    Some(_) => table.depths(transfer, length),
                    None => table.transmittance(transfer, length),
                }
            };
            let [transmittance, near_transmittance] = [1.0, FIRST_STRETCH].map(of);
            let sweep = LightSweep {
                bricks,
                slices,
                clip: clip.in_voxels(),
                planes: &planes,
                transmittance: &transmittance,
                near_transmittance: &near_transmittance,
                gradient: *gradient,
                first_sample: path.delta.map(|delta| slices.near() * slices.steps as f32 * delta),
                simd,
            };
            swept.push(sweep.swept()?);
        }
        let voxels = Bricks::of_bytes(grid.dims(), |voxel, line| put_product(&swept, voxel, line))?;
        Ok(Self { voxels, took: started.elapsed() })
    }
}

/// Writes the product of the transmittances `swept` of a line of voxels along x, from `voxel` on.
fn put_product(swept: &[Swept], voxel: [usize; 3], line: &mut [u8]) {
    let Some((first, others)) = swept.split_first() else { return line.fill(u8::MAX) };
    first.put(voxel, line);
    let mut more = vec![0; if others.is_empty() { 0 } else { line.len() }];
    for other in others {
        other.put(voxel, &mut more);
        for (product, &other) in line.iter_mut().zip(&more) {
            *product = ((u32::from(*product) * u32::from(other) + 127) / 255) as u8;
        }
    }
}
