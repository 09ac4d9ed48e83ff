use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Place of a transfer function that was made for data values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TransferRange {
    /// At its own data values.
    Data,
    /// Stretched over the displayed range.
    Stretch,
}

impl FromStr for TransferRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "data" => Ok(Self::Data),
            "stretch" => Ok(Self::Stretch),
            _ => {
                let meant = did_you_mean(text, &["data", "stretch"]);
                Err(format!("`{text}` is no place for a transfer function; use data or stretch{meant}"))
            }
        }
    }
}

/// Scale along which data values run through a transfer function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ValueScale {
    /// Linear scale.
    #[default]
    Linear,
    /// Logarithmic scale, from the smallest positive value shown.
    Log,
}

impl FromStr for ValueScale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "linear" => Ok(Self::Linear),
            "log" => Ok(Self::Log),
            _ => {
                let meant = did_you_mean(text, &["linear", "log"]);
                Err(format!("`{text}` is no scale; use linear or log{meant}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read() {
        assert_eq!("Data".parse(), Ok(TransferRange::Data));
        assert_eq!("log".parse(), Ok(ValueScale::Log));
        assert!("strech".parse::<TransferRange>().unwrap_err().ends_with("did you mean stretch?"));
        assert!("log10".parse::<ValueScale>().unwrap_err().contains("linear or log"));
    }
}
