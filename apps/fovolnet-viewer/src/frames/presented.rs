//! Pictures for the screen.

use super::still::Quality;
use eframe::wgpu;
use fovolnet::core::{Camera, FrameSize};
use fovolnet::{FramePlan, Machine, RenderSettings, Timings};

/// Progress of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// In motion.
    Moving,
    /// This fraction of the pixels is rendered.
    Converging(f64),
    /// All pixels are rendered.
    Complete,
}

/// Pixels of a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// Opaque 8-bit RGBA, row by row.
    Host(Vec<u8>),
    /// Opaque 8-bit RGBA texture on the window's device.
    Device(wgpu::Texture),
}

/// Picture for the screen.
#[derive(Debug, Clone)]
pub struct Presented {
    /// Width and height in pixels.
    pub size: FrameSize,
    /// Pixels, on the host or on the device of the window.
    pub pixels: Pixels,
    /// Camera that sees the view.
    pub camera: Camera,
    /// Progress of the refinement.
    pub progress: Progress,
    /// Settings that it was made with.
    pub settings: RenderSettings,
    /// Fraction of pixels sampled for the frame.
    pub density: f64,
    /// Timings of the frame.
    pub timings: Timings,
    /// Quality of the reconstruction, once known.
    pub quality: Option<Quality>,
    /// How the planner made it, if it is in motion and planned.
    pub plan: Option<FramePlan>,
    /// Machine that made it.
    pub machine: Machine,
}
