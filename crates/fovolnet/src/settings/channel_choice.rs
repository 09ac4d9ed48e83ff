use fovol_core::MOST_VOLUMES;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Channels of a file that are shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ChannelChoice {
    /// One channel, from 0 on.
    One(usize),
    /// Several, blended.
    Several(Vec<usize>),
}

impl ChannelChoice {
    /// The first channel.
    pub fn first(&self) -> Option<usize> {
        self.numbers().first().copied()
    }

    /// All channels.
    pub fn numbers(&self) -> &[usize] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

impl From<usize> for ChannelChoice {
    fn from(channel: usize) -> Self {
        Self::One(channel)
    }
}

impl FromStr for ChannelChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<usize>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        match numbers.as_deref() {
            Ok([one]) => Ok(Self::One(*one)),
            Ok(several) if several.len() <= MOST_VOLUMES => Ok(Self::Several(several.to_vec())),
            Ok(several) => {
                Err(format!("{} channels are too many; at most {MOST_VOLUMES} are blended", several.len()))
            }
            Err(_) => Err(format!("`{text}` is no channel; use its number, or numbers such as 0,2")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_numbers() {
        assert_eq!("2".parse(), Ok(ChannelChoice::One(2)));
        assert_eq!("0, 3".parse(), Ok(ChannelChoice::Several(vec![0, 3])));
        assert_eq!("0,3".parse::<ChannelChoice>().unwrap().first(), Some(0));
        assert!("red".parse::<ChannelChoice>().unwrap_err().contains("0,2"));
        assert!("0,1,2,3,4".parse::<ChannelChoice>().unwrap_err().contains("at most 4"));
    }
}
