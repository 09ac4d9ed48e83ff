use super::domain::Domain;
use super::fourier::Resampler;
use super::navier_stokes::{Components, Flow};
use fovol_core::{Result, Volume, stop};
use rayon::prelude::*;

/// The size of the largest eddies: three to the edge of the cube.
const PEAK: f32 = 3.0;

/// How long the flow runs, where the edge of the cube is 2π and the initial speed 1: until vortex tubes
/// have formed.
const DURATION: f32 = 2.2;

/// Vorticity magnitude of decaying turbulence.
///
/// The solver runs on a grid of 32³ for requests up to 48³, of 64³ up to 128³ and of 96³ above. Fourier
/// interpolation then evaluates the flow at the requested voxels. It is exact, because the flow is band-limited.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let n = resolution(domain.grid().dims());
    let mut flow = Flow::random(n, viscosity(n), PEAK, domain.seed(0));
    flow.run(DURATION);
    Volume::from_values(domain.grid(), magnitude(&flow.vorticity(), n, domain)?)
}

fn resolution(dims: [usize; 3]) -> usize {
    match dims.into_iter().fold(0, usize::max) {
        0..=48 => 32,
        49..=128 => 64,
        _ => 96,
    }
}

/// The viscosity at which the smallest eddies (Kolmogorov's length, with a dissipation of about 1)
/// are just resolved by `n` points.
fn viscosity(n: usize) -> f32 {
    0.8 * (n as f32 / 3.0).powf(-4.0 / 3.0)
}

fn magnitude([x, y, z]: &Components, n: usize, domain: &Domain) -> Result<Vec<f32>> {
    let dims = domain.grid().dims();
    let plane = dims[0] * dims[1];
    let mut squares: Vec<f32> = domain.zeros()?;
    // One component at a time: the intermediate sums of a large request fill memory.
    for component in [x, y, z] {
        let resampler = Resampler::new(component, n, dims);
        squares.par_chunks_mut(plane).enumerate().for_each(|(z, out)| {
            stop::point();
            for (square, value) in out.iter_mut().zip(resampler.slice(z)) {
                *square += value.re * value.re;
            }
        });
    }
    squares.par_iter_mut().for_each(|square| *square = square.sqrt());
    Ok(squares)
}
