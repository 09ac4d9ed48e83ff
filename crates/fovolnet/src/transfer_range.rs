use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Where a transfer function that was made for data values belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TransferRange {
    /// At these data values.
    Data,
    /// From the lower to the upper end of what is shown.
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

/// How data values run along a transfer function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ValueScale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm, from the least positive value shown.
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
