//! Spacing of a dataset from its attributes and dimension scales.

use super::file::{File, Named, attributes};
use crate::volume::array_axes::ArrayAxes;
use crate::volume::cf::{Attribute, Attributes, Coordinate, Spaced};
use crate::volume::reals;
use hdf5_reader::Dataset;

/// Longest axis whose coordinates are read.
const LONGEST: usize = 1 << 16;

/// A dimension scale: the name of an axis, and its coordinates if it has any.
#[derive(Clone)]
pub struct Scale<'a> {
    /// The name of the axis.
    pub name: String,
    dataset: &'a Dataset,
}

impl Scale<'_> {
    /// The unit of the coordinates.
    pub fn units(&self) -> Option<String> {
        attributes(&self.dataset.attributes()).text("units").map(str::to_owned)
    }

    /// The coordinates, if there are any.
    fn coordinate(&self) -> Option<Coordinate> {
        let described = attributes(&self.dataset.attributes());
        // NetCDF marks axes without coordinates so.
        if described.text("NAME").is_some_and(|name| name.starts_with("This is a netCDF dimension but not")) {
            return None;
        }
        let length = *self.dataset.shape().first().filter(|_| self.dataset.ndim() == 1)?;
        let element = super::element::Element::of(self.dataset.dtype()).ok()?;
        if length > LONGEST as u64 {
            return None;
        }
        let bytes = self.dataset.read_raw_bytes().ok()?;
        let values = reals::decoded(&bytes, element.dtype, element.endian);
        // A scale that was attached but never filled.
        if values.len() > 1 && values.iter().all(|&value| value == 0.0) {
            return None;
        }
        let [factor, offset] = ["scale_factor", "add_offset"].map(|name| described.number(name));
        let values =
            values.iter().map(|value| value * factor.unwrap_or(1.0) + offset.unwrap_or(0.0)).collect();
        Some(Coordinate {
            name: self.name.clone(),
            values,
            units: described.text("units").map(str::to_owned),
        })
    }
}

/// The dimension scale of each axis of `dataset`, found among `all` datasets.
pub fn scales<'a>(file: &File<'_>, dataset: &Dataset, all: &'a [Named]) -> Vec<Option<Scale<'a>>> {
    let list = dataset.attributes().into_iter().find(|attribute| attribute.name == "DIMENSION_LIST");
    let (Some(list), size) = (list, dataset.vlen_reference_size()) else { return Vec::new() };
    let entries = list.raw_data.chunks_exact(size).take(dataset.ndim());
    entries
        .map(|entry| {
            let reference = dataset.resolve_vlen_reference_bytes(entry, file.reference_size()).ok()?;
            let mut address = [0; 8];
            let known = reference.get(..file.reference_size().min(8))?;
            address[..known.len()].copy_from_slice(known);
            let address = u64::from_le_bytes(address);
            let (path, scale) = all.iter().find(|(_, dataset)| dataset.address() == address)?;
            Some(Scale { name: path.rsplit('/').next().unwrap_or(path).to_owned(), dataset: scale })
        })
        .collect()
}

/// Names of the axes by the attribute `DIMENSION_LABELS`.
pub fn labels(dataset: &Dataset) -> Vec<Option<String>> {
    let found = dataset.attributes().into_iter().find(|attribute| attribute.name == "DIMENSION_LABELS");
    let names = found.and_then(|found| found.read_strings().ok()).unwrap_or_default();
    names.into_iter().map(|name| Some(name).filter(|name| !name.is_empty())).collect()
}

/// Whether `attributes` are those of a dimension scale rather than of a volume.
pub fn is_scale(attributes: &Attributes) -> bool {
    attributes.0.get("CLASS") == Some(&Attribute::Text("DIMENSION_SCALE".into()))
}

/// Spacing by the coordinates of `scales`.
pub fn of_scales(scales: &[Option<Scale<'_>>], axes: &ArrayAxes) -> Option<Spaced> {
    let along = axes.space.map(|axis| scales.get(axis?)?.as_ref()?.coordinate());
    Spaced::from_coordinates(&along)
}
