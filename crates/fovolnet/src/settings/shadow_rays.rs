use fovol_core::did_you_mean;
use std::fmt;
use std::num::NonZero;
use std::str::FromStr;

/// Number of shadow rays of each pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum ShadowRays {
    /// One from every sample, as in the paper.
    #[default]
    Exact,
    /// This number, at most [`ShadowRays::MOST`], from samples chosen at random by their light. Pictures have noise, whose
    /// mean is 0.
    Few(NonZero<u32>),
}

impl ShadowRays {
    /// Most shadow rays of a pixel that can be asked for.
    pub const MOST: u32 = 256;

    /// Number of shadow rays of a pixel, unless every sample has one.
    pub(crate) fn few(self) -> Option<u32> {
        match self {
            Self::Exact => None,
            Self::Few(count) => Some(count.get()),
        }
    }
}

impl fmt::Display for ShadowRays {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Few(count) => write!(f, "{count}"),
        }
    }
}

impl FromStr for ShadowRays {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("exact") {
            return Ok(Self::Exact);
        }
        match text.parse::<NonZero<u32>>() {
            Ok(count) if count.get() <= Self::MOST => Ok(Self::Few(count)),
            _ => {
                let meant = did_you_mean(text, &["exact"]);
                Err(format!(
                    "`{text}` is no number of shadow rays; use exact, or 1 to {} for each pixel{meant}",
                    Self::MOST
                ))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_are_read_as_they_are_written() {
        for text in ["exact", "1", "16", "256"] {
            assert_eq!(text.parse::<ShadowRays>().unwrap().to_string(), text);
        }
        for text in ["0", "257", "-1", "1.5", "exat", ""] {
            assert!(text.parse::<ShadowRays>().unwrap_err().contains("use exact, or 1 to 256"));
        }
        assert_eq!("16".parse::<ShadowRays>().unwrap().few(), Some(16));
    }
}
