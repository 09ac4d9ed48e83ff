//! Editor for the opacity by gradient of the transfer function.

use crate::ui::widgets::curve_points::{CurvePoint, edit_points};
use crate::ui::widgets::outline::outline;
use eframe::egui::{DragValue, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use fovolnet::core::GradientOpacity;

/// State of the editor.
#[derive(Debug, Clone, Default)]
pub struct GradientEditor {
    selected: Option<usize>,
    /// Curve before it was switched off.
    last: Option<GradientOpacity>,
}

const HEIGHT: f32 = 70.0;
/// Longest gradient of the plot, in display values per voxel.
const LONGEST: f64 = 0.5;
/// Exponent of displayed gradients; most interesting gradients are small.
const ROOT: f64 = 0.5;
/// Curve of a new editor: homogeneous regions vanish.
const USUAL: [[f64; 2]; 2] = [[0.01, 0.0], [0.05, 1.0]];

impl GradientEditor {
    /// Shows `gradient`, for the displayed range `lo` to `hi`; returns what it became if it changed.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        gradient: Option<&GradientOpacity>,
        [lo, hi]: [f64; 2],
    ) -> Option<Option<GradientOpacity>> {
        let mut is_on = gradient.is_some();
        let switch = ui.checkbox(&mut is_on, "Opacity by gradient").on_hover_text(
            "Scales the opacity by the length of the gradient: homogeneous regions vanish, borders stay.",
        );
        if switch.changed() {
            self.selected = None;
            if !is_on {
                self.last = gradient.cloned();
                return Some(None);
            }
            let usual = || GradientOpacity::new(USUAL.to_vec()).ok();
            return Some(self.last.take().or_else(usual));
        }
        let gradient = gradient?;
        let mut points = gradient.points().to_vec();
        self.selected = self.selected.filter(|&i| i < points.len());
        let (rect, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
        let response = response.on_hover_text(
            "Factor of the opacity over the gradient. Drag points. Double click adds one, the right button or Delete \
             takes it away.",
        );
        let plot = rect.shrink(6.0);
        self.paint(ui, rect, gradient);
        let mut is_changed = edit_points(ui, (&response, plot), &mut self.selected, &mut points);
        is_changed |= self.selected_ui(ui, &mut points, if hi > lo { hi - lo } else { 1.0 });
        let changed = is_changed.then(|| GradientOpacity::new(points).ok()).flatten();
        changed.filter(|changed| changed != gradient).map(Some)
    }

    fn paint(&self, ui: &Ui, rect: Rect, gradient: &GradientOpacity) {
        let (painter, plot) = (ui.painter_at(rect), rect.shrink(6.0));
        outline(&painter, rect, ui.visuals());
        let steps = plot.width().max(1.0) as usize;
        let at = |i: usize| {
            let [length, _] = point_at(plot, pos2(plot.left() + i as f32, 0.0));
            position(plot, [length, gradient.evaluate(length)])
        };
        painter.line((0..=steps).map(at).collect(), Stroke::new(1.5, ui.visuals().strong_text_color()));
        for (i, point) in gradient.points().iter().enumerate() {
            let is_selected = self.selected == Some(i);
            let (at, radius) = (position(plot, *point), if is_selected { 6.0 } else { 4.5 });
            let edge = if is_selected { ui.visuals().selection.bg_fill } else { ui.visuals().text_color() };
            painter.circle_filled(at, radius, ui.visuals().extreme_bg_color);
            painter.circle_stroke(at, radius, Stroke::new(1.5, edge));
        }
    }

    /// Shows the numbers of the selected point; gradients in values of the file per voxel, of which `span` are shown.
    fn selected_ui(&self, ui: &mut Ui, points: &mut [[f64; 2]], span: f64) -> bool {
        let Some(i) = self.selected.filter(|&i| i < points.len()) else { return false };
        let [mut length, mut factor] = [points[i][0] * span, points[i][1]];
        let mut is_changed = false;
        ui.horizontal(|ui| {
            let label = ui.label("Gradient").id;
            let number = DragValue::new(&mut length).speed(span / 2000.0).range(0.0..=f64::MAX);
            is_changed |= ui.add(number).labelled_by(label).changed();
            let label = ui.label("Factor").id;
            let number = DragValue::new(&mut factor).speed(0.005).range(0.0..=1.0).max_decimals(3);
            is_changed |= ui.add(number).labelled_by(label).changed();
        });
        is_changed && place(points, i, [length / span, factor])
    }
}

/// A gradient and its factor.
impl CurvePoint for [f64; 2] {
    fn position(&self, plot: Rect) -> Pos2 {
        position(plot, *self)
    }

    fn add(points: &mut Vec<Self>, plot: Rect, at: Pos2) -> usize {
        let point = point_at(plot, at);
        let i = points.partition_point(|other| other[0] <= point[0]);
        points.insert(i, point);
        i
    }

    fn drag(points: &mut [Self], i: usize, plot: Rect, at: Pos2) -> bool {
        place(points, i, point_at(plot, at))
    }
}

/// Moves point `i` between its neighbours; returns whether it moved.
fn place(points: &mut [[f64; 2]], i: usize, [length, factor]: [f64; 2]) -> bool {
    let lo = if i > 0 { points[i - 1][0] } else { 0.0 };
    let hi = points.get(i + 1).map_or(f64::MAX, |next| next[0]);
    let moved = [length.clamp(lo, hi), factor.clamp(0.0, 1.0)];
    std::mem::replace(&mut points[i], moved) != moved
}

/// Place of a point in the plot; those beyond its longest gradient are at the edge.
fn position(plot: Rect, [length, factor]: [f64; 2]) -> Pos2 {
    let along = (length / LONGEST).min(1.0).powf(ROOT) as f32;
    pos2(plot.left() + along * plot.width(), plot.bottom() - factor as f32 * plot.height())
}

/// Gradient and factor at a place in the plot.
fn point_at(plot: Rect, at: Pos2) -> [f64; 2] {
    let along = f64::from((at.x - plot.left()) / plot.width()).clamp(0.0, 1.0);
    let factor = f64::from((plot.bottom() - at.y) / plot.height()).clamp(0.0, 1.0);
    [along.powf(1.0 / ROOT) * LONGEST, factor]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_read_as_they_are_drawn() {
        let plot = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 60.0));
        for point in [[0.0, 0.0], [0.02, 0.4], [0.5, 1.0]] {
            let [length, factor] = point_at(plot, position(plot, point));
            assert!((length - point[0]).abs() < 1e-6 && (factor - point[1]).abs() < 1e-6);
        }
        assert_eq!(position(plot, [3.0, 1.0]), plot.right_top());
    }

    #[test]
    fn points_stay_between_their_neighbours() {
        let mut points = vec![[0.0, 0.0], [0.1, 0.5], [0.3, 1.0]];
        assert!(place(&mut points, 1, [0.9, 2.0]));
        assert_eq!(points[1], [0.3, 1.0]);
        assert!(!place(&mut points, 1, [0.4, 1.0]));
        assert!(place(&mut points, 2, [7.0, 1.0]));
        GradientOpacity::new(points).unwrap();
    }
}
