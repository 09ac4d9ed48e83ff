//! A further volume of a scene, prepared for marching on the CPU.

use crate::scene::{Bricks, Macrocells};
use fovol_core::{Layer, TransferFunction, VoxelColours};

/// A further volume of a scene.
#[derive(Debug)]
pub struct PreparedLayer {
    pub bricks: Bricks,
    /// Red, green and blue of the voxels, where they have colours.
    pub colours: Option<[Bricks; 3]>,
    pub transfer: TransferFunction,
    /// Lengths of the gradients, once the opacity depended on them.
    pub gradients: Option<Bricks>,
    /// Where it may show anything.
    pub cells: Macrocells,
}

impl PreparedLayer {
    /// Prepares `layer`.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(layer: &Layer) -> fovol_core::Result<Self> {
        let mut bricks = Bricks::of_volume(&layer.volume)?;
        bricks.set_interpolation(layer.interpolation);
        let cells = Macrocells::new(&bricks)?;
        let colours = layer.colours.as_ref().map(bricks_of_colours).transpose()?;
        Ok(Self { bricks, colours, gradients: None, transfer: layer.transfer_function.clone(), cells })
    }

    /// Goes over to the transfer function and interpolation of `layer`; returns whether anything changed.
    pub fn change(&mut self, layer: &Layer) -> bool {
        let is_new =
            self.transfer != layer.transfer_function || self.bricks.interpolation() != layer.interpolation;
        self.transfer = layer.transfer_function.clone();
        let gradients = self.gradients.as_mut();
        gradients
            .into_iter()
            .chain([&mut self.bricks])
            .for_each(|b| b.set_interpolation(layer.interpolation));
        is_new
    }
}

/// Red, green and blue of `colours` as bricks.
///
/// # Errors
/// Too little memory.
pub fn bricks_of_colours(colours: &VoxelColours) -> fovol_core::Result<[Bricks; 3]> {
    let [r, g, b] = colours.each_ref().map(|channel| Bricks::of_volume(channel));
    Ok([r?, g?, b?])
}
