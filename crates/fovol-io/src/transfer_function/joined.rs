use super::curve::{ColourCurve, OpacityCurve};
use super::imported::Imported;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use std::path::Path;

/// The function of `colours` and `opacities`, each at its own places, over the values from the first node of either to
/// the last. Without opacities they rise from 0 to 1, and a note says so.
///
/// # Errors
/// Nodes that span no finite range.
pub fn joined(path: &Path, colours: &ColourCurve, opacities: Option<&OpacityCurve>) -> Result<Imported> {
    let [mut lo, mut hi] = colours.nodes.range();
    if let Some([from, to]) = opacities.map(OpacityCurve::range) {
        (lo, hi) = (lo.min(from), hi.max(to));
    }
    let mut notes = Vec::new();
    if opacities.is_none() {
        notes.push("it gives no opacity: that rises from 0 to 1 with the value".to_owned());
    }
    let opacity = |x: f64| match opacities {
        Some(curve) => curve.opacity(x),
        None => (x - lo) / (hi - lo),
    };
    let malformed = |e: fovol_core::Error| Error::malformed(path, e.to_string());
    if lo == hi {
        // A single value: a constant.
        let opacity = opacities.map_or(1.0, |curve| curve.opacity(lo)).clamp(0.0, 1.0);
        let colour = colours.colour(lo).map(|c| c.clamp(0.0, 1.0));
        let transfer =
            TransferFunction::new(vec![ControlPoint::new(0.0, colour, opacity)]).map_err(malformed)?;
        return Ok(Imported { notes, ..Imported::stretched(transfer) });
    }
    // Breaks stay exactly where they are: at a jump, the least error shows.
    let mut breaks: Vec<f64> =
        colours.breaks().chain(opacities.into_iter().flat_map(|o| o.breaks())).collect();
    breaks.extend([lo, hi]);
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    let places: Vec<f64> = breaks.iter().map(|x| (x - lo) / (hi - lo)).collect();
    let value = |v: f64| match places.binary_search_by(|place| place.total_cmp(&v)) {
        Ok(i) => breaks[i],
        Err(_) => lo + v * (hi - lo),
    };
    let curve = |v: f64| {
        let x = value(v);
        let [r, g, b] = colours.colour(x);
        [r, g, b, opacity(x)]
    };
    let transfer = TransferFunction::of_curve(&places, curve)
        .and_then(|transfer| transfer.with_range(Some([lo, hi])))
        .map_err(malformed)?;
    Ok(Imported { notes, ..Imported::of(transfer) })
}
