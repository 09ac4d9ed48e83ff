use super::sorted;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::path::Path;

/// Reads an Inviwo `.itf` file: `Point` elements with a position and an RGBA colour.
pub fn parse(path: &Path, text: &str) -> Result<TransferFunction> {
    let bad = |problem: String| Error::malformed(path, problem);
    let mut reader = Reader::from_str(text);
    let mut points = Vec::new();
    let mut value = None;
    loop {
        match reader.read_event().map_err(|e| bad(format!("it is damaged XML ({e})")))? {
            Event::Start(e) | Event::Empty(e) => match e.name().as_ref() {
                "pos" => value = attribute(&e, "content"),
                "rgba" => {
                    let [r, g, b, a] = ["x", "y", "z", "w"].map(|name| attribute(&e, name));
                    let (Some(v), Some(r), Some(g), Some(b), Some(a)) = (value.take(), r, g, b, a) else {
                        return Err(bad(format!(
                            "point {} lacks a position or one of x, y, z, w",
                            points.len()
                        )));
                    };
                    points.push(ControlPoint::new(v, [r, g, b], a));
                }
                _ => {}
            },
            Event::Eof => break,
            _ => {}
        }
    }
    if points.is_empty() {
        return Err(bad("it has no transfer function points; save it from Inviwo as .itf".into()));
    }
    sorted(path, points)
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<f64> {
    let attribute = element.try_get_attribute(name).ok()??;
    attribute.value.trim().parse().ok().filter(|x: &f64| x.is_finite())
}
