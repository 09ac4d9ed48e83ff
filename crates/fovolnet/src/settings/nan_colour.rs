use super::parse;
use fovol_core::TransferFunction;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// Appearance of NaN: of samples that touch a voxel that is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum NanColour {
    /// Transparent.
    #[default]
    Transparent,
    /// Colour from the file of the transfer function; transparent if it has none.
    File,
    /// Red, green, blue and opacity per voxel, 0…1.
    Colour([f64; 4]),
}

/// Expected values, for error messages.
const EXPECTED: &str = "use transparent, file, or R,G,B,A, each from 0 to 1";

impl NanColour {
    /// Sets this colour of NaN in `transfer`.
    pub fn of(self, transfer: TransferFunction) -> fovol_core::Result<TransferFunction> {
        match self {
            Self::Transparent => Ok(transfer.without_nan()),
            Self::File => Ok(transfer),
            Self::Colour(colour) => transfer.with_nan(colour),
        }
    }

    fn checked(colour: [f64; 4]) -> Result<Self, String> {
        if colour.iter().all(|x| (0.0..=1.0).contains(x)) {
            return Ok(Self::Colour(colour));
        }
        let [r, g, b, a] = colour;
        Err(format!("{r},{g},{b},{a} is no colour for NaN; {EXPECTED}"))
    }
}

impl fmt::Display for NanColour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Transparent => f.write_str("transparent"),
            Self::File => f.write_str("file"),
            Self::Colour([r, g, b, a]) => write!(f, "{r},{g},{b},{a}"),
        }
    }
}

impl FromStr for NanColour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "transparent" => Ok(Self::Transparent),
            "file" => Ok(Self::File),
            _ => {
                let colour = parse::numbers::<4>(text)
                    .map_err(|_| format!("`{text}` is no colour for NaN; {EXPECTED}"))?;
                Self::checked(colour)
            }
        }
    }
}

/// Serialised form: a word, or a list of four numbers.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "expected transparent, file, or [R, G, B, A]")]
enum Written {
    Colour([f64; 4]),
    Text(String),
}

impl Serialize for NanColour {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Colour(colour) => Written::Colour(*colour),
            word => Written::Text(word.to_string()),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for NanColour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::Colour(colour) => Self::checked(colour),
            Written::Text(text) => text.parse(),
        }
        .map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_as_they_are_written() {
        #[derive(Serialize, Deserialize)]
        struct Table {
            nan: NanColour,
        }
        for nan in [NanColour::Transparent, NanColour::File, NanColour::Colour([1.0, 0.5, 0.0, 0.25])] {
            assert_eq!(nan.to_string().parse(), Ok(nan));
            let text = toml::to_string(&Table { nan }).unwrap();
            assert_eq!(toml::from_str::<Table>(&text).unwrap().nan, nan, "{text}");
        }
        for bad in ["red", "1,0,0", "1,0,0,2", "-1,0,0,1", "nan,0,0,1"] {
            assert!(bad.parse::<NanColour>().unwrap_err().contains("R,G,B,A"), "{bad}");
        }
        assert!(toml::from_str::<Table>("nan = [0.0, 0.0, 0.0, 1.5]").is_err());
        assert!(toml::from_str::<Table>("nan = [0.0, 0.0]").is_err());
    }
}
