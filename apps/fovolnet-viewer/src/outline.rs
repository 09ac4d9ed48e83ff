//! The outline of what is drawn in a panel: plots, and the track of time.

use eframe::egui::{Painter, Rect, StrokeKind, Visuals};

/// Draws that of `rect`. It is not filled: where a processor draws the window, every pixel of it takes time.
pub fn outline(painter: &Painter, rect: Rect, visuals: &Visuals) {
    painter.rect_stroke(rect, 3.0, visuals.widgets.noninteractive.bg_stroke, StrokeKind::Inside);
}
