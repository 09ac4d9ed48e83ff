//! Properties of a volume that the user sets in place of its file's metadata.

use super::Source;
use super::layout::placed;
use crate::Result;
use fovol_core::{Dtype, Endian, Grid, Volume};
use std::path::Path;
use std::sync::Arc;

/// Properties of a volume that the user sets in place of its file's metadata, and the part to read.
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
    /// The name of the array of values to read.
    pub array: Option<String>,
    /// Which value of each voxel is shown, from 0 on.
    pub component: Option<usize>,
    /// Which channel is read, from 0 on.
    pub channel: Option<usize>,
    /// Which time point is read, from 0 on.
    pub time: Option<usize>,
    /// Which level of resolution is read, from 0 on, the finest; by default the finest that fits in memory.
    pub level: Option<usize>,
    /// Which series of a DICOM folder is read: its identifier, or its number from 1 on as the series are listed.
    pub series: Option<String>,
}

impl Overrides {
    /// `volume` as the user wants it: its bytes seen in another size, type or order, and other numbers to go
    /// with them. Nothing is copied.
    ///
    /// # Errors
    /// More voxels than there are bytes; a spacing or range that no volume has.
    pub fn apply(&self, source: &Source, volume: Volume) -> Result<Volume> {
        let volume = self.chosen(source, volume)?;
        let mut volume = self.recast(volume).map_err(|e| source.malformed(e.to_string()))?;
        if let Some(spacing) = self.spacing {
            volume = volume.with_spacing(spacing).map_err(|e| source.malformed(e.to_string()))?;
        }
        if let Some(range) = self.range {
            volume = volume.with_range(range).map_err(|e| source.malformed(e.to_string()))?;
        }
        Ok(volume)
    }

    /// These choices with the array of a name such as `FILE:ARRAY`.
    ///
    /// # Errors
    /// Another array is chosen already.
    pub(super) fn with_array(&self, file: &Path, array: String) -> Result<Self> {
        match &self.array {
            Some(other) if *other != array => Err(crate::Error::malformed(
                file,
                format!("its name chooses the array {array}, --array {other}; leave one of them out"),
            )),
            _ => Ok(Self { array: Some(array), ..self.clone() }),
        }
    }

    /// The time point to read of `count`.
    ///
    /// # Errors
    /// A choice out of range.
    pub(super) fn time_of(&self, source: &Source, count: usize) -> Result<usize> {
        part(source, ["--time", "time point"], self.time, count)
    }

    /// The channel to read of `count`.
    ///
    /// # Errors
    /// A choice out of range.
    pub(super) fn channel_of(&self, source: &Source, count: usize) -> Result<usize> {
        part(source, ["--channel", "channel"], self.channel, count)
    }

    /// The level of resolution to read of `count`, if one is chosen.
    ///
    /// # Errors
    /// A choice out of range.
    pub(super) fn level_of(&self, source: &Source, count: usize) -> Result<Option<usize>> {
        let level = part(source, ["--level", "level"], self.level, count)?;
        Ok(self.level.map(|_| level))
    }

    /// The component to show of `count`.
    ///
    /// # Errors
    /// A choice out of range.
    pub(super) fn component_of(&self, source: &Source, count: usize) -> Result<usize> {
        part(source, ["--component", "component"], self.component, count)
    }

    /// The error for an array that is none of `names`.
    pub(super) fn no_array(source: &Source, name: &str, names: &[String]) -> crate::Error {
        let name = name.escape_debug();
        source.malformed(match names {
            [] => format!("--array {name}: arrays have no names in it; leave the flag out"),
            names => format!("--array {name} is not there; it has {}", names.join(", ")),
        })
    }

    /// `volume` with the chosen component, after a check that every choice was there.
    fn chosen(&self, source: &Source, volume: Volume) -> Result<Volume> {
        let contents = volume.contents();
        if let Some(name) = &self.array
            && !contents.arrays.iter().any(|array| array.trim_matches('/') == name.trim_matches('/'))
        {
            return Err(Self::no_array(source, name, &contents.arrays));
        }
        self.time_of(source, contents.times)?;
        self.channel_of(source, contents.channels.len().max(1))?;
        self.level_of(source, contents.levels)?;
        let component = self.component_of(source, contents.components)?;
        match volume.components() > 1 {
            true => volume.with_component(component).map_err(|e| source.malformed(e.to_string())),
            false => Ok(volume),
        }
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

/// The `chosen` index of `count`, set by `flag`; 0 by default.
fn part(source: &Source, [flag, what]: [&str; 2], chosen: Option<usize>, count: usize) -> Result<usize> {
    match chosen {
        Some(index) if index >= count => Err(source.malformed(match count {
            0 | 1 => format!("{flag} {index} is not there; it has one {what}, number 0"),
            _ => format!("{flag} {index} is not there; it has {count} {what}s, 0 to {}", count - 1),
        })),
        chosen => Ok(chosen.unwrap_or(0)),
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
