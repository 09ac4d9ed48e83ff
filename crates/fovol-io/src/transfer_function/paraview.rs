use super::colour_space::{Colour, Interpolation};
use super::curve::{ColourCurve, Curve, Node, OpacityCurve};
use super::groups::{groups, not_groups};
use super::imported::Imported;
use super::indexed;
use super::joined::joined;
use super::warp::Warp;
use crate::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// Ranges of maps that are made to be stretched over any data.
const USUAL_RANGES: [[f64; 2]; 2] = [[0.0, 1.0], [-1.0, 1.0]];

/// The way of Lab/CIEDE2000 costs a search for every segment; no map has more.
const MOST_SEARCHES: usize = 64;

/// Whether `map` is one of ParaView's, which vtk.js has too.
pub fn is_map(map: &Value) -> bool {
    map.get("RGBPoints").is_some() || map.get("IndexedColors").is_some()
}

/// Reads one of ParaView's colour maps: `RGBPoints` [x, r, g, b, …], and `Points` [x, opacity, midpoint, sharpness, …]
/// where there are any, in data values; or `IndexedColors`.
pub fn parse(path: &Path, map: &Value) -> Result<Imported> {
    let mut imported = match map.get("RGBPoints") {
        Some(_) => continuous(path, map)?,
        None => indexed::parse(path, map)?,
    };
    if map.get("NanColor").is_some() {
        let [r, g, b] = groups::<3>(path, map, "NanColor")?[0].map(|c| c.clamp(0.0, 1.0));
        let opacity = map.get("NanOpacity").and_then(Value::as_f64).unwrap_or(1.0);
        let nan = [r, g, b, opacity.clamp(0.0, 1.0)];
        imported.transfer =
            imported.transfer.with_nan(nan).map_err(|e| Error::malformed(path, e.to_string()))?;
    }
    Ok(imported)
}

fn continuous(path: &Path, map: &Value) -> Result<Imported> {
    let is_set =
        |key: &str| map.get(key).is_some_and(|v| v.as_bool() == Some(true) || v.as_f64() == Some(1.0));
    let name = map.get("ColorSpace").and_then(Value::as_str).unwrap_or("RGB");
    let space = Interpolation::named(name, is_set("HSVWrap"));
    let colours = groups::<4>(path, map, "RGBPoints")?;
    let node = |[x, r, g, b]: [f64; 4]| Node { x, y: [r, g, b], warp: Warp::LINEAR };
    let nodes = Curve::new(colours.into_iter().map(node).collect(), is_set("UseLogScale"));
    let nodes: Curve<Colour> = nodes.ok_or_else(|| not_groups(path, "RGBPoints", 4))?;
    if space == Some(Interpolation::Ciede2000) && nodes.len() > MOST_SEARCHES {
        let count = nodes.len();
        return Err(Error::malformed(
            path,
            format!(
                "it has {count} colours in Lab/CIEDE2000, {MOST_SEARCHES} at most are read; use Lab for so many"
            ),
        ));
    }
    let colours = ColourCurve::new(nodes, space.unwrap_or(Interpolation::Rgb));
    let opacities = match map.get("Points") {
        Some(_) => opacity_curve(groups::<4>(path, map, "Points")?, is_set("UseLogScaleOpacity")),
        None => None,
    };
    let mut imported = joined(path, &colours, opacities.as_ref())?;
    imported.is_stretched = USUAL_RANGES.contains(&colours.nodes.range())
        && opacities.is_none_or(|curve| USUAL_RANGES.contains(&curve.range()) || curve.len() == 1);
    if space.is_none() {
        imported.notes.push(format!("its colour space `{name}` is not known: colours are mixed in RGB"));
    }
    Ok(imported)
}

/// The curve through nodes of x, opacity, midpoint and sharpness.
pub fn opacity_curve(nodes: Vec<[f64; 4]>, is_logarithmic: bool) -> Option<OpacityCurve> {
    let node = |[x, y, midpoint, sharpness]: [f64; 4]| Node { x, y, warp: Warp::new(midpoint, sharpness) };
    Curve::new(nodes.into_iter().map(node).collect(), is_logarithmic)
}
