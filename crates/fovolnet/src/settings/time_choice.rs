use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Time points of a volume that are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "TimeText", into = "TimeText")]
pub enum TimeChoice {
    /// One, from 0 on.
    Point(usize),
    /// A clip from one time point to another, or to the last.
    Clip {
        /// The first.
        first: usize,
        /// The last; `None` for the last that there is.
        last: Option<usize>,
    },
}

impl TimeChoice {
    /// The first time point.
    pub fn first(self) -> usize {
        match self {
            Self::Point(point) => point,
            Self::Clip { first, .. } => first,
        }
    }

    /// Time points of a clip of a volume that has `count`; `None` for a single one.
    ///
    /// # Errors
    /// Time points that are not there.
    pub fn clip(self, count: usize) -> Result<Option<RangeInclusive<usize>>> {
        let Self::Clip { first, last } = self else { return Ok(None) };
        let last = last.unwrap_or(count.saturating_sub(1));
        if first > last || last >= count {
            return Err(Error::Setting(format!(
                "--time {self} is not there: the volume has {count} time points, from 0 on"
            )));
        }
        Ok(Some(first..=last))
    }
}

impl From<usize> for TimeChoice {
    fn from(point: usize) -> Self {
        Self::Point(point)
    }
}

impl fmt::Display for TimeChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point(point) => write!(f, "{point}"),
            Self::Clip { first: 0, last: None } => f.write_str("all"),
            Self::Clip { first, last: None } => write!(f, "{first}.."),
            Self::Clip { first, last: Some(last) } => write!(f, "{first}..{last}"),
        }
    }
}

impl FromStr for TimeChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = |_| {
            format!("`{text}` is no time point; use its number, all, or a first and last one such as 2..8")
        };
        if text.eq_ignore_ascii_case("all") {
            return Ok(Self::Clip { first: 0, last: None });
        }
        let Some((first, last)) = text.split_once("..") else {
            return text.parse().map(Self::Point).map_err(wrong);
        };
        let first = first.parse().map_err(wrong)?;
        let last = if last.is_empty() { None } else { Some(last.parse().map_err(wrong)?) };
        Ok(Self::Clip { first, last })
    }
}

/// A number, or text for a clip.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum TimeText {
    Number(usize),
    Text(String),
}

impl TryFrom<TimeText> for TimeChoice {
    type Error = String;

    fn try_from(text: TimeText) -> std::result::Result<Self, String> {
        match text {
            TimeText::Number(point) => Ok(Self::Point(point)),
            TimeText::Text(text) => text.parse(),
        }
    }
}

impl From<TimeChoice> for TimeText {
    fn from(choice: TimeChoice) -> Self {
        match choice {
            TimeChoice::Point(point) => Self::Number(point),
            clip => Self::Text(clip.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_back() {
        for (text, choice) in [
            ("3", TimeChoice::Point(3)),
            ("all", TimeChoice::Clip { first: 0, last: None }),
            ("2..", TimeChoice::Clip { first: 2, last: None }),
            ("2..8", TimeChoice::Clip { first: 2, last: Some(8) }),
        ] {
            assert_eq!((text.parse(), choice.to_string()), (Ok(choice), text.to_owned()));
            let json = serde_json::to_string(&choice).unwrap();
            assert_eq!(serde_json::from_str::<TimeChoice>(&json).unwrap(), choice);
        }
        assert!("soon".parse::<TimeChoice>().unwrap_err().contains("2..8"));
    }

    #[test]
    fn clips_lie_within_the_volume() {
        let clip = |text: &str| text.parse::<TimeChoice>().unwrap().clip(5);
        assert_eq!(clip("3").unwrap(), None);
        assert_eq!(clip("all").unwrap(), Some(0..=4));
        assert_eq!(clip("1..3").unwrap(), Some(1..=3));
        assert!(clip("1..5").is_err() && clip("3..2").is_err() && clip("5..").is_err());
    }
}
