//! Transfer functions by name, and automatic ones.

use crate::{Error, OpenVolume, Result};
use fovol_core::{ControlPoint, TransferFunction, Volume, did_you_mean};
use fovol_io::transfer_function;
use std::path::Path;

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Presets that the program carries, one for every procedural volume.
        const PRESETS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../../assets/presets/", $name, ".json")))),*
        ];
    };
}

presets!("vortices", "supernova", "head", "engine", "angiogram", "reptile", "plume", "marschner-lobb");

/// Colour maps by name.
const COLOUR_MAPS: &[(&str, colorous::Gradient)] = &[
    ("viridis", colorous::VIRIDIS),
    ("magma", colorous::MAGMA),
    ("inferno", colorous::INFERNO),
    ("plasma", colorous::PLASMA),
    ("cividis", colorous::CIVIDIS),
    ("turbo", colorous::TURBO),
    ("warm", colorous::WARM),
    ("cool", colorous::COOL),
    ("spectral", colorous::SPECTRAL),
];

/// The opacity that the grey ramp ends at, per voxel.
const GREY_OPACITY: f64 = 0.3;

/// `transfer` as [`find`] takes it in place of a name.
///
/// # Panics
/// Never: numbers can be written as JSON.
pub fn text(transfer: &TransferFunction) -> String {
    serde_json::to_string(transfer).expect("numbers can be written as JSON")
}

/// All names that [`find`] knows.
pub fn names() -> Vec<&'static str> {
    kinds().into_iter().flat_map(|kind| kind.names).collect()
}

/// Transfer functions that are made in the same way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    /// How they are made, in a few words.
    pub description: &'static str,
    /// Their names.
    pub names: Vec<&'static str>,
}

/// All kinds of transfer functions that [`find`] knows by name.
pub fn kinds() -> [Kind; 4] {
    let kind = |description, names| Kind { description, names };
    [
        kind("from the histogram, or the preset of a procedural volume", vec!["auto"]),
        kind("black to white, opacity rising with the value", vec!["grey"]),
        kind("presets of the procedural volumes", PRESETS.iter().map(|(name, _)| *name).collect()),
        kind("colour maps, with the opacity of auto", COLOUR_MAPS.iter().map(|(name, _)| *name).collect()),
    ]
}

/// The transfer function that `what` names for `volume`: `auto` (its own preset where it is a procedural
/// volume, else one made from its histogram), a preset, a colour map (with the opacity of `auto`), a file, or our JSON itself.
/// Names may be in upper case too.
///
/// # Errors
/// A name that is none of these; what is wrong with a file.
pub fn find(what: &str, volume: &OpenVolume) -> Result<TransferFunction> {
    match what {
        json if json.trim_start().starts_with('{') => serde_json::from_str(json).map_err(|e| {
            Error::Setting(format!(
                "the transfer function (--tf) cannot be read: {e}; expected {{\"points\":[[value,red,green,blue,opacity],…]}}"
            ))
        }),
        _ => {
            if let Some(found) = named(what, volume) {
                return Ok(found);
            }
            if is_file(what) {
                return Ok(transfer_function::read(Path::new(what))?);
            }
            named(&what.to_ascii_lowercase(), volume).ok_or_else(|| unknown(what))
        }
    }
}

/// The transfer function that is called `name`.
fn named(name: &str, volume: &OpenVolume) -> Option<TransferFunction> {
    match name {
        "auto" => Some(automatic_for(volume)),
        "grey" => Some(TransferFunction::grey_ramp(GREY_OPACITY)),
        _ => preset(name).or_else(|| Some(coloured(&automatic_for(volume), colour_map(name)?))),
    }
}

fn unknown(what: &str) -> Error {
    let names = names();
    Error::Setting(format!(
        "`{what}` is no transfer function (--tf): there is no such file, and the names are {}{}",
        names.join(" "),
        did_you_mean(what, &names)
    ))
}

/// Whether `what` names a file, or a part `FILE#PART` of one.
fn is_file(what: &str) -> bool {
    let file = what.rsplit_once('#').map_or(what, |(file, _)| file);
    Path::new(what).is_file() || Path::new(file).is_file()
}

/// What the transfer function in the file `what` is as [`text`]; none where [`find`] takes `what` for something else.
pub(crate) fn text_of_file(what: &str) -> Option<String> {
    let is_one = is_file(what) && !names().contains(&what);
    is_one.then(|| transfer_function::read(Path::new(what)).ok()).flatten().map(|transfer| text(&transfer))
}

/// What `auto` is for `volume`.
fn automatic_for(volume: &OpenVolume) -> TransferFunction {
    let own = volume.procedural.and_then(|kind| preset(kind.name()));
    own.unwrap_or_else(|| automatic(&volume.volume))
}

fn preset(name: &str) -> Option<TransferFunction> {
    let (_, text) = PRESETS.iter().find(|(known, _)| *known == name)?;
    Some(serde_json::from_str(text).expect("presets are checked by a test"))
}

fn colour_map(name: &str) -> Option<&'static colorous::Gradient> {
    COLOUR_MAPS.iter().find(|(known, _)| *known == name).map(|(_, gradient)| gradient)
}

/// Parts in which colours of a map are taken for straight.
const MAP_PARTS: u32 = 32;

/// The colours of `gradient` with the opacity of `transfer`.
fn coloured(transfer: &TransferFunction, gradient: &colorous::Gradient) -> TransferFunction {
    let at = |value, opacity| ControlPoint::new(value, colour(gradient, value), opacity);
    let corners = transfer.points();
    let mut points: Vec<_> = corners.iter().map(|corner| at(corner.value, corner.opacity)).collect();
    let between = (0..=MAP_PARTS).map(|i| f64::from(i) / f64::from(MAP_PARTS));
    // Where there is a corner already, it may be one side of a step.
    let between = between.filter(|&value| corners.iter().all(|corner| corner.value != value));
    points.extend(between.map(|value| at(value, transfer.evaluate(value)[3])));
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    TransferFunction::new(points).expect("values rise")
}

fn colour(gradient: &colorous::Gradient, v: f64) -> [f64; 3] {
    let c = gradient.eval_continuous(v);
    [c.r, c.g, c.b].map(|c| f64::from(c) / 255.0)
}

/// Parts of the histogram.
const BINS: usize = 256;

/// A transfer function made from the histogram of `volume`: what Otsu's threshold calls background is
/// transparent, the rest becomes more opaque with its value, in warm colours that differ most where most
/// of the values are.
pub fn automatic(volume: &Volume) -> TransferFunction {
    let [lo, hi] = volume.range();
    let counts = volume.histogram(BINS, [lo, hi]);
    let threshold = otsu(&counts);
    let foreground: u64 = counts[threshold..].iter().sum();
    let total: u64 = counts.iter().sum();
    // Where most of the volume is visible it has to be thin to be seen through.
    let share = if total > 0 { foreground as f64 / total as f64 } else { 1.0 };
    let densest = (0.9 - 1.2 * share).clamp(0.15, 0.9);
    let start = threshold as f64 / BINS as f64;
    let mut points = vec![ControlPoint::new(0.0, colour(&colorous::INFERNO, 0.15), 0.0)];
    if start > 0.0 {
        points.push(ControlPoint::new(start, colour(&colorous::INFERNO, 0.3), 0.0));
    }
    for i in 1..=8 {
        let part = f64::from(i) / 8.0;
        // The value below which this part of the foreground lies.
        let equalised = quantile(&counts, threshold, part) as f64 / BINS as f64;
        let v = (0.5 * equalised + 0.5 * (start + part * (1.0 - start))).min(1.0);
        let last = points[points.len() - 1].value;
        points.push(ControlPoint::new(
            v.max(last),
            colour(&colorous::INFERNO, 0.3 + 0.68 * part),
            densest * part * part,
        ));
    }
    points.push(ControlPoint::new(1.0, colour(&colorous::INFERNO, 0.98), densest));
    TransferFunction::new(points).expect("values rise")
}

/// The bin from which on `part` of the values at or above `from` lie below.
fn quantile(counts: &[u64], from: usize, part: f64) -> usize {
    let total: u64 = counts[from..].iter().sum();
    let mut below = 0;
    for (bin, &count) in counts.iter().enumerate().skip(from) {
        below += count;
        if below as f64 >= part * total as f64 {
            return bin + 1;
        }
    }
    counts.len()
}

/// The first bin of the brighter class (Otsu 1979): the split that puts the most variance between the
/// two classes.
fn otsu(counts: &[u64]) -> usize {
    let total: f64 = counts.iter().map(|&c| c as f64).sum();
    let sum: f64 = counts.iter().enumerate().map(|(i, &c)| i as f64 * c as f64).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let mut best = (0.0, 0);
    for (i, &count) in counts.iter().enumerate() {
        below += count as f64;
        sum_below += i as f64 * count as f64;
        let above = total - below;
        if below > 0.0 && above > 0.0 {
            let apart = sum_below / below - (sum - sum_below) / above;
            let between = below * above * apart * apart;
            if between > best.0 {
                best = (between, i + 1);
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;
    use fovol_io::procedural::Procedural;
    use std::sync::Arc;

    fn opened(values: Vec<u8>) -> OpenVolume {
        let grid = Grid::new([values.len(), 1, 1], [1.0; 3]).unwrap();
        let volume = Arc::new(Volume::from_values(grid, values).unwrap());
        OpenVolume { volume, source: "test".into(), procedural: None }
    }

    #[test]
    fn every_name_is_found_and_every_procedural_volume_has_a_preset() {
        let volume = opened(vec![0, 50, 200]);
        for name in names() {
            find(name, &volume).unwrap();
        }
        for kind in Procedural::ALL {
            assert!(preset(kind.name()).is_some(), "{}", kind.name());
        }
        let error = find("no-such-thing", &volume).unwrap_err().to_string();
        assert!(error.contains("no-such-thing") && error.contains("viridis"));
        assert_eq!(find("Viridis", &volume).unwrap(), find("viridis", &volume).unwrap());
        let error = find("virdis", &volume).unwrap_err().to_string();
        assert!(error.ends_with("did you mean viridis?"), "{error}");
    }

    #[test]
    fn functions_stand_in_settings_as_json() {
        let volume = opened(vec![0, 50, 200]);
        let magma = find("magma", &volume).unwrap();
        assert_eq!(find(&text(&magma), &volume).unwrap(), magma);
        for bad in ["{", r#"{"points":[]}"#, r#"{"points":[[0,0,0,0,2]]}"#, r#"{"colours":1}"#] {
            let error = find(bad, &volume).unwrap_err().to_string();
            assert!(error.contains("--tf") && error.contains("points"), "{error}");
        }
    }

    #[test]
    fn background_is_transparent_and_objects_are_not() {
        let mut values = vec![10u8; 900];
        values.extend(vec![180u8; 100]);
        let tf = automatic(&opened(values).volume);
        assert_eq!(tf.evaluate(10.0 / 255.0)[3], 0.0);
        assert!(tf.evaluate(180.0 / 255.0)[3] > 0.1);
    }

    #[test]
    fn colour_maps_show_what_the_automatic_one_shows() {
        let mut values = vec![10u8; 900];
        values.extend(vec![180u8; 100]);
        let scan = opened(values);
        let head = OpenVolume { procedural: Some(Procedural::Head), ..opened(vec![0, 50, 200]) };
        for volume in [&scan, &head] {
            let (auto, magma) = (find("auto", volume).unwrap(), find("magma", volume).unwrap());
            for i in 0..=1000 {
                let v = f64::from(i) / 1000.0;
                let ([.., expected], [r, .., found]) = (auto.evaluate(v), magma.evaluate(v));
                assert!((found - expected).abs() < 1e-12, "{v}: {found} instead of {expected}");
                assert!((r - colour(&colorous::MAGMA, v)[0]).abs() < 0.02, "{v}");
            }
        }
        assert_eq!(find("magma", &scan).unwrap().evaluate(10.0 / 255.0)[3], 0.0);
    }

    #[test]
    fn a_constant_volume_has_one_too() {
        automatic(&opened(vec![7; 10]).volume);
        automatic(&opened(vec![255; 10]).volume);
    }
}
