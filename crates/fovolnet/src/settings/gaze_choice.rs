use super::{parse, toml_text};
use crate::Result;
use fovol_core::GazePath;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Gaze as flags and sessions give it. Its text is `X,Y`, `wander`, or anything else for [`Self::Toml`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum GazeChoice {
    /// One point for every frame, as fractions of the picture from its top left.
    Fixed([f64; 2]),
    /// Smooth random walk, which depends on the seed.
    Wander,
    /// TOML file of stops, or its content.
    Toml(String),
}

/// Name of [`GazeChoice::Wander`].
const WANDER: &str = "wander";

/// Content of a TOML file of stops.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Stops {
    stops: Vec<[f64; 3]>,
}

impl GazeChoice {
    /// Gaze of every frame; reads the file if there is one. A walk follows `seed`.
    ///
    /// # Errors
    /// A file that is missing or has other content; stops whose frames do not rise.
    pub fn path(&self, seed: u64) -> Result<GazePath> {
        match self {
            Self::Fixed(gaze) => Ok(GazePath::Fixed(*gaze)),
            Self::Wander => Ok(GazePath::Wander { seed }),
            Self::Toml(text) => {
                let expected = "X,Y, wander, or a TOML file with stops = [[frame, x, y], …]";
                let read: Stops = toml_text::read(text, "--gaze", expected)?;
                Ok(GazePath::scripted(read.stops)?)
            }
        }
    }
}

impl Default for GazeChoice {
    /// The centre of the picture.
    fn default() -> Self {
        Self::Fixed(GazePath::default().gaze(0))
    }
}

impl From<String> for GazeChoice {
    fn from(text: String) -> Self {
        match parse::numbers::<2>(&text) {
            Ok(gaze) => Self::Fixed(gaze),
            Err(_) if text == WANDER => Self::Wander,
            Err(_) => Self::Toml(text),
        }
    }
}

impl From<&str> for GazeChoice {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<GazeChoice> for String {
    fn from(choice: GazeChoice) -> Self {
        match choice {
            GazeChoice::Toml(text) => text,
            other => other.to_string(),
        }
    }
}

impl fmt::Display for GazeChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed([x, y]) => write!(f, "{x},{y}"),
            Self::Wander => f.write_str(WANDER),
            Self::Toml(text) => f.write_str(text),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_read_back() {
        for (text, choice) in [
            ("0.3,0.4", GazeChoice::Fixed([0.3, 0.4])),
            ("wander", GazeChoice::Wander),
            ("gaze.toml", GazeChoice::Toml("gaze.toml".into())),
        ] {
            assert_eq!((GazeChoice::from(text), choice.to_string()), (choice, text.to_owned()));
        }
        assert_eq!(GazeChoice::Wander.path(3).unwrap(), GazePath::Wander { seed: 3 });
    }

    #[test]
    fn unknown_words_of_a_gaze_are_named() {
        let gaze = |text: &str| GazeChoice::from(text).path(0);
        assert_eq!(gaze("stops = [[0, 0.5, 0.25]]").unwrap().gaze(7), [0.5, 0.25]);
        let error = gaze("stops = [[0, 0.5, 0.5]]\nspeed = 3").unwrap_err().to_string();
        assert!(error.contains("speed") && error.contains("line 2") && !error.contains('\n'), "{error}");
    }
}
