//! The volumes of a renderer with what depends on their transfer functions.

use super::prepared::ColouredVolume;
use super::renderer::Renderer;
use crate::scene::{Bricks, greatest_gradient};
use fovol_core::memory::Shortage;
use fovol_core::{RayMode, Scene, TransferFunction};

impl Renderer {
    /// Whether samples blend several volumes, or have colours of their own.
    pub(super) fn is_layered(&self) -> bool {
        self.colours.is_some() || !self.layers.is_empty()
    }

    /// Whether samples are more than the values and the table of one volume: several volumes, colours of voxels, or
    /// opacity that depends on the gradient.
    pub(super) fn blends(&self) -> bool {
        self.is_layered() || self.transfer.gradient_opacity().is_some()
    }

    /// The first volume with its tables.
    pub(super) fn first(&self) -> ColouredVolume<'_> {
        let gradient = self.prepared.blending.first().and_then(|table| table.gradient.as_ref());
        ColouredVolume {
            bricks: &self.bricks,
            transfer: &self.transfer,
            table: &self.prepared.table,
            gradient: self.gradients.as_ref().zip(gradient),
        }
    }

    /// Every volume with its tables.
    pub(super) fn volumes(&self) -> impl Iterator<Item = ColouredVolume<'_>> {
        let tables = self.prepared.blending.iter().skip(1);
        let others = self.layers.iter().zip(tables).map(|(layer, table)| ColouredVolume {
            bricks: &layer.bricks,
            transfer: &layer.transfer,
            table: &table.transfer,
            gradient: layer.gradients.as_ref().zip(table.gradient.as_ref()),
        });
        std::iter::once(self.first()).chain(others)
    }

    /// Finds what is empty. Gradients are left out, so that cells may be thought visible, never wrongly empty.
    pub(super) fn classify(&mut self) {
        let others = self.layers.iter().map(|layer| (&layer.cells, &layer.transfer));
        self.cells.classify_with(&self.transfer, self.mode, others);
    }

    /// Makes the tables that blending needs.
    pub(super) fn prepare_blending(&mut self) {
        if self.blends() {
            let others = self.layers.iter().map(|layer| &layer.transfer);
            let all = std::iter::once(&self.transfer).chain(others);
            self.prepared.blend(all, greatest_gradient(&self.grid));
        }
    }

    /// Number of volumes of `scene` whose opacity depends on the gradient.
    pub(super) fn gradients_of(scene: &Scene) -> usize {
        let others = scene.layers.iter().map(|layer| &layer.transfer_function);
        let all = std::iter::once(&scene.transfer_function).chain(others);
        let depending = all.filter(|transfer| transfer.gradient_opacity().is_some()).count();
        if scene.mode == RayMode::Composite { depending } else { 0 }
    }

    /// Finds the lengths of the gradients on which the opacities of `scene` depend, unless they are known. Those that
    /// are no longer needed stay: a viewer goes back and forth.
    pub(super) fn find_gradients(&mut self, scene: &Scene) -> Result<(), Shortage> {
        if scene.mode != RayMode::Composite {
            return Ok(());
        }
        let mut are_new = false;
        let mut find = |transfer: &TransferFunction, bricks: &Bricks, lengths: &mut Option<Bricks>| {
            if transfer.gradient_opacity().is_some() && lengths.is_none() {
                *lengths = Some(bricks.gradient_lengths(&self.grid)?);
                are_new = true;
            }
            Ok(())
        };
        find(&scene.transfer_function, &self.bricks, &mut self.gradients)?;
        for (layer, new) in self.layers.iter_mut().zip(&scene.layers) {
            find(&new.transfer_function, &layer.bricks, &mut layer.gradients)?;
        }
        if are_new {
            self.shadow_grid = None;
        }
        Ok(())
    }
}
