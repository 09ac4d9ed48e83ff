//! Transfer functions: presets, colour maps and automatic ones.

use crate::{Error, NanColour, OpenVolume, RenderSettings, Result, TransferRange, ValueScale};
use fovol_core::{ControlPoint, TransferFunction, Volume, did_you_mean, path_of_text, with_voxel_type};
use fovol_io::transfer_function::{self, Imported};

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Built-in presets, one for each procedural volume.
        const PRESETS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../assets/presets/", $name, ".json")))),*
        ];
    };
}

presets!("vortices", "supernova", "head", "engine", "angiogram", "reptile", "plume", "marschner-lobb");

/// Colour maps with their names.
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

/// Opacity per voxel at the upper end of the grey ramp.
const GREY_OPACITY: f64 = 0.3;

/// Text of `transfer` as JSON, which [`find`] accepts in place of a name.
///
/// # Panics
/// Never: numbers can always be written as JSON.
pub fn text(transfer: &TransferFunction) -> String {
    serde_json::to_string(transfer).expect("numbers can be written as JSON")
}

/// All names that [`find`] accepts.
pub fn names() -> Vec<&'static str> {
    kinds().into_iter().flat_map(|kind| kind.names).collect()
}

/// Group of transfer functions that are made in the same way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    /// Short description of how they are made.
    pub description: &'static str,
    /// Names of the transfer functions.
    pub names: Vec<&'static str>,
}

/// All groups of transfer functions that [`find`] knows by name.
pub fn kinds() -> [Kind; 4] {
    let kind = |description, names| Kind { description, names };
    [
        kind("from the histogram, or the preset of a procedural volume", vec!["auto"]),
        kind("black to white, opacity rising with the value", vec!["grey"]),
        kind("presets of the procedural volumes", PRESETS.iter().map(|(name, _)| *name).collect()),
        kind("colour maps, with the opacity of auto", COLOUR_MAPS.iter().map(|(name, _)| *name).collect()),
    ]
}

/// Finds the transfer function `what` for `volume`: `auto`, a preset, a colour map (with the opacity of `auto`), a
/// file, or JSON text. `auto` is the preset of a procedural volume, else one made from the histogram. Names ignore
/// case.
///
/// The result covers the displayed range of the volume. Data values of a file keep their colours.
///
/// # Errors
/// An unknown name, a file that cannot be read or is invalid.
pub fn find(what: &str, volume: &OpenVolume) -> Result<TransferFunction> {
    Ok(load(what, volume)?.as_meant().over(volume.volume.range()))
}

/// Transfer function that `settings` choose for `volume`, over the displayed range: see [`find`].
///
/// # Errors
/// Errors of [`find`]; data values requested of a function without any; a logarithmic scale without positive values.
pub fn chosen(settings: &RenderSettings, volume: &OpenVolume) -> Result<TransferFunction> {
    let what = named_in(settings);
    let transfer = placed(what, &load(what, volume)?, settings.tf_range)?;
    let transfer = settings.nan.unwrap_or_default().of(transfer)?;
    let shown = volume.volume.range();
    // Functions in data values keep their place, whatever the scale.
    if settings.scale == Some(ValueScale::Log) && transfer.range().is_none() {
        return Ok(transfer.on_log_scale(shown, least_positive(&volume.volume))?);
    }
    Ok(transfer.over(shown))
}

/// Notes on assumptions about the transfer function of `settings`, one line each; none if it cannot be read.
pub fn notes(settings: &RenderSettings, volume: &OpenVolume) -> Vec<String> {
    let what = named_in(settings);
    let Ok(imported) = load(what, volume) else { return Vec::new() };
    let [from, to] = volume.volume.range();
    let mut notes = imported.notes.clone();
    if let Some([lo, hi]) = imported.transfer.range() {
        let stays =
            placed(what, &imported, settings.tf_range).is_ok_and(|transfer| transfer.range().is_some());
        if !stays && settings.tf_range.is_none() && [lo, hi] != [from, to] {
            notes.push(format!(
                "its values {lo} to {hi} are stretched over those that are shown, {from} to {to}; --tf-range data keeps them"
            ));
        }
        if stays && (hi < from || lo > to) {
            notes.push(format!(
                "its values {lo} to {hi} lie outside those that are shown, {from} to {to}; --range LO,HI shows others, --tf-range stretch moves it"
            ));
        }
        if stays && settings.scale == Some(ValueScale::Log) {
            notes.push("it is in data values and stays there: --scale log changes nothing".into());
        }
    }
    notes.extend(note_of_nan(settings, volume, &imported.transfer));
    notes.into_iter().map(|note| format!("{what}: {note}")).collect()
}

/// Note on the colour of NaN in `transfer`, if `volume` has NaN.
fn note_of_nan(
    settings: &RenderSettings,
    volume: &OpenVolume,
    transfer: &TransferFunction,
) -> Option<String> {
    let of_file = transfer.chosen_nan();
    let note = match (settings.nan, of_file) {
        (None, Some([r, g, b, a])) => {
            format!("its colour for NaN ({r},{g},{b},{a}) is left out; --nan file uses it")
        }
        (Some(NanColour::File), None) => {
            "it has no colour for NaN, which is transparent; --nan R,G,B,A gives one".into()
        }
        _ => return None,
    };
    (volume.volume.statistics().nan > 0).then_some(note)
}

/// Name or text of the transfer function of `settings`.
fn named_in(settings: &RenderSettings) -> &str {
    settings.tf.as_deref().unwrap_or("auto")
}

/// Transfer function `imported` of the name `what`, with a range if it keeps its data values.
fn placed(what: &str, imported: &Imported, place: Option<TransferRange>) -> Result<TransferFunction> {
    let transfer = imported.transfer.clone();
    match place {
        Some(TransferRange::Stretch) => Ok(transfer.with_range(None)?),
        Some(TransferRange::Data) if transfer.range().is_none() => Err(Error::Setting(format!(
            "`{what}` has no data values, but --tf-range data is given; leave that out, or give \"range\":[LO,HI] beside its points"
        ))),
        Some(TransferRange::Data) => Ok(transfer),
        None => Ok(imported.as_meant()),
    }
}

/// Smallest displayed positive value of `volume`; 0 if there is none.
fn least_positive(volume: &Volume) -> f64 {
    let [from, to] = volume.range();
    if from > 0.0 {
        return from;
    }
    let rescale = volume.rescale();
    let mut least = f64::INFINITY;
    with_voxel_type!(volume.dtype(), T => volume.for_each_raw(0..=volume.grid().voxels() - 1, |raw: T| {
        let value = rescale.apply(fovol_core::Voxel::to_f64(raw));
        if value > 0.0 && value < least {
            least = value;
        }
    }));
    if least < to { least } else { 0.0 }
}

/// Loads the transfer function `what` for `volume`, in its original range.
fn load(what: &str, volume: &OpenVolume) -> Result<Imported> {
    if what.trim_start().starts_with('{') {
        let transfer: TransferFunction = serde_json::from_str(what).map_err(|e| {
            Error::Setting(format!(
                "the transfer function (--tf) cannot be read: {e}; expected {{\"points\":[[value,red,green,blue,opacity],…]}}"
            ))
        })?;
        return Ok(transfer.into());
    }
    if let Some(found) = named(what, volume) {
        return Ok(found.into());
    }
    if is_file(what) {
        return Ok(transfer_function::import(&path_of_text(what))?);
    }
    named(&what.to_ascii_lowercase(), volume).map(Imported::from).ok_or_else(|| unknown(what))
}

/// Transfer function with the name `name`.
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

/// Whether `what` names a file, or one function of it as `FILE#PART`.
fn is_file(what: &str) -> bool {
    let file = what.rsplit_once('#').map_or(what, |(file, _)| file);
    path_of_text(what).is_file() || path_of_text(file).is_file()
}

/// Transfer function of the file `what` as [`text`], for settings that place it at `place`. `None` if [`find`] does not
/// take `what` for a file.
#[cfg(feature = "files")]
pub(crate) fn text_of_file(what: &str, place: Option<TransferRange>) -> Option<String> {
    if !is_file(what) || names().contains(&what) {
        return None;
    }
    let imported = transfer_function::import(&path_of_text(what)).ok()?;
    placed(what, &imported, place).ok().map(|transfer| text(&transfer))
}

/// Automatic transfer function of `volume`.
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

/// Pieces into which a colour map is cut; its colours are linear within each.
const MAP_PARTS: u32 = 32;

/// Combines the colours of `gradient` with the opacity of `transfer`.
fn coloured(transfer: &TransferFunction, gradient: &colorous::Gradient) -> TransferFunction {
    let at = |value, opacity| ControlPoint::new(value, colour(gradient, value), opacity);
    let corners = transfer.points();
    let mut points: Vec<_> = corners.iter().map(|corner| at(corner.value, corner.opacity)).collect();
    let between = (0..=MAP_PARTS).map(|i| f64::from(i) / f64::from(MAP_PARTS));
    // An existing control point may be one side of a step, so leave it alone.
    let between = between.filter(|&value| corners.iter().all(|corner| corner.value != value));
    points.extend(between.map(|value| at(value, transfer.evaluate(value)[3])));
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    TransferFunction::new(points).expect("values rise")
}

fn colour(gradient: &colorous::Gradient, v: f64) -> [f64; 3] {
    let c = gradient.eval_continuous(v);
    [c.r, c.g, c.b].map(|c| f64::from(c) / 255.0)
}

/// Bins of the histogram.
const BINS: usize = 256;

/// Makes a transfer function from the histogram of `volume`. Values below Otsu's threshold are background and
/// transparent. Opacity grows with the value above it. Warm colours change fastest where most values lie.
pub fn automatic(volume: &Volume) -> TransferFunction {
    let [lo, hi] = volume.range();
    let counts = volume.histogram(BINS, [lo, hi]);
    let threshold = otsu(&counts);
    let foreground: u64 = counts[threshold..].iter().sum();
    let total: u64 = counts.iter().sum();
    // If most of the volume is visible, it must be thin to be seen through.
    let share = if total > 0 { foreground as f64 / total as f64 } else { 1.0 };
    let densest = (0.9 - 1.2 * share).clamp(0.15, 0.9);
    let start = threshold as f64 / BINS as f64;
    let mut points = vec![ControlPoint::new(0.0, colour(&colorous::INFERNO, 0.15), 0.0)];
    if start > 0.0 {
        points.push(ControlPoint::new(start, colour(&colorous::INFERNO, 0.3), 0.0));
    }
    for i in 1..=8 {
        let part = f64::from(i) / 8.0;
        // Value below which the fraction `part` of the foreground lies.
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

/// First bin below which the fraction `part` of the values at or above `from` lies.
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

/// First bin of the brighter class by Otsu's threshold (1979), which maximises the variance between two classes.
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

    fn with_file(name: &str, content: &str, check: impl Fn(&str)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        check(path.to_str().unwrap());
    }

    fn settings(tf: &str) -> RenderSettings {
        RenderSettings { tf: Some(tf.into()), ..RenderSettings::default() }
    }

    #[test]
    fn data_values_stay_unless_told_otherwise() {
        let hu = r#"[{"Name":"hu","RGBPoints":[100,0,0,0, 150,1,0,0],"Points":[100,0,0.5,0, 150,1,0.5,0]}]"#;
        let volume = opened(vec![0, 50, 255]);
        with_file("hu.json", hu, |path| {
            let opacity =
                |settings: &RenderSettings, x: f64| chosen(settings, &volume).unwrap().evaluate(x / 255.0)[3];
            let usual = settings(path);
            let stretched = RenderSettings { tf_range: Some(TransferRange::Stretch), ..settings(path) };
            assert!((opacity(&usual, 125.0) - 0.5).abs() < 1e-9 && opacity(&usual, 90.0) == 0.0);
            assert!((opacity(&stretched, 127.5) - 0.5).abs() < 1e-9);
            assert!(notes(&usual, &volume).is_empty(), "{:?}", notes(&usual, &volume));
            // A session that embeds the file renders it alike.
            for before in [usual, stretched] {
                let mut after = before.clone();
                crate::session_files::take_in(&mut after);
                assert!(after.tf.as_ref().unwrap().starts_with('{'));
                assert_eq!(chosen(&after, &volume).unwrap(), chosen(&before, &volume).unwrap());
            }
        });
    }

    #[test]
    fn usual_colour_maps_are_stretched_with_a_note() {
        let map = r#"[{"Name":"a","RGBPoints":[-1,0,0,0, 1,1,1,1],"Points":[-1,0,0.5,0, 1,1,0.5,0]}]"#;
        let volume = opened(vec![0, 50, 255]);
        with_file("map.json", map, |path| {
            assert!((chosen(&settings(path), &volume).unwrap().evaluate(0.5)[3] - 0.5).abs() < 1e-9);
            let said = notes(&settings(path), &volume);
            assert!(said.len() == 1 && said[0].ends_with("--tf-range data keeps them"), "{said:?}");
            let kept = RenderSettings { tf_range: Some(TransferRange::Data), ..settings(path) };
            assert!((chosen(&kept, &volume).unwrap().evaluate(0.5)[3] - 1.0).abs() < 1e-6);
        });
        let data = RenderSettings { tf_range: Some(TransferRange::Data), ..settings("grey") };
        let error = chosen(&data, &volume).unwrap_err().to_string();
        assert!(error.contains("--tf-range data") && error.contains("range"), "{error}");
    }

    #[test]
    fn values_run_by_their_logarithm() {
        let volume = opened(vec![0, 1, 255]);
        let log = RenderSettings {
            scale: Some(ValueScale::Log),
            ..settings(r#"{"points":[[0,0,0,0,0],[1,1,1,1,1]]}"#)
        };
        let transfer = chosen(&log, &volume).unwrap();
        for (x, expected) in [(0.0, 0.0), (1.0, 0.0), (16.0, 0.500_353), (255.0, 1.0)] {
            let found = transfer.evaluate(x / 255.0)[3];
            assert!((found - expected).abs() < 0.25 / 255.0, "{x}: {found}");
        }
        assert!(chosen(&log, &opened(vec![0, 0])).is_err());
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
