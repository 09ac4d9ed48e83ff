//! Memory layout of voxels, as a header of any format describes it.

use super::Source;
use crate::Result;
use fovol_core::{Dtype, Endian, Grid, Placement, Volume, VoxelBytes};

/// Memory layout of a volume: size, type and order of the voxels in a block of bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The distance between voxels along x, y, z.
    pub spacing: [f64; 3],
    /// The type of one component.
    pub dtype: Dtype,
    /// The byte order.
    pub endian: Endian,
    /// Interleaved values per voxel.
    pub components: usize,
}

impl Layout {
    /// A scalar little-endian layout with unit spacing.
    pub fn new(dims: [usize; 3], dtype: Dtype) -> Self {
        Self { dims, spacing: [1.0; 3], dtype, endian: Endian::Little, components: 1 }
    }

    /// The number of components of all voxels.
    ///
    /// # Errors
    /// Sizes that no volume has, or more bytes than can be addressed.
    pub fn values(&self, source: &Source) -> Result<usize> {
        let voxels = self.grid(source)?.voxels();
        let values = voxels.checked_mul(self.components.max(1));
        // A Rust allocation ends at isize::MAX; what lies below can be multiplied by the size of a type.
        values.filter(|&values| values < isize::MAX as usize / 8).ok_or_else(|| {
            let [x, y, z] = self.dims;
            source.malformed(format!("{x}x{y}x{z} voxels of {} components are too many", self.components))
        })
    }

    /// The number of voxels, of a layout whose length is known to be sound.
    pub fn voxels(&self) -> usize {
        self.dims.iter().product()
    }

    /// The number of bytes of all voxels.
    ///
    /// # Errors
    /// Those of [`Self::values`].
    pub fn length(&self, source: &Source) -> Result<usize> {
        Ok(self.values(source)? * self.dtype.size())
    }

    /// The volume that begins `offset` bytes into `bytes`.
    ///
    /// # Errors
    /// Sizes or spacings that no volume has, or too few bytes.
    pub fn volume(&self, source: &Source, bytes: VoxelBytes, offset: usize) -> Result<Volume> {
        let grid = self.grid(source)?;
        Volume::with_layout(grid, self.dtype, self.endian, self.components, bytes, offset)
            .map_err(|e| source.malformed(e.to_string()))
    }

    fn grid(&self, source: &Source) -> Result<Grid> {
        Grid::new(self.dims, self.spacing).map_err(|e| source.malformed(e.to_string()))
    }
}

/// `volume` at `placement` with its spacing in `units`, where they are known.
pub fn placed(volume: Volume, placement: Option<Placement>, units: Option<&str>) -> Volume {
    let volume = match placement {
        Some(placement) => volume.with_placement(placement),
        None => volume,
    };
    match units {
        Some(units) => volume.with_units(units),
        None => volume,
    }
}

/// The spacing along up to three axes: 1 where it is not stated, and the absolute value where it is negative.
pub fn spacing_of(axes: &[f64]) -> [f64; 3] {
    std::array::from_fn(|axis| match axes.get(axis) {
        Some(spacing) if spacing.is_finite() => spacing.abs(),
        _ => 1.0,
    })
}

/// The first three of `sizes`; missing axes have one voxel. The rest is the number of volumes.
pub fn dims_of(sizes: &[usize]) -> ([usize; 3], Option<usize>) {
    let dims = std::array::from_fn(|axis| sizes.get(axis).copied().unwrap_or(1));
    let volumes = sizes.iter().skip(3).try_fold(1usize, |product, &size| product.checked_mul(size));
    (dims, volumes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn absurd_sizes_are_errors() {
        let source = Source::from_bytes(Path::new("x"), vec![]);
        let huge = Layout { components: usize::MAX / 2, ..Layout::new([65536; 3], Dtype::F64) };
        assert!(huge.length(&source).unwrap_err().to_string().contains("too many"));
        assert!(Layout::new([0, 1, 1], Dtype::U8).length(&source).is_err());
        assert_eq!(Layout::new([2, 3, 4], Dtype::U16).length(&source).unwrap(), 48);
    }

    #[test]
    fn missing_axes_are_one() {
        assert_eq!(dims_of(&[5]), ([5, 1, 1], Some(1)));
        assert_eq!(dims_of(&[5, 4, 3, 2, 2]), ([5, 4, 3], Some(4)));
        assert_eq!(dims_of(&[1, 1, 1, usize::MAX, 2]), ([1; 3], None));
        assert_eq!(spacing_of(&[-2.0, f64::NAN]), [2.0, 1.0, 1.0]);
    }
}
