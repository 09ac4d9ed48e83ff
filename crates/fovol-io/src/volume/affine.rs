//! From the vectors of a header, one along each voxel axis, to spacing and placement.

use super::Source;
use crate::Result;
use fovol_core::{Placement, Space};
use glam::{DMat3, DVec3};

/// Vectors from voxel to voxel along x, y, z, and the centre of the first voxel, in LPS and the unit of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// The way to the next voxel along each axis.
    pub steps: [DVec3; 3],
    /// The centre of the first voxel.
    pub origin: DVec3,
}

impl Affine {
    /// The affine map with x and y of RAS coordinates turned round, as NIfTI has them.
    pub fn from_ras(steps: [DVec3; 3], origin: DVec3) -> Self {
        Self { steps, origin }.flipped(DVec3::new(-1.0, -1.0, 1.0))
    }

    /// The affine map with each coordinate multiplied by `signs`.
    #[must_use]
    pub fn flipped(self, signs: DVec3) -> Self {
        Self { steps: self.steps.map(|step| step * signs), origin: self.origin * signs }
    }

    /// The affine map of a flat image: an axis without a length gets one at right angles to the others.
    #[must_use]
    pub fn spanning(mut self) -> Self {
        let lengths = self.steps.map(DVec3::length);
        let is_flat = |length: f64| length == 0.0 || length.is_nan();
        if let [false, false, true] = lengths.map(is_flat) {
            self.steps[2] = self.steps[0].cross(self.steps[1]).normalize_or_zero();
        }
        self
    }

    /// The distance between voxels along each axis.
    pub fn spacing(&self) -> [f64; 3] {
        self.steps.map(DVec3::length)
    }

    /// Where the grid lies.
    ///
    /// # Errors
    /// Vectors that span no space or are not finite.
    pub fn placement(&self, source: &Source, space: Space) -> Result<Placement> {
        let [x, y, z] = self.steps;
        Placement::new(DMat3::from_cols(x, y, z), self.origin, space)
            .map_err(|e| source.malformed(format!("{e}; mend its header")))
    }
}
