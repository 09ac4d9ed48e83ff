use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Component of voxels that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ComponentChoice {
    /// One component, from 0 on.
    Number(usize),
    /// All: three or four components that are colours.
    Colours(Rgb),
}

/// The word `rgb`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rgb {
    /// The word itself.
    #[serde(rename = "rgb")]
    Rgb,
}

impl ComponentChoice {
    /// The component, unless all are shown.
    pub fn number(self) -> Option<usize> {
        match self {
            Self::Number(number) => Some(number),
            Self::Colours(_) => None,
        }
    }
}

impl FromStr for ComponentChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("rgb") {
            return Ok(Self::Colours(Rgb::Rgb));
        }
        let number = text.parse().map_err(|_| format!("`{text}` is no component; use its number, or rgb"))?;
        Ok(Self::Number(number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_numbers_or_colours() {
        assert_eq!("2".parse(), Ok(ComponentChoice::Number(2)));
        assert_eq!("RGB".parse(), Ok(ComponentChoice::Colours(Rgb::Rgb)));
        assert!("red".parse::<ComponentChoice>().unwrap_err().contains("rgb"));
        assert!("-1".parse::<ComponentChoice>().is_err());
    }
}
