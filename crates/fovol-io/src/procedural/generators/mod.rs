//! The generators, one file for each kind of volume.

mod angiogram;
mod cellular_noise;
mod domain;
mod engine;
mod fourier;
mod gradient_noise;
mod grain;
mod head;
mod marschner_lobb;
mod navier_stokes;
mod plume;
mod reptile;
mod seeded;
mod shapes;
mod spine_curve;
mod supernova;
mod vessels;
mod vortices;

use super::{Error, MAX_VOXELS, MIN_SIDE, Procedural, Result};
use domain::Domain;
use fovol_core::Volume;
use fovol_core::memory::Estimate;

/// Advice for volumes that do not fit in memory.
const FEWER_VOXELS: &str = "smaller --dims need less";

/// Makes the volume `kind` with `dims` voxels along x, y and z.
///
/// The seed changes the shapes that are random; [`Procedural::MarschnerLobb`] has none.
///
/// # Errors
/// [`Error::Size`] for fewer than [`MIN_SIDE`] voxels along an axis or more than [`MAX_VOXELS`] in all;
/// [`Error::Memory`] if they do not fit in memory.
pub fn make(kind: Procedural, dims: [usize; 3], seed: u64) -> Result<Volume> {
    let voxels = dims.iter().try_fold(1usize, |product, &side| product.checked_mul(side));
    if dims.iter().any(|&side| side < MIN_SIDE) || voxels.is_none_or(|count| count > MAX_VOXELS) {
        return Err(Error::Size { dims });
    }
    let [x, y, z] = dims;
    let needed = Estimate::new(format!("making {kind} of {x}x{y}x{z} voxels"));
    needed.with("voxels", (x * y * z * kind.dtype().size()) as u64).check(FEWER_VOXELS)?;
    let domain = Domain::new(dims, seed)?;
    let volume = match kind {
        Procedural::Vortices => vortices::make(&domain),
        Procedural::Supernova => supernova::make(&domain),
        Procedural::Head => head::make(&domain),
        Procedural::Engine => engine::make(&domain),
        Procedural::Angiogram => angiogram::make(&domain),
        Procedural::Reptile => reptile::make(&domain),
        Procedural::Plume => plume::make(&domain),
        Procedural::MarschnerLobb => marschner_lobb::make(&domain),
    }?;
    Ok(volume.with_format(format!("procedural ({kind})")))
}

#[cfg(test)]
mod tests;
