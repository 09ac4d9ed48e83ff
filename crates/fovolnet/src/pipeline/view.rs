use super::camera_path::camera_path;
use crate::{RenderSettings, Result, WorldBox};
use fovol_core::{Camera, CameraPath, Fovea, FrameSize, GazePath, Projection};

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

/// Camera and fovea of every frame.
#[derive(Debug)]
pub struct Paths {
    camera: CameraPath,
    projection: Projection,
    gaze: GazePath,
    /// Fovea without its gaze.
    fovea: Fovea,
}

impl Paths {
    pub fn new(settings: &RenderSettings, world: &WorldBox) -> Result<Self> {
        let camera = camera_path(settings, world)?;
        Ok(Self {
            camera,
            projection: settings.projection,
            gaze: settings.gaze.clone(),
            fovea: settings.fovea(0)?,
        })
    }

    pub fn camera(&self, i: u32) -> Camera {
        Camera { projection: self.projection, ..self.camera.camera(i) }
    }

    pub fn fovea(&self, i: u32) -> Fovea {
        Fovea { gaze: self.gaze.gaze(i), ..self.fovea }
    }
}
