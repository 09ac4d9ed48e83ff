//! Volume properties of VTK and 3D Slicer: `presets.xml`, `.vp` and the presets of vtk.js. All are in data values.

use super::colour_space::Interpolation;
use super::curve::{ColourCurve, Curve, Node};
use super::imported::Imported;
use super::joined::joined;
use super::paraview::opacity_curve;
use super::warp::Warp;
use crate::{Error, Result};
use fovol_core::{GradientOpacity, TransferFunction};
#[cfg(feature = "files")]
use quick_xml::events::BytesStart;
use serde_json::Value;
use std::path::Path;

/// The lists of one volume property: how many numbers follow, then these numbers.
#[derive(Debug, Clone, Default)]
pub struct Lists {
    /// Name of the property.
    pub name: String,
    colours: Option<String>,
    opacities: Option<String>,
    gradients: Option<String>,
}

impl Lists {
    /// Of the XML element `VolumeProperty`.
    #[cfg(feature = "files")]
    pub fn of_element(element: &BytesStart<'_>) -> Self {
        let text = |name: &str| {
            let attribute = element.try_get_attribute(name).ok()??;
            Some(attribute.value.to_string())
        };
        Self {
            name: text("name").unwrap_or_default(),
            colours: text("colorTransfer"),
            opacities: text("scalarOpacity"),
            gradients: text("gradientOpacity"),
        }
    }

    /// Of an object of JSON, if it is a volume property.
    pub fn of_json(json: &Value) -> Option<Self> {
        let text = |name: &str| json.get(name).and_then(Value::as_str).map(str::to_owned);
        let name = text("name").or_else(|| text("Name")).unwrap_or_default();
        let lists = Self {
            name,
            colours: text("colorTransfer"),
            opacities: text("scalarOpacity"),
            gradients: text("gradientOpacity"),
        };
        (lists.colours.is_some() || lists.opacities.is_some()).then_some(lists)
    }

    /// Of the lines of a `.vp` file: after settings of light, the lists of scalar opacity, gradient opacity and colour.
    pub fn of_lines(text: &str) -> Option<Self> {
        let mut lists = text.lines().filter(|line| line.split_whitespace().count() > 1).map(str::to_owned);
        let (opacities, gradients, colours) = (lists.next()?, lists.next()?, lists.next()?);
        let lists = Self {
            name: String::new(),
            colours: Some(colours),
            opacities: Some(opacities),
            gradients: Some(gradients),
        };
        Some(lists)
    }

    /// The transfer function that the lists describe.
    pub fn read(&self, path: &Path) -> Result<Imported> {
        let colours = numbers::<4>(path, "colorTransfer", self.colours.as_deref())?;
        let opacities = numbers::<2>(path, "scalarOpacity", self.opacities.as_deref())?;
        let node = |[x, r, g, b]: [f64; 4]| Node { x, y: [r, g, b], warp: Warp::LINEAR };
        let nodes = Curve::new(colours.into_iter().map(node).collect(), false)
            .ok_or_else(|| bad(path, "colorTransfer", 4))?;
        let opacities = opacity_curve(opacities.into_iter().map(|[x, y]| [x, y, 0.5, 0.0]).collect(), false);
        let mut imported = joined(path, &ColourCurve::new(nodes, Interpolation::Rgb), opacities.as_ref())?;
        if let Some(gradients) = &self.gradients {
            let gradients = numbers::<2>(path, "gradientOpacity", Some(gradients))?;
            imported.transfer = with_gradients(imported.transfer, gradients)
                .map_err(|e| Error::malformed(path, e.to_string()))?;
        }
        Ok(imported)
    }
}

/// `transfer` with the opacity by gradient of VTK: factors at lengths in data values per mean edge of a voxel.
///
/// Points in any order and below 0 are as VTK takes them: sorted, and evaluated at 0. Factors of 1 alone change nothing.
fn with_gradients(
    transfer: TransferFunction,
    mut points: Vec<[f64; 2]>,
) -> fovol_core::Result<TransferFunction> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let below = points.partition_point(|point| point[0] < 0.0);
    if below > 0 {
        let before = points[below - 1];
        let at_zero = points.get(below).map_or(before[1], |after| {
            before[1] - before[0] / (after[0] - before[0]) * (after[1] - before[1])
        });
        points.splice(..below, [[0.0, at_zero]]);
    }
    let clamped = points.into_iter().map(|[length, factor]| [length, factor.clamp(0.0, 1.0)]);
    let curve = GradientOpacity::new(clamped.collect())?;
    if curve.is_neutral() {
        return Ok(transfer);
    }
    // A function of one value has no range; its gradients are 0 anyway.
    let [lo, hi] = transfer.range().unwrap_or([0.0, 1.0]);
    Ok(transfer.with_gradient(Some(curve.scaled((hi - lo).recip()))))
}

/// Whether `text` is made of lines of numbers alone, at least one of which is a counted list.
pub fn is_vp(text: &str) -> bool {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let mut counted = false;
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if !words.iter().all(|word| is_number(word)) {
            return false;
        }
        counted |= words.len() > 1 && words[0].parse() == Ok(words.len() - 1);
    }
    counted
}

/// The numbers of `list` in groups of N, without their count.
fn numbers<const N: usize>(path: &Path, name: &str, list: Option<&str>) -> Result<Vec<[f64; N]>> {
    let parsed: Option<Vec<f64>> =
        list.unwrap_or_default().split_whitespace().map(|word| word.parse().ok()).collect();
    let numbers = parsed.ok_or_else(|| bad(path, name, N))?;
    let Some((&count, numbers)) = numbers.split_first() else { return Err(bad(path, name, N)) };
    let (groups, rest) = numbers.as_chunks::<N>();
    let is_sound = count == numbers.len() as f64 && rest.is_empty() && !groups.is_empty();
    if is_sound && numbers.iter().all(|x| x.is_finite()) {
        Ok(groups.to_vec())
    } else {
        Err(bad(path, name, N))
    }
}

fn bad(path: &Path, name: &str, size: usize) -> Error {
    Error::malformed(
        path,
        format!("{name} is not a count and as many numbers in groups of {size}; save the preset again"),
    )
}
