use crate::{RenderSettings, Result, toml_file};
use fovol_core::{Camera, CameraPath, Fovea, FrameSize, GazePath, Keyframe};
use glam::DVec3;
use serde::Deserialize;

/// What is seen in one frame, and where the eye looks.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// The number of the frame.
    pub index: u32,
    pub size: FrameSize,
    pub camera: Camera,
    /// Where the frame before was seen from.
    pub last_camera: Option<Camera>,
    pub fovea: Fovea,
}

/// How camera and gaze move.
#[derive(Debug)]
pub struct Paths {
    camera: CameraPath,
    gaze: GazePath,
    fovea: Fovea,
}

impl Paths {
    pub fn new(settings: &RenderSettings) -> Result<Self> {
        Ok(Self {
            camera: camera_path(settings)?,
            gaze: settings.gaze_path()?,
            fovea: settings.base_fovea()?,
        })
    }

    pub fn camera(&self, i: u32) -> Camera {
        self.camera.camera(i)
    }

    pub fn fovea(&self, i: u32) -> Fovea {
        Fovea { gaze: self.gaze.gaze(i), ..self.fovea }
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
            #[derive(Deserialize)]
            struct Keyframes {
                keyframe: Vec<Keyframe>,
            }
            let read: Keyframes = toml_file::read(
                file,
                "--path",
                "orbit, flythrough, or a TOML file of [[keyframe]] tables with frame, eye, target and fovy",
            )?;
            Ok(CameraPath::through(read.keyframe)?)
        }
    }
}
