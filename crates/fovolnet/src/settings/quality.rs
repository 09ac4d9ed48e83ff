use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Who decides how frames are made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// A planner, about everything that is not given; see [`crate::Planner`].
    Auto,
    /// The settings.
    #[default]
    Fixed,
}

impl Quality {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Fixed => "fixed",
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Auto, Self::Fixed]
            .into_iter()
            .find(|quality| quality.name().eq_ignore_ascii_case(text))
            .ok_or_else(|| {
                format!("`{text}` is no quality; use auto or fixed{}", did_you_mean(text, &["auto", "fixed"]))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for quality in [Quality::Auto, Quality::Fixed] {
            assert_eq!(quality.to_string().parse(), Ok(quality));
        }
        assert!("fxed".parse::<Quality>().unwrap_err().contains("did you mean fixed?"));
    }
}
