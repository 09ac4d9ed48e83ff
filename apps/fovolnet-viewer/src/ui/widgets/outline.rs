//! Outlines of plots and the timeline.

use eframe::egui::{Painter, Rect, StrokeKind, Visuals};

/// Draws the outline of `rect`. It is not filled, since filled pixels take time with software rendering.
pub fn outline(painter: &Painter, rect: Rect, visuals: &Visuals) {
    painter.rect_stroke(rect, 3.0, visuals.widgets.noninteractive.bg_stroke, StrokeKind::Inside);
}
