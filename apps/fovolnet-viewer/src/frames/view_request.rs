//! Requests for pictures of a view.

use super::display_mode::DisplayMode;
use fovolnet::core::Camera;
use fovolnet::{Freedom, OpenVolume, RenderOverrides};
use std::sync::Arc;

/// Request for pictures of a view.
#[derive(Debug, Clone)]
pub struct ViewRequest {
    /// The volume.
    pub volume: OpenVolume,
    /// Render settings that are given. The size is that of the picture on the screen; camera and gaze are ignored.
    pub settings: RenderOverrides,
    /// Settings that the planner may decide for frames in motion.
    pub freedom: Freedom,
    /// Camera that sees the view.
    pub camera: Camera,
    /// Gaze, as fractions of the picture from its top left.
    pub gaze: [f64; 2],
    /// Place in the picture whose point of the volume is asked for, as fractions from the top left.
    pub probe: Option<[f64; 2]>,
    /// Frame rate to keep in motion; `None`, or fixed quality, renders with the settings unchanged.
    pub rate: Option<f64>,
    /// Whether still views are refined to the full frame.
    pub converges: bool,
    /// Display mode.
    pub look: DisplayMode,
}

impl ViewRequest {
    /// Whether both requests have an equal full frame.
    pub fn shows_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.volume.volume, &other.volume.volume)
            && self.settings == other.settings
            && self.camera == other.camera
    }
}

impl PartialEq for ViewRequest {
    fn eq(&self, other: &Self) -> bool {
        self.shows_as(other)
            && (self.gaze, self.probe, self.rate) == (other.gaze, other.probe, other.rate)
            && (self.converges, self.look) == (other.converges, other.look)
    }
}
