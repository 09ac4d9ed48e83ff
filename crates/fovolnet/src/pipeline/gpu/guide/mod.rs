//! Light ratio on the device: its guide, its division and multiplication, and where the next frame needs samples.

mod importance;
mod level;
mod light_ratio;
mod marching;
mod shader;

pub use importance::ImportancePass;
pub use light_ratio::LightRatio;
pub use marching::GuideMarch;
