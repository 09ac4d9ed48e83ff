use super::imported::Imported;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use quick_xml::events::BytesStart;
use std::path::Path;

/// Content of an Inviwo `.itf` file: `Point` elements with a position and an RGBA colour, and a mask.
///
/// Positions are relative to the displayed range (`type` 0) or data values (`type` 1). Values outside the mask are
/// transparent.
#[derive(Debug, Default)]
pub struct Points {
    points: Vec<ControlPoint>,
    position: Option<f64>,
    mask: [Option<f64>; 2],
    is_absolute: bool,
}

impl Points {
    /// Takes in the next element of the file.
    pub fn take(&mut self, path: &Path, element: &BytesStart<'_>) -> Result<()> {
        match element.name().as_ref() {
            "pos" => self.position = attribute(element, "content"),
            "maskMin" => self.mask[0] = attribute(element, "content"),
            "maskMax" => self.mask[1] = attribute(element, "content"),
            "type" => {
                self.is_absolute = match attribute(element, "content") {
                    Some(0.0) => false,
                    Some(1.0) => true,
                    _ => {
                        let problem =
                            "its type is neither 0, relative, nor 1, absolute; save it from Inviwo again";
                        return Err(Error::malformed(path, problem));
                    }
                }
            }
            "rgba" => {
                let [r, g, b, a] = ["x", "y", "z", "w"].map(|name| attribute(element, name));
                let (Some(v), Some(r), Some(g), Some(b), Some(a)) = (self.position.take(), r, g, b, a) else {
                    let number = self.points.len();
                    let problem =
                        format!("point {number} lacks a position or one of x, y, z, w; save it again");
                    return Err(Error::malformed(path, problem));
                };
                let [r, g, b, a] = [r, g, b, a].map(|c| c.clamp(0.0, 1.0));
                self.points.push(ControlPoint::new(v, [r, g, b], a));
            }
            _ => {}
        }
        Ok(())
    }

    /// The function of all points.
    pub fn read(mut self, path: &Path) -> Result<Imported> {
        self.points.sort_by(|a, b| a.value.total_cmp(&b.value));
        let [Some(first), Some(last)] = [self.points.first(), self.points.last()].map(|p| p.map(|p| p.value))
        else {
            return Err(Error::malformed(
                path,
                "it has no points of a transfer function; give an .itf file of Inviwo or a presets.xml of 3D Slicer",
            ));
        };
        let malformed = |e: fovol_core::Error| Error::malformed(path, e.to_string());
        // A constant has no range that its points could span.
        let range = (self.is_absolute && first < last).then_some([first, last]);
        for point in &mut self.points {
            let unit = range.map_or(point.value, |[lo, hi]| (point.value - lo) / (hi - lo));
            point.value = unit.clamp(0.0, 1.0);
        }
        let mask = [self.mask[0].unwrap_or(0.0), self.mask[1].unwrap_or(1.0)];
        let transfer = TransferFunction::new(self.points).map_err(malformed)?;
        let transfer = masked(&transfer, mask).and_then(|t| t.with_range(range)).map_err(malformed)?;
        Ok(if range.is_some() { Imported::of(transfer) } else { Imported::stretched(transfer) })
    }
}

/// `transfer`, transparent outside of the part `from` to `to`.
fn masked(transfer: &TransferFunction, [from, to]: [f64; 2]) -> fovol_core::Result<TransferFunction> {
    if from <= 0.0 && to >= 1.0 {
        return Ok(transfer.clone());
    }
    if from >= to {
        let clear = |p: &ControlPoint| ControlPoint { opacity: 0.0, ..*p };
        return TransferFunction::new(transfer.points().iter().map(clear).collect());
    }
    let (from, to) = (from.max(0.0), to.min(1.0));
    let at = |value: f64, opacity: f64| {
        let [r, g, b, a] = transfer.evaluate(value);
        ControlPoint::new(value, [r, g, b], a * opacity)
    };
    let inside = transfer.points().iter().filter(|p| p.value > from && p.value < to).copied();
    let mut points = vec![at(from, 1.0)];
    if from > 0.0 {
        points.splice(0..0, [at(0.0, 0.0), at(from, 0.0)]);
    }
    points.extend(inside);
    points.push(at(to, 1.0));
    if to < 1.0 {
        points.extend([at(to, 0.0), at(1.0, 0.0)]);
    }
    TransferFunction::new(points)
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<f64> {
    let attribute = element.try_get_attribute(name).ok()??;
    attribute.value.trim().parse().ok().filter(|x: &f64| x.is_finite())
}
