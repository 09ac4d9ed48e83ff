use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Orientation of a volume in world space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Orientation {
    /// The grid's axes are those of the world: +x right, +y up, +z towards the viewer.
    Grid,
    /// The patient stands upright: +x is the patient's left, +y superior, +z anterior.
    Patient,
}

impl FromStr for Orientation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "grid" => Ok(Self::Grid),
            "patient" => Ok(Self::Patient),
            _ => {
                let meant = did_you_mean(text, &["grid", "patient"]);
                Err(format!("`{text}` is no orientation; use grid or patient{meant}"))
            }
        }
    }
}

/// Side from which a volume is viewed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NamedView {
    /// From the front: from +z.
    Anterior,
    /// From behind: from −z.
    Posterior,
    /// From the patient's left: from +x.
    Left,
    /// From the patient's right: from −x.
    Right,
    /// From above: from +y; the front is below in the picture.
    Superior,
    /// From below: from −y; the front is on top in the picture.
    Inferior,
}

impl NamedView {
    /// All six views.
    pub const ALL: [Self; 6] =
        [Self::Anterior, Self::Posterior, Self::Left, Self::Right, Self::Superior, Self::Inferior];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Anterior => "anterior",
            Self::Posterior => "posterior",
            Self::Left => "left",
            Self::Right => "right",
            Self::Superior => "superior",
            Self::Inferior => "inferior",
        }
    }

    /// Azimuth and elevation of the eye, in degrees.
    pub(crate) fn angles(self) -> [f64; 2] {
        match self {
            Self::Anterior => [0.0, 0.0],
            Self::Posterior => [180.0, 0.0],
            Self::Left => [90.0, 0.0],
            Self::Right => [-90.0, 0.0],
            Self::Superior => [0.0, 90.0],
            Self::Inferior => [0.0, -90.0],
        }
    }
}

impl FromStr for NamedView {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|view| view.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("`{text}` is no view; use one of {}{}", names.join(", "), did_you_mean(text, &names))
        })
    }
}
