use crate::{RenderSettings, Sampling};
use fovol_core::did_you_mean;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How the pixels of a planned frame are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum Way {
    /// Every pixel is marched with the shadows of the settings.
    ExactLight,
    /// Every pixel is marched with cached shadows.
    CachedLight,
    /// Some pixels are marched with shadow rays; a guide and the reconstructed light ratio give the others.
    LightRatio,
    /// Like [`Self::LightRatio`], with 16 shadow rays a pixel.
    FewShadowRays,
    /// Some pixels are marched; the colours of the others are reconstructed.
    Colours,
}

/// Shadow rays of a pixel in [`Way::FewShadowRays`].
pub const FEW: u32 = 16;

impl Way {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::ExactLight, Self::CachedLight, Self::LightRatio, Self::FewShadowRays, Self::Colours];

    /// Name in reports and sessions.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExactLight => "exact light",
            Self::CachedLight => "cached light",
            Self::LightRatio => "light ratio",
            Self::FewShadowRays => "few shadow rays",
            Self::Colours => "colours",
        }
    }

    /// Whether every pixel is marched.
    pub fn is_full(self) -> bool {
        matches!(self, Self::ExactLight | Self::CachedLight)
    }

    /// The way of frames that are made as `settings` say.
    pub fn of(settings: &RenderSettings) -> Self {
        if settings.sampling == Sampling::Full {
            Self::ExactLight
        } else if settings.guide_kind() == crate::Guide::None {
            Self::Colours
        } else {
            Self::LightRatio
        }
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Way {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|way| way.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!(
                "`{text}` is no way to make frames; use {}{}",
                names.join(", "),
                did_you_mean(text, &names)
            )
        })
    }
}

impl TryFrom<String> for Way {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Way> for &'static str {
    fn from(way: Way) -> Self {
        way.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for way in Way::ALL {
            assert_eq!(way.name().parse(), Ok(way));
        }
        assert!("cached lihgt".parse::<Way>().unwrap_err().contains("did you mean cached light?"));
    }
}
