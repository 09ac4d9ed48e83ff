use super::imported::Imported;
use crate::{Error, Result};
use fovol_core::{ControlPoint, TransferFunction};
use std::path::Path;

/// Whether every line of `text` that is not empty holds three numbers.
pub fn is_table(text: &str) -> bool {
    let mut lines = text.lines().filter(|line| !line.trim().is_empty()).peekable();
    lines.peek().is_some() && lines.all(|line| row(line).is_some())
}

fn row(line: &str) -> Option<[f64; 3]> {
    let words = line.split([' ', '\t', ',']).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> =
        words.map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers?.try_into().ok()
}

/// Reads a table of colours, one a line, from the lowest value to the highest; 0…1, or 0…255 where one is above 1.
pub fn parse(path: &Path, text: &str) -> Result<Imported> {
    let rows: Vec<[f64; 3]> = text.lines().filter_map(row).collect();
    let most = rows.iter().flatten().copied().fold(1.0, f64::max);
    let white = if most > 1.0 { 255.0 } else { 1.0 };
    let last = rows.len().saturating_sub(1).max(1) as f64;
    let point = |(i, rgb): (usize, &[f64; 3])| {
        let v = i as f64 / last;
        ControlPoint::new(v, rgb.map(|c| c / white), v)
    };
    let transfer = TransferFunction::new(rows.iter().enumerate().map(point).collect())
        .map_err(|e| Error::malformed(path, e.to_string()))?;
    let mut imported = Imported::stretched(transfer);
    imported.notes.push("it gives no opacity: that rises from 0 to 1 with the value".to_owned());
    Ok(imported)
}
