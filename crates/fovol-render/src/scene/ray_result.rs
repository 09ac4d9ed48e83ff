//! Colour, opacity and depth of a primary ray.

/// The result of one primary ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayResult {
    /// Red, green and blue over the background.
    pub colour: [f32; 3],
    /// Accumulated opacity, 0…1.
    pub opacity: f32,
    /// Distance from the eye at which opacity passes one half, in world units. Motion is derived from it.
    ///
    /// Where opacity stays below one half, it is the mean distance of the visible samples, weighted by their opacity.
    /// It is infinite where nothing is visible.
    pub depth: f32,
}

impl RayResult {
    /// The result of a ray through empty space.
    pub fn nothing(background: [f32; 3]) -> Self {
        Self { colour: background, opacity: 0.0, depth: f32::INFINITY }
    }
}
