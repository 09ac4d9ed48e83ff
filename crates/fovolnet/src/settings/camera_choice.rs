use fovol_core::{Camera, CameraPath};

/// Camera of every frame, in world space.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum CameraChoice {
    /// The default view for one frame, [`Self::Turntable`] for more. The default view fits the bounding sphere of what
    /// is shown into the frame.
    #[default]
    Auto,
    /// Turns once round the volume over all frames, from the default view on.
    Turntable,
    /// One camera for every frame.
    Still(Camera),
    /// Along a path.
    Along(CameraPath),
}

impl From<Camera> for CameraChoice {
    fn from(camera: Camera) -> Self {
        Self::Still(camera)
    }
}

impl From<CameraPath> for CameraChoice {
    fn from(path: CameraPath) -> Self {
        Self::Along(path)
    }
}
