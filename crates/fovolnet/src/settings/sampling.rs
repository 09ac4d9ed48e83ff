use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Method of choosing and marching pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// March every pixel.
    Full,
    /// March the full grid; rays of unsampled pixels end at once.
    Reject,
    /// March positions drawn at random from the density; some repeat.
    Direct,
    /// March the list that stream compaction makes from a mask.
    Compact,
}

impl Sampling {
    /// All four methods.
    pub const ALL: [Self; 4] = [Self::Full, Self::Reject, Self::Direct, Self::Compact];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Reject => "reject",
            Self::Direct => "direct",
            Self::Compact => "compact",
        }
    }
}

impl fmt::Display for Sampling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Sampling {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|s| s.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let meant = did_you_mean(text, &Self::ALL.map(Self::name));
            format!("`{text}` is no way of sampling; use auto, full, reject, direct or compact{meant}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised() {
        assert_eq!("Full".parse(), Ok(Sampling::Full));
        assert!("fulll".parse::<Sampling>().unwrap_err().ends_with("did you mean full?"));
    }
}
