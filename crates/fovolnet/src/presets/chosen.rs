use super::automatic::{automatic, coloured};
use super::catalogue::{colour_map, names, preset};
use super::channel_colour::channel_colour;
use super::label_colours::label_colours;
use crate::{Error, OpenVolume, RenderSettings, Result, TransferChoice, TransferRange, ValueScale};
use fovol_core::{TransferFunction, Volume, did_you_mean, path_of_text};
use fovol_io::transfer_function::{self, Imported};

/// Opacity per voxel at the upper end of the grey ramp.
const GREY_OPACITY: f64 = 0.3;

/// Finds the transfer function `what` for `volume`: `auto`, a preset, a colour map (with the opacity of `auto`), a
/// file, or JSON text. `auto` is the preset of a procedural volume, else one made from the histogram. Names ignore
/// case.
///
/// The result covers the displayed range of the volume. Data values of a file keep their colours.
///
/// # Errors
/// An unknown name, a file that cannot be read or is invalid.
pub fn find(what: &str, volume: &OpenVolume) -> Result<TransferFunction> {
    of_choice(&what.into(), volume)
}

/// Transfer function `what` for `volume`, in the place that it means and over the displayed range.
pub(crate) fn of_choice(what: &TransferChoice, volume: &OpenVolume) -> Result<TransferFunction> {
    Ok(load(what, volume)?.as_meant().over(volume.volume.range()))
}

/// Transfer function that `settings` choose for `volume`, over the displayed range: see [`find`].
///
/// # Errors
/// Errors of [`find`]; data values requested of a function without any; a logarithmic scale without positive values.
pub fn chosen(settings: &RenderSettings, volume: &OpenVolume) -> Result<TransferFunction> {
    let what = &settings.transfer_function;
    let transfer = placed(what, &load(what, volume)?, settings.transfer_range)?;
    let transfer = settings.nan.of(transfer)?;
    let shown = volume.volume.range();
    // Functions in data values keep their place, whatever the scale.
    if settings.scale == ValueScale::Log && transfer.range().is_none() {
        return Ok(transfer.on_log_scale(shown, least_positive(&volume.volume))?);
    }
    Ok(transfer.over(shown))
}

/// Transfer function `imported` of the name `what`, with a range if it keeps its data values.
pub(super) fn placed(
    what: &TransferChoice,
    imported: &Imported,
    place: Option<TransferRange>,
) -> Result<TransferFunction> {
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
    volume.least_positive().filter(|least| *least < to).unwrap_or(0.0)
}

/// Loads the transfer function `what` for `volume`, in its original range.
pub(super) fn load(what: &TransferChoice, volume: &OpenVolume) -> Result<Imported> {
    match what {
        TransferChoice::Auto => Ok(automatic_for(volume).into()),
        TransferChoice::Named(name) => {
            named(&name.to_ascii_lowercase(), volume).map(Imported::from).ok_or_else(|| unknown(name))
        }
        TransferChoice::File(name) if is_file(name) => Ok(transfer_function::import(&path_of_text(name))?),
        TransferChoice::File(name) => Err(unknown(name)),
        TransferChoice::Json(text) => {
            let of_flag = |problem| Error::Setting(format!("the transfer function (--tf) {problem}"));
            Ok(of_json(text).map_err(of_flag)?.into())
        }
        TransferChoice::Function(function) => Ok(function.clone().into()),
    }
}

/// Transfer function of the JSON `text`; on failure, what is wrong with it.
pub(crate) fn of_json(text: &str) -> std::result::Result<TransferFunction, String> {
    serde_json::from_str(text).map_err(|e| {
        format!("cannot be read: {e}; expected {{\"points\":[[value,red,green,blue,opacity],…]}}")
    })
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

/// Content of the file `what` as JSON, for settings that place it at `place`. `None` if it cannot be read.
#[cfg(feature = "files")]
pub(crate) fn json_of_file(what: &TransferChoice, place: Option<TransferRange>) -> Option<TransferChoice> {
    let TransferChoice::File(name) = what else { return None };
    let imported = transfer_function::import(&path_of_text(name)).ok()?;
    let transfer = placed(what, &imported, place).ok()?;
    Some(TransferChoice::Json(super::text(&transfer)))
}

/// The component of coloured voxels that is their opacity.
const ALPHA: usize = 3;

/// Automatic transfer function of `volume`.
fn automatic_for(volume: &OpenVolume) -> TransferFunction {
    if volume.colours.is_some() && volume.volume.contents().component == ALPHA {
        return TransferFunction::grey_ramp(1.0);
    }
    let own = volume.procedural.and_then(|kind| preset(kind.name()));
    let of_file = || label_colours(&volume.volume).or_else(|| channel_colour(&volume.volume));
    own.or_else(of_file).unwrap_or_else(|| automatic(&volume.volume))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RenderOverrides;
    use crate::presets::automatic::colour;
    use crate::presets::{notes, text};
    use fovol_core::Grid;
    use fovol_io::procedural::Procedural;
    use std::sync::Arc;

    fn opened(values: Vec<u8>) -> OpenVolume {
        let grid = Grid::new([values.len(), 1, 1], [1.0; 3]).unwrap();
        let volume = Arc::new(Volume::from_values(grid, values).unwrap());
        OpenVolume::of(volume, "test")
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

    fn settings(tf: &str) -> RenderOverrides {
        RenderOverrides { tf: Some(tf.into()), ..RenderOverrides::default() }
    }

    fn chosen(settings: &RenderOverrides, volume: &OpenVolume) -> Result<TransferFunction> {
        super::chosen(&settings.resolve().unwrap(), volume)
    }

    #[test]
    fn data_values_stay_unless_told_otherwise() {
        let hu = r#"[{"Name":"hu","RGBPoints":[100,0,0,0, 150,1,0,0],"Points":[100,0,0.5,0, 150,1,0.5,0]}]"#;
        let volume = opened(vec![0, 50, 255]);
        with_file("hu.json", hu, |path| {
            let opacity = |settings: &RenderOverrides, x: f64| {
                chosen(settings, &volume).unwrap().evaluate(x / 255.0)[3]
            };
            let usual = settings(path);
            let stretched = RenderOverrides { tf_range: Some(TransferRange::Stretch), ..settings(path) };
            assert!((opacity(&usual, 125.0) - 0.5).abs() < 1e-9 && opacity(&usual, 90.0) == 0.0);
            assert!((opacity(&stretched, 127.5) - 0.5).abs() < 1e-9);
            assert!(notes(&usual, &volume).is_empty(), "{:?}", notes(&usual, &volume));
            // A session that embeds the file renders it alike.
            for before in [usual, stretched] {
                let json = json_of_file(before.tf.as_ref().unwrap(), before.tf_range);
                assert!(matches!(json, Some(TransferChoice::Json(_))), "{json:?}");
                let after = RenderOverrides { tf: json, ..before.clone() };
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
            let kept = RenderOverrides { tf_range: Some(TransferRange::Data), ..settings(path) };
            assert!((chosen(&kept, &volume).unwrap().evaluate(0.5)[3] - 1.0).abs() < 1e-6);
        });
        let data = RenderOverrides { tf_range: Some(TransferRange::Data), ..settings("grey") };
        let error = chosen(&data, &volume).unwrap_err().to_string();
        assert!(error.contains("--tf-range data") && error.contains("range"), "{error}");
    }

    #[test]
    fn values_run_by_their_logarithm() {
        let volume = opened(vec![0, 1, 255]);
        let log = RenderOverrides {
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
}
