use crate::{RenderSettings, Result, WorldBox, camera_path};
use fovol_core::{Camera, CameraPath, Fovea, FrameSize, GazePath};

/// From where a frame is seen, and where in it the eye looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// From where the volume is seen.
    pub camera: Camera,
    /// Where the eye looks, and what is sampled away from there.
    pub fovea: Fovea,
}

/// What is seen in one frame, and where the eye looks.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// The number of the frame.
    pub index: u32,
    pub size: FrameSize,
    pub camera: Camera,
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
    pub fn new(settings: &RenderSettings, world: &WorldBox) -> Result<Self> {
        Ok(Self {
            camera: camera_path(settings, world)?,
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
