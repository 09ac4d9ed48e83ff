//! An array without metadata of OME: its axes by their names, its spacing by coordinates or attributes.

use super::axes::Axes;
use super::chunks::Chunked;
use super::element::Element;
use super::hierarchy::{Hierarchy, joined};
use super::json::Object;
use super::metadata::{Array, Node};
use super::part::Part;
use super::window::Window;
use crate::Result;
use crate::volume::array_axes::ArrayAxes;
use crate::volume::cf::{
    Attribute, Attributes, Coordinate, Spaced, stated_spacing, unpacked, with_spacing_notes,
};
use crate::volume::{Overrides, reals};
use fovol_core::{Contents, Volume};
use serde_json::Value;

/// Longest axis whose coordinates are read.
const LONGEST: usize = 1 << 16;

/// An array at a path.
pub struct Bare<'a> {
    /// The hierarchy that it is in.
    pub hierarchy: &'a Hierarchy<'a>,
    /// Its path.
    pub path: &'a str,
    /// Its metadata.
    pub array: &'a Array,
}

impl Bare<'_> {
    /// The meaning of its axes.
    ///
    /// # Errors
    /// A shape that is no volume.
    pub fn axes(&self) -> std::result::Result<Axes, String> {
        let array = self.array;
        let first = array.names.first().and_then(Option::as_deref);
        let units = first
            .and_then(|name| self.coordinate_array(name))
            .and_then(|found| Some(found.attributes.get("units")?.as_str()?.to_owned()));
        Axes::guessed(&array.names, &array.shape, units)
    }

    /// How likely it is the volume of a file that holds others.
    pub fn rank(&self) -> Option<ArrayAxes> {
        let axes = self.axes().ok()?;
        let (dims, components) = (axes.dims(&self.array.shape), axes.counts(&self.array.shape)[2]);
        Some(ArrayAxes { dims, space: axes.space, times: 1, time: None, components, notes: Vec::new() })
    }

    /// Reads the chosen time point and channel.
    ///
    /// # Errors
    /// A shape that is no volume, and the errors of [`Part::volume`].
    pub fn volume(&self, overrides: &Overrides, contents: Contents) -> Result<Volume> {
        let source = self.hierarchy.source;
        let axes = self.axes().map_err(|problem| self.hierarchy.malformed(self.path, &problem))?;
        let attributes = attributes(self.array);
        let spaced = stated_spacing(&attributes).or_else(|| self.spaced(&axes));
        let spacing = spaced.as_ref().map_or([1.0; 3], |spaced| spaced.spacing);
        let chunked = Chunked { hierarchy: self.hierarchy, path: self.path, array: self.array };
        let volume = Part { chunked, axes }.volume(overrides, spacing, contents)?.with_format("Zarr");
        unpacked(source, with_spacing_notes(volume, spaced.as_ref(), overrides), &attributes)
    }

    /// Spacing by the arrays beside this one that have the names of its axes.
    fn spaced(&self, axes: &Axes) -> Option<Spaced> {
        let along = axes.space.map(|axis| {
            let name = self.array.names.get(axis?)?.as_deref()?;
            let found = self.coordinate_array(name)?;
            let values = self.values(name, &found)?;
            let units = found.attributes.get("units").and_then(Value::as_str).map(str::to_owned);
            (values.len() == self.array.shape[axis?]).then(|| Coordinate {
                name: name.to_owned(),
                values,
                units,
            })
        });
        Spaced::from_coordinates(&along)
    }

    /// The path of the array `name` beside this one.
    fn beside(&self, name: &str) -> Option<String> {
        let parent = self.path.rsplit_once('/').map_or("", |(parent, _)| parent);
        joined(parent, name).filter(|path| path != self.path)
    }

    /// The array of coordinates of the axis `name`.
    fn coordinate_array(&self, name: &str) -> Option<Box<Array>> {
        match self.hierarchy.node(&self.beside(name)?) {
            Ok(Some(Node::Array(Ok(array)))) if array.shape.len() == 1 => Some(array),
            _ => None,
        }
    }

    fn values(&self, name: &str, array: &Array) -> Option<Vec<f64>> {
        let (count, size) = (array.shape[0], array.element.size());
        if !(1..=LONGEST).contains(&count) {
            return None;
        }
        let window = Window::row(count, size);
        let path = self.beside(name)?;
        let bytes =
            Chunked { hierarchy: self.hierarchy, path: &path, array }.read(&window, count * size).ok()?;
        Some(reals::decoded(&bytes, array.element.dtype, array.element.endian))
    }
}

/// Attributes of an array that are numbers or text, with the mark of missing values that its fill value is.
pub fn attributes(array: &Array) -> Attributes {
    let mut found = attributes_of(&array.attributes);
    if array.fill_is_missing {
        let Element { dtype, endian } = array.element;
        let mark = &mut found.0;
        mark.entry("_FillValue".into())
            .or_insert_with(|| Attribute::Numbers(reals::decoded(&array.fill, dtype, endian)));
    }
    found
}

fn attribute(value: &Value) -> Option<Attribute> {
    match value {
        Value::Number(number) => Some(Attribute::Numbers(vec![number.as_f64()?])),
        Value::Array(list) => list.iter().map(Value::as_f64).collect::<Option<_>>().map(Attribute::Numbers),
        Value::String(text) => Some(Attribute::Text(text.clone())),
        _ => None,
    }
}

/// The numbers and text among the attributes of an array.
pub fn attributes_of(array: &Object) -> Attributes {
    let mut found = Attributes::default();
    found.0.extend(array.iter().filter_map(|(name, value)| Some((name.clone(), attribute(value)?))));
    found
}
