//! Reconstruction of the light ratio instead of colours.
//!
//! Shadow rays are the cost of a frame. Colours, opacities and outlines without shadows are cheap, so they are marched
//! densely: this is the guide. Only the ratio of the shadowed colour to the guide is sampled sparsely, filled, and
//! multiplied with the guide again.

mod between;
mod grid;
mod importance;
mod joint_bilateral;
mod light_ratio;
mod marched;
mod upsampled;

pub use grid::GuideGrid;
pub use importance::{importance_of_colours, importance_of_ratios};
pub use joint_bilateral::joint_bilateral;
pub use light_ratio::{compose, light_ratios};
pub use marched::MarchedGuide;
#[cfg(feature = "gpu")]
pub(crate) use marched::{BUDGETS, CONTRASTS, headroom};
pub use upsampled::UpsampledGuide;

use fovol_render::scene::RayResult;

/// ε: added to both sides of the light ratio, so that dark pixels have a stable one.
pub const EPSILON: f32 = 0.02;

/// Red, green and blue without shadows (U), times opacity and before the background, and opacity (O).
pub type GuidePixel = [f32; 4];

/// Clamps overshoots of cubics: opacity lies in 0…1, and no channel above opacity.
#[inline(always)]
fn possible([r, g, b, opacity]: GuidePixel) -> GuidePixel {
    let opacity = opacity.clamp(0.0, 1.0);
    [r.clamp(0.0, opacity), g.clamp(0.0, opacity), b.clamp(0.0, opacity), opacity]
}

/// Guide pixel of a ray result.
pub fn guide_pixel(ray: &RayResult) -> GuidePixel {
    let [r, g, b] = ray.unshadowed;
    [r, g, b, ray.opacity]
}
