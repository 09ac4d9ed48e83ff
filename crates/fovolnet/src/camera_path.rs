use crate::{NamedView, RenderSettings, Result, WorldBox, toml_text};
use fovol_core::{Camera, CameraPath, Keyframe};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// TOML file of keyframes.
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

/// Camera path that `settings` choose for the volume in `world`.
///
/// # Errors
/// A camera that cannot be used, a file that cannot be read.
pub fn camera_path(settings: &RenderSettings, world: &WorldBox) -> Result<CameraPath> {
    if let Some([ex, ey, ez, tx, ty, tz, fovy]) = settings.camera {
        let camera = Camera::new(DVec3::new(ex, ey, ez), DVec3::new(tx, ty, tz), fovy)?;
        return Ok(CameraPath::Still(camera));
    }
    match settings.path.as_deref() {
        None if settings.frames.unwrap_or(1) > 1 => Ok(turntable(settings, world)),
        None => Ok(CameraPath::Still(default_view(settings, world))),
        Some("turntable") => Ok(turntable(settings, world)),
        Some("orbit") => Ok(CameraPath::Orbit),
        Some("flythrough") => Ok(CameraPath::Flythrough),
        Some(file) => {
            let read: Keyframes = toml_text::read(
                file,
                "--path",
                "turntable, orbit, flythrough, or a TOML file of [[keyframe]] tables with frame, eye, target and fovy",
            )?;
            Ok(CameraPath::through(read.keyframe.into_iter().map(Keyframe::from).collect())?)
        }
    }
}

/// Vertical field of view of the default view, in degrees.
const FOVY: f64 = 35.0;
/// Elevation of the default view in degrees, for volumes of unknown orientation.
const LOOKS_DOWN: f64 = 20.0;

/// Turntable over all frames, beginning with the default view.
fn turntable(settings: &RenderSettings, world: &WorldBox) -> CameraPath {
    let degrees = settings.turn.unwrap_or(360.0) / f64::from(settings.frames.unwrap_or(1));
    CameraPath::Turntable { start: default_view(settings, world), degrees }
}

/// View from the front or the named side that just fits the bounding sphere of the shown part into the frame.
fn default_view(settings: &RenderSettings, world: &WorldBox) -> Camera {
    let from_front = [0.0, if world.is_patient() { 0.0 } else { LOOKS_DOWN }];
    let [azimuth, elevation] = settings.view.map_or(from_front, NamedView::angles);
    let (centre, radius) = world.bounding_sphere();
    let size = settings.frame_size();
    let height = (FOVY.to_radians() * 0.5).tan();
    let least = height.min(height * f64::from(size.width) / f64::from(size.height));
    // The cone of view touches the sphere, so its half angle has the sine radius/distance.
    let distance = (radius / least.atan().sin()).max(MIN_DISTANCE);
    let camera = Camera::on_sphere(azimuth, elevation, distance, FOVY);
    Camera { eye: centre + camera.eye, target: centre, ..camera }
}

/// Smallest distance of the camera, for shown parts that are extremely thin.
const MIN_DISTANCE: f64 = 1e-3;

/// Text of `keyframes` as TOML, which [`RenderSettings::path`] accepts in place of a file name.
///
/// # Panics
/// Never: numbers can always be written as TOML.
pub fn path_text(keyframes: &[Keyframe]) -> String {
    toml::to_string(&Keyframes { keyframe: keyframes.iter().map(Stop::from).collect() })
        .expect("numbers can be written as TOML")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world_box::tests::cube;
    use fovol_core::FrameSize;

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
        assert_eq!(camera_path(&settings(text.clone()), &cube()).unwrap(), expected);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.toml");
        std::fs::write(&file, text).unwrap();
        assert_eq!(camera_path(&settings(file.display().to_string()), &cube()).unwrap(), expected);
    }

    #[test]
    fn what_is_no_path_is_refused_in_one_line() {
        for bad in ["nowhere.toml", "frame = 3", "[[keyframe]]\nframe = 1\n", ""] {
            let error = camera_path(&settings(bad.into()), &cube()).unwrap_err().to_string();
            assert!(error.contains("--path takes turntable, orbit") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn unknown_words_are_named() {
        let key = "[[keyframe]]\nframe = 0\neye = [0, 0, 2]\ntarget = [0, 0, 0]\nfovy = 35\n";
        camera_path(&settings(key.into()), &cube()).unwrap();
        for (text, word) in [(format!("{key}up = [0, 1, 0]\n"), "up"), (format!("bogus = 1\n{key}"), "bogus")]
        {
            let error = camera_path(&settings(text), &cube()).unwrap_err().to_string();
            assert!(error.contains(&format!("unknown field `{word}`")) && error.contains("line "), "{error}");
        }
    }

    /// Whether the whole cube is inside the frame that `camera` sees.
    fn sees_all(camera: &Camera, size: FrameSize) -> bool {
        let rays = camera.rays(size);
        let [forward, right, up] = rays.axes();
        (0..8).all(|corner: i32| {
            let side = |axis: i32| f64::from(corner >> axis & 1) - 0.5;
            let way = DVec3::new(side(0), side(1), side(2)) - rays.origin();
            let depth = way.dot(forward);
            let across = [right, up].map(|axis| way.dot(axis) / axis.length_squared() / depth);
            depth > 0.0 && across.iter().all(|at| at.abs() <= 1.0)
        })
    }

    #[test]
    fn the_default_view_shows_everything_at_any_aspect() {
        for size in ["1280x720", "720x1280", "64x64", "900x30"] {
            let size: FrameSize = size.parse().unwrap();
            for frames in [1, 8] {
                let settings =
                    RenderSettings { size: Some(size), frames: Some(frames), ..RenderSettings::default() };
                let path = camera_path(&settings, &cube()).unwrap();
                assert!((0..frames).all(|i| sees_all(&path.camera(i), size)), "{size} {frames}");
            }
        }
        let camera = camera_path(&RenderSettings::default(), &cube()).unwrap().camera(0);
        let nearer = Camera { eye: camera.eye * 0.8, ..camera };
        assert!(!sees_all(&nearer, FrameSize::default()), "it does not waste the frame");
    }

    #[test]
    fn a_turntable_goes_once_round_over_its_frames() {
        let settings = RenderSettings { frames: Some(12), ..RenderSettings::default() };
        let path = camera_path(&settings, &cube()).unwrap();
        assert!((path.camera(12).eye - path.camera(0).eye).length() < 1e-9);
        assert!((path.camera(6).eye.x - path.camera(0).eye.x).abs() < 1e-9);
        let half = RenderSettings { turn: Some(-180.0), path: Some("turntable".into()), ..settings };
        let half = camera_path(&half, &cube()).unwrap();
        assert!(half.camera(3).eye.x < -1.0 && half.camera(12).eye.z < -1.0);
    }

    #[test]
    fn views_have_names() {
        let eye = |view| {
            let settings = RenderSettings { view: Some(view), ..RenderSettings::default() };
            camera_path(&settings, &cube()).unwrap().camera(0).eye.normalize()
        };
        assert!((eye(NamedView::Left) - DVec3::X).length() < 1e-9);
        assert!((eye(NamedView::Posterior) - DVec3::NEG_Z).length() < 1e-9);
        assert!((eye(NamedView::Superior) - DVec3::Y).length() < 1e-9);
    }
}
