//! Camera motion of exported clips.

use fovolnet::{PathChoice, RenderOverrides, StillCamera};

/// Camera motion of a clip.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraMotion {
    /// Along a path.
    Path(PathChoice),
    /// Still camera.
    Still(StillCamera),
}

impl CameraMotion {
    /// Stores the motion in the settings `render`.
    pub fn apply(&self, render: &mut RenderOverrides) {
        (render.path, render.camera) = match self {
            Self::Path(path) => (Some(path.clone()), None),
            Self::Still(camera) => (None, Some(*camera)),
        };
    }
}
