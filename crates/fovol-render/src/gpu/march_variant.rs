use super::scene_kind::SceneKind;
use fovol_core::{ShadowMode, SurfaceShading};
use std::fmt;

/// Which pixels a dispatch marches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pixels {
    /// A list, with results in its order.
    List,
    /// A list, with results at the places of their pixels in the frame.
    Straight,
    All,
    Masked,
}

/// Properties that the shader of a frame is specialised for, besides its strategy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Variant {
    pub pixels: Pixels,
    pub scene: SceneKind,
    pub shadows: ShadowMode,
    pub surface: SurfaceShading,
    /// Shadow rays of each pixel; 0 where every sample has one.
    pub few: u32,
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pixels, scene, shadows, surface, few } = self;
        write!(f, "{pixels:?} {shadows:?} {surface:?} {few} {scene:?}")
    }
}
