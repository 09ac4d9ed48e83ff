use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Which pixels are marched, and how they are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sampling {
    /// Every pixel.
    Full,
    /// The full grid, unsampled pixels ending at once.
    Reject,
    /// Positions drawn from the density; some are drawn twice.
    Direct,
    /// A mask, packed by stream compaction.
    Compact,
}

impl Sampling {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Full, Self::Reject, Self::Direct, Self::Compact];

    /// The name on the command line.
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
