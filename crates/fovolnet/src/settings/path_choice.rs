use super::{CameraChoice, toml_text};
use crate::Result;
use fovol_core::{Camera, CameraPath, Keyframe};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Camera path as flags and sessions give it. Its text is the name of a path, or anything else for [`Self::Toml`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum PathChoice {
    /// Once round the volume over all frames, from the default view on.
    Turntable,
    /// Slow orbit, see [`CameraPath::Orbit`].
    Orbit,
    /// The paper's fly-through, see [`CameraPath::Flythrough`].
    Flythrough,
    /// TOML file of keyframes, or its content.
    Toml(String),
}

/// Content of a TOML file of keyframes.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keyframes {
    keyframe: Vec<Stop>,
}

/// Keyframe in a file. Unlike [`Keyframe`] it rejects unknown fields.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stop {
    frame: f64,
    eye: DVec3,
    target: DVec3,
    fovy: f64,
}

impl From<Stop> for Keyframe {
    fn from(Stop { frame, eye, target, fovy }: Stop) -> Self {
        Self { frame, camera: Camera::at(eye, target, fovy) }
    }
}

impl From<&Keyframe> for Stop {
    fn from(key: &Keyframe) -> Self {
        let Camera { eye, target, fovy, .. } = key.camera;
        Self { frame: key.frame, eye, target, fovy }
    }
}

impl PathChoice {
    /// Path through `keyframes`, as the content of a TOML file.
    pub fn through(keyframes: &[Keyframe]) -> Self {
        Self::Toml(path_text(keyframes))
    }

    /// Cameras of the path; reads the file if there is one.
    ///
    /// # Errors
    /// A file that is missing or has other content; keyframes that do not rise or have unusable cameras.
    pub fn cameras(&self) -> Result<CameraChoice> {
        Ok(match self {
            Self::Turntable => CameraChoice::Turntable,
            Self::Orbit => CameraPath::Orbit.into(),
            Self::Flythrough => CameraPath::Flythrough.into(),
            Self::Toml(text) => {
                let read: Keyframes = toml_text::read(
                    text,
                    "--path",
                    "turntable, orbit, flythrough, or a TOML file of [[keyframe]] tables with frame, eye, target and fovy",
                )?;
                CameraPath::through(read.keyframe.into_iter().map(Keyframe::from).collect())?.into()
            }
        })
    }

    /// Name of the path, or its text.
    fn text(&self) -> &str {
        match self {
            Self::Turntable => "turntable",
            Self::Orbit => "orbit",
            Self::Flythrough => "flythrough",
            Self::Toml(text) => text,
        }
    }
}

/// Text of `keyframes` as TOML, for [`PathChoice::Toml`] and `--path`.
///
/// # Panics
/// Never: numbers can always be written as TOML.
pub fn path_text(keyframes: &[Keyframe]) -> String {
    toml::to_string(&Keyframes { keyframe: keyframes.iter().map(Stop::from).collect() })
        .expect("numbers can be written as TOML")
}

impl From<String> for PathChoice {
    fn from(text: String) -> Self {
        let named = [Self::Turntable, Self::Orbit, Self::Flythrough];
        named.into_iter().find(|path| path.text() == text).unwrap_or(Self::Toml(text))
    }
}

impl From<&str> for PathChoice {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<PathChoice> for String {
    fn from(choice: PathChoice) -> Self {
        choice.text().to_owned()
    }
}

impl fmt::Display for PathChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_read_back() {
        let keys = [Keyframe { frame: 0.0, camera: Camera::on_sphere(0.0, 10.0, 2.0, 35.0) }];
        for path in [PathChoice::Turntable, PathChoice::Orbit, PathChoice::through(&keys)] {
            assert_eq!(PathChoice::from(path.to_string()), path);
        }
        assert_eq!(PathChoice::from("a.toml"), PathChoice::Toml("a.toml".into()));
    }

    #[test]
    fn keyframes_are_read_from_text_or_from_a_file() {
        let camera = |azimuth| Camera::on_sphere(azimuth, 10.0, 2.0, 35.0);
        let keys = vec![
            Keyframe { frame: 0.0, camera: camera(0.0) },
            Keyframe { frame: 30.0, camera: camera(70.0) },
        ];
        let choice = PathChoice::through(&keys);
        let expected = CameraChoice::Along(CameraPath::Keyframes(keys));
        assert_eq!(choice.cameras().unwrap(), expected);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.toml");
        std::fs::write(&file, choice.to_string()).unwrap();
        assert_eq!(PathChoice::from(file.display().to_string()).cameras().unwrap(), expected);
    }

    #[test]
    fn what_is_no_path_is_refused_in_one_line() {
        for bad in ["nowhere.toml", "frame = 3", "[[keyframe]]\nframe = 1\n", ""] {
            let error = PathChoice::from(bad).cameras().unwrap_err().to_string();
            assert!(error.contains("--path takes turntable, orbit") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn unknown_words_are_named() {
        let key = "[[keyframe]]\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";
        PathChoice::from(key).cameras().unwrap();
        for (text, word) in [(format!("{key}up = [0, 1, 0]\n"), "up"), (format!("bogus = 1\n{key}"), "bogus")]
        {
            let error = PathChoice::from(text).cameras().unwrap_err().to_string();
            assert!(error.contains(&format!("unknown field `{word}`")) && error.contains("line "), "{error}");
        }
    }
}
