use fovol_core::{ControlPoint, TransferFunction};

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../assets/presets/", $name, ".json")))),*]
    };
}

/// One preset for each procedural volume.
const OF_PROCEDURAL: &[(&str, &str)] =
    presets!("vortices", "supernova", "head", "engine", "angiogram", "reptile", "plume", "marschner-lobb");

/// Presets for scans: those of CT are in Hounsfield units.
const OF_SCANS: &[(&str, &str)] =
    presets!("ct-bone", "ct-soft-tissue", "ct-skin", "ct-lung", "ct-vessels", "mr");

/// Colours of single channels of a microscope.
const CHANNELS: &[(&str, [f64; 3])] = &[
    ("red", [1.0, 0.0, 0.0]),
    ("green", [0.0, 1.0, 0.0]),
    ("blue", [0.0, 0.2, 1.0]),
    ("cyan", [0.0, 1.0, 1.0]),
    ("magenta", [1.0, 0.0, 1.0]),
    ("yellow", [1.0, 1.0, 0.0]),
];

/// Opacity per voxel at the upper end of a channel.
const CHANNEL_OPACITY: f64 = 0.3;

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

/// Text of `transfer` as JSON, which `find` accepts in place of a name.
///
/// # Panics
/// Never: numbers can always be written as JSON.
pub fn text(transfer: &TransferFunction) -> String {
    serde_json::to_string(transfer).expect("numbers can be written as JSON")
}

/// All names that `find` accepts.
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

/// All groups of transfer functions that `find` knows by name.
pub fn kinds() -> [Kind; 6] {
    let named = |presets: &[(&'static str, &str)]| presets.iter().map(|(name, _)| *name).collect();
    let kind = |description, names| Kind { description, names };
    [
        kind("from the histogram, or the preset of a procedural volume", vec!["auto"]),
        kind("black to white, opacity rising with the value", vec!["grey"]),
        kind("presets of the procedural volumes", named(OF_PROCEDURAL)),
        kind("scans: CT in Hounsfield units, and MR over the values shown", named(OF_SCANS)),
        kind(
            "a channel of a microscope: black to a colour",
            CHANNELS.iter().map(|(name, _)| *name).collect(),
        ),
        kind("colour maps, with the opacity of auto", COLOUR_MAPS.iter().map(|(name, _)| *name).collect()),
    ]
}

/// Whether `name` is one of [`names`], ignoring case.
pub(crate) fn is_name(name: &str) -> bool {
    names().iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// Preset of that name.
pub(super) fn preset(name: &str) -> Option<TransferFunction> {
    if let Some((_, colour)) = CHANNELS.iter().find(|(known, _)| *known == name) {
        let ends = [ControlPoint::new(0.0, [0.0; 3], 0.0), ControlPoint::new(1.0, *colour, CHANNEL_OPACITY)];
        return TransferFunction::new(ends.to_vec()).ok();
    }
    let (_, text) = OF_PROCEDURAL.iter().chain(OF_SCANS).find(|(known, _)| *known == name)?;
    Some(serde_json::from_str(text).expect("presets are checked by a test"))
}

/// Colour map of that name.
pub(super) fn colour_map(name: &str) -> Option<&'static colorous::Gradient> {
    COLOUR_MAPS.iter().find(|(known, _)| *known == name).map(|(_, gradient)| gradient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_of_ct_lie_at_their_hounsfield_units() {
        let opacity = |name: &str, value: f64| {
            let transfer = preset(name).unwrap().over([-1024.0, 3071.0]);
            transfer.evaluate((value + 1024.0) / 4095.0)[3]
        };
        let (air, lung, fat, muscle, bone) = (-1000.0, -750.0, -90.0, 55.0, 900.0);
        for (name, shown, hidden) in [
            ("ct-bone", &[bone][..], &[air, lung, fat, muscle][..]),
            ("ct-soft-tissue", &[fat, muscle, bone], &[air, lung]),
            ("ct-skin", &[fat, muscle, bone], &[air, lung]),
            ("ct-lung", &[lung], &[air, fat, muscle, bone]),
            ("ct-vessels", &[350.0, bone], &[air, lung, fat, muscle]),
        ] {
            assert!(shown.iter().all(|value| opacity(name, *value) > 0.01), "{name}");
            assert!(hidden.iter().all(|value| opacity(name, *value) < 1e-9), "{name}");
        }
    }

    #[test]
    fn channels_have_their_colours() {
        assert_eq!(preset("magenta").unwrap().evaluate(1.0), [1.0, 0.0, 1.0, CHANNEL_OPACITY]);
        assert_eq!(preset("green").unwrap().evaluate(0.0), [0.0; 4]);
    }
}
