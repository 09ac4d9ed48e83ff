use fovol_core::TransferFunction;

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Built-in presets, one for each procedural volume.
        const PRESETS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../assets/presets/", $name, ".json")))),*
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
pub fn kinds() -> [Kind; 4] {
    let kind = |description, names| Kind { description, names };
    [
        kind("from the histogram, or the preset of a procedural volume", vec!["auto"]),
        kind("black to white, opacity rising with the value", vec!["grey"]),
        kind("presets of the procedural volumes", PRESETS.iter().map(|(name, _)| *name).collect()),
        kind("colour maps, with the opacity of auto", COLOUR_MAPS.iter().map(|(name, _)| *name).collect()),
    ]
}

/// Whether `name` is one of [`names`], ignoring case.
pub(crate) fn is_name(name: &str) -> bool {
    names().iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// Preset of that name.
pub(super) fn preset(name: &str) -> Option<TransferFunction> {
    let (_, text) = PRESETS.iter().find(|(known, _)| *known == name)?;
    Some(serde_json::from_str(text).expect("presets are checked by a test"))
}

/// Colour map of that name.
pub(super) fn colour_map(name: &str) -> Option<&'static colorous::Gradient> {
    COLOUR_MAPS.iter().find(|(known, _)| *known == name).map(|(_, gradient)| gradient)
}
