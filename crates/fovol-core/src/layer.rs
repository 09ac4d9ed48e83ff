use crate::{Error, Grid, Interpolation, Result, TransferFunction, Volume};
use std::sync::Arc;

/// Most volumes of a scene.
pub const MOST_VOLUMES: usize = 4;

/// Red, green and blue of every voxel, as display values.
pub type VoxelColours = [Arc<Volume>; 3];

/// A further volume of a scene, sampled at the same points as the first: it has the same number of voxels along each axis.
///
/// Opacities add as extinctions, and colours weigh by their extinction.
#[derive(Debug, Clone)]
pub struct Layer {
    /// The volume.
    pub volume: Arc<Volume>,
    /// Mapping from its values to colour and opacity.
    pub transfer_function: TransferFunction,
    /// Colours of its voxels, which take the place of the transfer function's.
    pub colours: Option<VoxelColours>,
    /// How values between its voxels are found.
    pub interpolation: Interpolation,
}

/// Checks that `volumes` have as many voxels along each axis as `grid`.
pub(crate) fn check_dims<'a>(volumes: impl IntoIterator<Item = &'a Arc<Volume>>, grid: &Grid) -> Result<()> {
    for volume in volumes {
        let [own, first] = [volume.grid().dims(), grid.dims()];
        if own != first {
            return Err(Error::Layers(format!(
                "one has {own:?} voxels and the first {first:?}; resample one of them"
            )));
        }
    }
    Ok(())
}
