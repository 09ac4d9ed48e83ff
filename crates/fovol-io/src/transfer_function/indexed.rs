//! Indexed colour maps: each value has a colour, without interpolation between them.

use super::groups::groups;
use super::imported::Imported;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use serde_json::Value;
use std::path::Path;

/// The half width of the band around a value, where its neighbours leave room for it.
const HALF: f64 = 0.5;

/// A value, its colour and its opacity.
type Label = (f64, [f64; 3], f64);

/// Reads `IndexedColors`, the colours of the values in `Annotations` (value, text, …), with `IndexedOpacities`.
/// Without annotations the colours are equal bands over what is shown.
pub fn parse(path: &Path, map: &Value) -> Result<Imported> {
    let colours = groups::<3>(path, map, "IndexedColors")?;
    let opacities: Vec<f64> = match map.get("IndexedOpacities") {
        Some(_) => groups::<1>(path, map, "IndexedOpacities")?.into_iter().flatten().collect(),
        None => Vec::new(),
    };
    let annotations = map.get("Annotations").and_then(Value::as_array).filter(|list| !list.is_empty());
    let values: Vec<Option<f64>> = match annotations {
        Some(list) => list.iter().step_by(2).map(number).collect(),
        None => (0..colours.len()).map(|i| Some(i as f64)).collect(),
    };
    let unit = |x: f64| x.clamp(0.0, 1.0);
    let label = |(i, value): (usize, &Option<f64>)| -> Option<Label> {
        let opacity = opacities.get(i % colours.len()).copied().unwrap_or(1.0);
        Some(((*value)?, colours[i % colours.len()].map(unit), unit(opacity)))
    };
    let mut labels: Vec<Label> = values.iter().enumerate().filter_map(label).collect();
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    labels.dedup_by_key(|label| label.0);
    if labels.is_empty() {
        return Err(Error::malformed(
            path,
            "its Annotations name no number; annotate the values that IndexedColors belong to",
        ));
    }
    let transfer = bands(&labels).map_err(|e| Error::malformed(path, e.to_string()))?;
    let mut imported = Imported::of(transfer);
    let skipped = values.iter().filter(|value| value.is_none()).count();
    if skipped > 0 {
        imported.notes.push(format!("{skipped} of its annotations are no numbers and have no colour here"));
    }
    if annotations.is_none() {
        imported.is_stretched = true;
        imported.notes.push(format!(
            "its {} colours have no annotated values: they are equal bands of what is shown (--tf-range data: the values 0, 1, 2, …)",
            colours.len()
        ));
    }
    Ok(imported)
}

/// The number that an annotation stands for.
fn number(value: &Value) -> Option<f64> {
    let number = match value {
        Value::String(text) => text.trim().parse().ok()?,
        other => other.as_f64()?,
    };
    number.is_finite().then_some(number)
}

/// A band around the value of each of `labels`, which rise; transparent between bands and outside.
fn bands(labels: &[Label]) -> fovol_core::Result<TransferFunction> {
    let gaps = labels.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let half = gaps.fold(2.0 * HALF, f64::min) / 2.0;
    let (lo, hi) = (labels[0].0 - half, labels[labels.len() - 1].0 + half);
    let mut points: Vec<ControlPoint> = Vec::with_capacity(4 * labels.len());
    for &(value, colour, opacity) in labels {
        let [from, to] = [value - half, value + half].map(|x| ((x - lo) / (hi - lo)).clamp(0.0, 1.0));
        // Where bands touch, rounding may not leave a slit between them.
        let last = points.last().filter(|last| from - last.value < NO_GAP).map(|last| last.value);
        let from = last.unwrap_or(from);
        if last.is_some() {
            points.pop();
        } else {
            points.push(ControlPoint::new(from, colour, 0.0));
        }
        points.push(ControlPoint::new(from, colour, opacity));
        points.push(ControlPoint::new(to.max(from), colour, opacity));
        points.push(ControlPoint::new(to.max(from), colour, 0.0));
    }
    TransferFunction::new(points)?.with_range(Some([lo, hi]))
}

/// Bands closer than this part of the range touch.
const NO_GAP: f64 = 1e-12;
