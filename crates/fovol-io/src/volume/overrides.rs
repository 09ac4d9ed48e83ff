//! What a user says about a volume over the head of its file.

use super::Source;
use super::layout::placed;
use crate::Result;
use fovol_core::{Dtype, Endian, Grid, Volume};
use std::sync::Arc;

/// What a user says about a volume over the head of its file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// The type of one component.
    pub dtype: Option<Dtype>,
    /// The byte order.
    pub endian: Option<Endian>,
    /// The distance between voxels along x, y, z.
    pub spacing: Option<[f64; 3]>,
    /// The values shown as 0 and 1.
    pub range: Option<[f64; 2]>,
}

impl Overrides {
    /// `volume` as the user wants it: its bytes seen in another size, type or order, and other numbers to go
    /// with them. Nothing is copied.
    ///
    /// # Errors
    /// More voxels than there are bytes; a spacing or range that no volume has.
    pub fn apply(&self, source: &Source, volume: Volume) -> Result<Volume> {
        let mut volume = self.recast(volume).map_err(|e| source.malformed(e.to_string()))?;
        if let Some(spacing) = self.spacing {
            volume = volume.with_spacing(spacing).map_err(|e| source.malformed(e.to_string()))?;
        }
        if let Some(range) = self.range {
            volume = volume.with_range(range).map_err(|e| source.malformed(e.to_string()))?;
        }
        Ok(volume)
    }

    fn recast(&self, volume: Volume) -> fovol_core::Result<Volume> {
        let dims = self.dims.unwrap_or(volume.grid().dims());
        let dtype = self.dtype.unwrap_or(volume.dtype());
        let endian = self.endian.unwrap_or(volume.endian());
        if (dims, dtype, endian) == (volume.grid().dims(), volume.dtype(), volume.endian()) {
            return Ok(volume);
        }
        let grid = Grid::new(dims, volume.grid().spacing())?;
        let (components, rescale) = (volume.components(), volume.rescale());
        let format = volume.format().to_owned();
        let bytes = Arc::new(Bytes(volume.clone()));
        let cast = Volume::with_layout(grid, dtype, endian, components, bytes, 0)?;
        let cast = cast.with_rescale(rescale)?.with_format(format).with_notes_of(&volume);
        Ok(placed(cast, volume.placement().copied(), volume.units()))
    }
}

/// The bytes of a volume, kept alive by it.
struct Bytes(Volume);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        self.0.data()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::parse;
    use std::path::Path;

    fn header() -> Source {
        let text = b"NRRD0004\ntype: uint16\nsizes: 2 2 1\nspacings: 1 2 3\nendian: little\nencoding: raw\n\n\x01\0\x02\0\x03\0\x04\0";
        Source::from_bytes(Path::new("x.nrrd"), text.to_vec())
    }

    #[test]
    fn headers_are_outdone() {
        let overrides = Overrides {
            dims: Some([1, 2, 2]),
            endian: Some(Endian::Big),
            spacing: Some([1.0, 1.0, 5.0]),
            range: Some([0.0, 9.0]),
            ..Overrides::default()
        };
        let volume = parse(&header(), &overrides).unwrap();
        assert_eq!((volume.grid().dims(), volume.grid().spacing()), ([1, 2, 2], [1.0, 1.0, 5.0]));
        assert_eq!((volume.value([0, 1, 0]), volume.range()), (512.0, [0.0, 9.0]));
        assert_eq!(volume.format(), "NRRD");
    }

    #[test]
    fn nothing_is_made_up() {
        for overrides in [
            Overrides { dims: Some([3, 2, 1]), ..Overrides::default() },
            Overrides { dtype: Some(Dtype::F32), ..Overrides::default() },
            Overrides { spacing: Some([0.0; 3]), ..Overrides::default() },
            Overrides { range: Some([1.0, 1.0]), ..Overrides::default() },
        ] {
            let error = parse(&header(), &overrides).unwrap_err().to_string();
            assert!(error.starts_with("x.nrrd: ") && !error.contains('\n'), "{error}");
        }
    }
}
