use crate::{RenderSettings, Result, toml_text};
use fovol_core::{Camera, CameraPath, Keyframe};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What a file of keyframes holds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keyframes {
    keyframe: Vec<Stop>,
}

/// A keyframe as it is written. A [`Keyframe`] itself passes over words that it does not know.
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
        Self { frame, camera: Camera { eye, target, fovy } }
    }
}

impl From<&Keyframe> for Stop {
    fn from(key: &Keyframe) -> Self {
        let Camera { eye, target, fovy } = key.camera;
        Self { frame: key.frame, eye, target, fovy }
    }
}

/// Where frames are seen from, as `settings` say.
///
/// # Errors
/// A camera that sees nothing, a file that cannot be read.
pub fn camera_path(settings: &RenderSettings) -> Result<CameraPath> {
    if let Some([ex, ey, ez, tx, ty, tz, fovy]) = settings.camera {
        let camera = Camera::new(DVec3::new(ex, ey, ez), DVec3::new(tx, ty, tz), fovy)?;
        return Ok(CameraPath::Still(camera));
    }
    match settings.path.as_deref().unwrap_or("orbit") {
        "orbit" => Ok(CameraPath::Orbit),
        "flythrough" => Ok(CameraPath::Flythrough),
        file => {
            let read: Keyframes = toml_text::read(
                file,
                "--path",
                "orbit, flythrough, or a TOML file of [[keyframe]] tables with frame, eye, target and fovy",
            )?;
            Ok(CameraPath::through(read.keyframe.into_iter().map(Keyframe::from).collect())?)
        }
    }
}

/// `keyframes` as [`RenderSettings::path`] takes them in place of the name of a file.
///
/// # Panics
/// Never: numbers can be written as TOML.
pub fn path_text(keyframes: &[Keyframe]) -> String {
    toml::to_string(&Keyframes { keyframe: keyframes.iter().map(Stop::from).collect() })
        .expect("numbers can be written as TOML")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(path: String) -> RenderSettings {
        RenderSettings { path: Some(path), ..RenderSettings::default() }
    }

    #[test]
    fn keyframes_stand_in_settings_or_in_a_file() {
        let camera = |azimuth| Camera::on_sphere(azimuth, 10.0, 2.0, 35.0);
        let keys = vec![
            Keyframe { frame: 0.0, camera: camera(0.0) },
            Keyframe { frame: 30.0, camera: camera(70.0) },
        ];
        let text = path_text(&keys);
        let expected = CameraPath::Keyframes(keys);
        assert_eq!(camera_path(&settings(text.clone())).unwrap(), expected);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.toml");
        std::fs::write(&file, text).unwrap();
        assert_eq!(camera_path(&settings(file.display().to_string())).unwrap(), expected);
    }

    #[test]
    fn what_is_no_path_is_refused_in_one_line() {
        for bad in ["nowhere.toml", "frame = 3", "[[keyframe]]\nframe = 1\n", ""] {
            let error = camera_path(&settings(bad.into())).unwrap_err().to_string();
            assert!(error.contains("--path takes orbit") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn unknown_words_are_named() {
        let key = "[[keyframe]]\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";
        camera_path(&settings(key.into())).unwrap();
        for (text, word) in [(format!("{key}up = [0, 1, 0]\n"), "up"), (format!("bogus = 1\n{key}"), "bogus")]
        {
            let error = camera_path(&settings(text)).unwrap_err().to_string();
            assert!(error.contains(&format!("unknown field `{word}`")) && error.contains("line "), "{error}");
        }
    }
}
