//! Shaders of guides, from the folder `src/shaders`.

use fovol_gpu::{Shader, shader};

/// Shader that chooses the pixels of a level and interpolates the others.
pub const GUIDE: Shader = shader!("../../../shaders/", "guide": "guide_level");
/// Shader that puts marched pixels into a level.
pub const PUT: Shader = shader!("../../../shaders/", "guide_put": "guide_level");
