use super::colour_space::Interpolation;
use super::sorted;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use serde_json::Value;
use std::path::Path;

/// Pieces that a segment is cut into where colours are not interpolated in RGB.
const PIECES: usize = 16;

/// Reads ParaView (and vtk.js) colour maps: `RGBPoints` [v, r, g, b, …], and `Points`
/// [v, a, midpoint, sharpness, …] for opacity where there are any, else opacity rises with the value.
/// The value range is scaled to [0, 1].
pub fn parse(path: &Path, json: &Value, name: Option<&str>) -> Result<TransferFunction> {
    let single = std::slice::from_ref(json);
    let maps = json.as_array().map_or(single, Vec::as_slice);
    let with_colours: Vec<&Value> = maps.iter().filter(|m| m.get("RGBPoints").is_some()).collect();
    let named = |m: &Value| m.get("Name").and_then(Value::as_str).unwrap_or("unnamed").to_owned();
    let map = match name {
        Some(name) => with_colours.iter().find(|m| named(m) == name),
        None => with_colours.first(),
    };
    let map = map.ok_or_else(|| {
        let names: Vec<String> = with_colours.iter().take(20).map(|m| named(m)).collect();
        let known = if names.is_empty() { "none".into() } else { names.join(", ") };
        Error::malformed(path, format!("it has no such colour map with RGBPoints; maps in it: {known}"))
    })?;
    let colours = tuples(path, map, "RGBPoints")?;
    let opacities = if map.get("Points").is_some() { tuples(path, map, "Points")? } else { Vec::new() };
    let (low, high) = range(&colours);
    let unit = |v: f64| if high > low { (v - low) / (high - low) } else { 0.0 };
    let space = Interpolation::named(map.get("ColorSpace").and_then(Value::as_str).unwrap_or("RGB"));
    let mut points = Vec::new();
    for pair in colours.windows(2) {
        let pieces = if space == Interpolation::Rgb { 1 } else { PIECES };
        for piece in 0..pieces {
            let f = piece as f64 / pieces as f64;
            let value = unit(pair[0][0] + f * (pair[1][0] - pair[0][0]));
            let rgb =
                space.between([pair[0][1], pair[0][2], pair[0][3]], [pair[1][1], pair[1][2], pair[1][3]], f);
            points.push(ControlPoint::new(value, rgb, opacity(&opacities, &unit, value)));
        }
    }
    let [v, r, g, b] = colours[colours.len() - 1];
    points.push(ControlPoint::new(unit(v), [r, g, b], opacity(&opacities, &unit, unit(v))));
    sorted(path, points)
}

fn range(colours: &[[f64; 4]]) -> (f64, f64) {
    colours.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c[0]), high.max(c[0])))
}

/// The numbers of list `key` in fours.
fn tuples(path: &Path, map: &Value, key: &str) -> Result<Vec<[f64; 4]>> {
    let bad = || {
        Error::malformed(
            path,
            format!("{key} is not a list of numbers in groups of four; save the colour map again"),
        )
    };
    let numbers: Option<Vec<f64>> =
        map.get(key).and_then(Value::as_array).ok_or_else(bad)?.iter().map(Value::as_f64).collect();
    let numbers = numbers.ok_or_else(bad)?;
    let fours: Vec<[f64; 4]> = numbers.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    if fours.is_empty() || numbers.len() % 4 != 0 { Err(bad()) } else { Ok(fours) }
}

/// The opacity at `value`: piecewise linear through `points` (midpoint and sharpness are not kept);
/// without points a ramp.
fn opacity(points: &[[f64; 4]], unit: &impl Fn(f64) -> f64, value: f64) -> f64 {
    let Some(first) = points.first() else { return value };
    let mut before = first;
    for p in points {
        if unit(p[0]) >= value {
            let (a, b) = (unit(before[0]), unit(p[0]));
            let f = if b > a { (value - a) / (b - a) } else { 1.0 };
            return before[1] + f * (p[1] - before[1]);
        }
        before = p;
    }
    before[1]
}
