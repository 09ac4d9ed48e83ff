use crate::{RenderSettings, Result, WorldBox, camera_path};
use fovol_core::{Camera, CameraPath, Fovea, FrameSize, GazePath};

/// Camera and fovea of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// Camera, in world space.
    pub camera: Camera,
    /// Gaze and sampling density.
    pub fovea: Fovea,
}

/// Number, size, camera and fovea of one frame to render.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Frame number.
    pub index: u32,
    pub size: FrameSize,
    pub camera: Camera,
    pub fovea: Fovea,
}

/// Camera and gaze of every frame.
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
