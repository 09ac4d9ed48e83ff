//! Colours, opacity and depth of a primary ray.

/// The result of one primary ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayResult {
    /// Red, green and blue over the background.
    pub colour: [f32; 3],
    /// Red, green and blue that the ray would have without shadows, times opacity and without the background: the sum U
    /// of the light ratio. Where shadows are off or cached it is the colour itself before the background.
    pub unshadowed: [f32; 3],
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
        Self { colour: background, unshadowed: [0.0; 3], opacity: 0.0, depth: f32::INFINITY }
    }
}
