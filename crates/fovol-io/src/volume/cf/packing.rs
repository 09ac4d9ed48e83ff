//! Packed values: scale, offset, and values that mark voxels without data.

use super::Attributes;
use crate::volume::layout::placed;
use crate::volume::{Source, reals};
use crate::{Error, Result};
use fovol_core::memory::{self, SMALLER_VOLUME};
use fovol_core::{Dtype, Endian, Rescale, Volume, stop};
use std::sync::Arc;

/// Values decoded between two looks at whether to stop.
const PIECE: usize = 1 << 20;

/// Raw values that mark voxels without data.
#[derive(Debug, Clone, PartialEq)]
struct Marks {
    values: Vec<f64>,
    valid: [f64; 2],
}

impl Marks {
    fn of(attributes: &Attributes) -> Self {
        let values = ["_FillValue", "missing_value"].into_iter().flat_map(|name| attributes.numbers(name));
        let mut valid = [f64::NEG_INFINITY, f64::INFINITY];
        if let [low, high] = *attributes.numbers("valid_range") {
            valid = [low, high];
        }
        valid[0] = attributes.number("valid_min").unwrap_or(valid[0]);
        valid[1] = attributes.number("valid_max").unwrap_or(valid[1]);
        Self { values: values.copied().filter(|value| !value.is_nan()).collect(), valid }
    }

    fn is_empty(&self) -> bool {
        self.values.is_empty() && self.valid == [f64::NEG_INFINITY, f64::INFINITY]
    }

    fn contain(&self, raw: f64) -> bool {
        self.values.contains(&raw) || raw < self.valid[0] || raw > self.valid[1]
    }
}

/// `volume` with the scale and offset of its `attributes`, and NaN where they mark voxels without data. Nothing is
/// copied where no voxel is marked.
///
/// # Errors
/// A scale that no volume has, too little memory.
pub fn unpacked(source: &Source, volume: Volume, attributes: &Attributes) -> Result<Volume> {
    let marks = Marks::of(attributes);
    let marked = if marks.is_empty() { 0 } else { count(&volume, &marks) };
    let mut volume = if marked == 0 { volume } else { masked(source, &volume, &marks)? };
    if marked > 0 {
        volume = volume
            .with_note(format!("{marked} values are marked as missing by its attributes and become NaN"));
    }
    let slope = attributes.number("scale_factor").unwrap_or(1.0);
    let intercept = attributes.number("add_offset").unwrap_or(0.0);
    if (slope, intercept) == (1.0, 0.0) {
        return Ok(volume);
    }
    volume.with_rescale(Rescale { slope, intercept }).map_err(|e| source.malformed(e.to_string()))
}

/// Calls `visit` with every raw value.
fn for_each(volume: &Volume, mut visit: impl FnMut(f64)) {
    for piece in volume.data().chunks(PIECE * volume.dtype().size()) {
        stop::point();
        reals::for_each(piece, volume.dtype(), volume.endian(), &mut visit);
    }
}

fn count(volume: &Volume, marks: &Marks) -> usize {
    let mut count = 0;
    for_each(volume, |raw| count += usize::from(marks.contain(raw)));
    count
}

/// `volume` in floats that hold its values exactly, with NaN for those in `marks`.
fn masked(source: &Source, volume: &Volume, marks: &Marks) -> Result<Volume> {
    let dtype = match volume.dtype() {
        Dtype::U8 | Dtype::I8 | Dtype::U16 | Dtype::I16 | Dtype::F16 | Dtype::F32 => Dtype::F32,
        _ => Dtype::F64,
    };
    let values = volume.grid().voxels() * volume.components();
    let mut bytes: Vec<u8> = Vec::new();
    memory::reserve(
        &mut bytes,
        values * dtype.size(),
        "its values with NaN for missing ones",
        SMALLER_VOLUME,
    )
    .map_err(|shortage| Error::memory(source.path(), shortage))?;
    for_each(volume, |raw| {
        let value = if marks.contain(raw) { f64::NAN } else { raw };
        match dtype {
            Dtype::F32 => bytes.extend((value as f32).to_le_bytes()),
            _ => bytes.extend(value.to_le_bytes()),
        }
    });
    let cast =
        Volume::with_layout(*volume.grid(), dtype, Endian::Little, volume.components(), Arc::new(bytes), 0);
    let cast = cast.map_err(|e| source.malformed(e.to_string()))?;
    let cast = cast.with_format(volume.format()).with_notes_of(volume);
    Ok(placed(cast, volume.placement().copied(), volume.units()))
}

#[cfg(test)]
mod tests {
    use super::super::Attribute;
    use super::*;
    use fovol_core::Grid;
    use std::path::Path;

    fn read(values: Vec<i16>, attributes: &[(&str, &[f64])]) -> Volume {
        let grid = Grid::new([values.len(), 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, values).unwrap();
        let pairs =
            attributes.iter().map(|(name, value)| ((*name).to_owned(), Attribute::Numbers(value.to_vec())));
        unpacked(&Source::from_bytes(Path::new("x"), vec![]), volume, &Attributes(pairs.collect())).unwrap()
    }

    #[test]
    fn values_are_scaled_and_marked() {
        let volume = read(
            vec![1, -9, 3],
            &[("_FillValue", &[-9.0]), ("scale_factor", &[0.5]), ("add_offset", &[1.0])],
        );
        assert_eq!(
            (volume.dtype(), volume.value([0, 0, 0]), volume.value([2, 0, 0])),
            (Dtype::F32, 1.5, 2.5)
        );
        assert!(volume.value([1, 0, 0]).is_nan());
        assert!(volume.notes()[0].starts_with("1 values"));
    }

    #[test]
    fn nothing_is_copied_where_nothing_is_marked() {
        let volume = read(vec![1, 2, 3], &[("_FillValue", &[-9.0]), ("valid_range", &[0.0, 5.0])]);
        assert_eq!((volume.dtype(), volume.notes().len()), (Dtype::I16, 0));
        let volume = read(vec![1, 2, 7], &[("valid_range", &[0.0, 5.0])]);
        assert!(volume.value([2, 0, 0]).is_nan());
    }
}
