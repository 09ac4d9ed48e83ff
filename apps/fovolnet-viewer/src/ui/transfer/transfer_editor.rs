//! Editor for control points of the transfer function.

use crate::ui::transfer::backdrop::Backdrop;
use crate::ui::transfer::gradient_editor::GradientEditor;
use crate::ui::widgets::colour_button::colour_button;
use crate::ui::widgets::curve_points::{CurvePoint, edit_points};
use crate::ui::widgets::outline::outline;
use eframe::egui::{
    Color32, ComboBox, DragValue, Mesh, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2,
};
use fovolnet::core::{ControlPoint, TransferFunction};
use fovolnet::{OpenVolume, TransferChoice, presets};

/// State of the transfer-function editor.
#[derive(Debug, Clone, Default)]
pub struct TransferEditor {
    selected: Option<usize>,
    gradient: GradientEditor,
}

const HEIGHT: f32 = 150.0;
/// Exponent of displayed opacities; most interesting opacities are small.
const ROOT: f64 = 0.5;

impl TransferEditor {
    /// Shows `transfer`; returns the edited function if it changed.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        transfer: &TransferFunction,
        backdrop: &Backdrop,
    ) -> Option<TransferFunction> {
        let mut points = transfer.points().to_vec();
        self.selected = self.selected.filter(|&i| i < points.len());
        let (rect, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
        let response = response
            .on_hover_text("Drag points. Double click adds one, the right button or Delete takes it away.");
        let plot = plot_of(rect);
        self.paint(ui, rect, transfer, backdrop);
        let mut is_changed = edit_points(ui, (&response, plot), &mut self.selected, &mut points);
        is_changed |= self.selected_ui(ui, &mut points, backdrop.histogram().range());
        is_changed |= window_level(ui, &mut points);
        let mut changed = is_changed.then(|| transfer.clone().with_points(points).ok()).flatten();
        let range = backdrop.histogram().range();
        if let Some(gradient) = self.gradient.ui(ui, transfer.gradient(), range) {
            changed = Some(changed.unwrap_or_else(|| transfer.clone()).with_gradient(gradient));
        }
        changed.filter(|changed| changed != transfer)
    }

    fn paint(&self, ui: &Ui, rect: Rect, transfer: &TransferFunction, backdrop: &Backdrop) {
        let (painter, plot) = (ui.painter_at(rect), plot_of(rect));
        outline(&painter, rect, ui.visuals());
        backdrop.paint(&painter, plot, ui.visuals());
        filled(&painter, plot, transfer, backdrop.cover());
        let line: Vec<Pos2> = curve(plot, transfer);
        painter.line(line, Stroke::new(1.5, ui.visuals().strong_text_color()));
        for (i, point) in transfer.points().iter().enumerate() {
            let at = position(plot, point);
            let is_selected = self.selected == Some(i);
            painter.circle_filled(at, if is_selected { 6.5 } else { 5.0 }, colour(point.colour));
            let edge = if is_selected { ui.visuals().selection.bg_fill } else { ui.visuals().text_color() };
            painter.circle_stroke(at, if is_selected { 6.5 } else { 5.0 }, Stroke::new(1.5, edge));
        }
    }

    /// Shows the values of the selected point, for the displayed range `lo` to `hi`.
    fn selected_ui(&mut self, ui: &mut Ui, points: &mut [ControlPoint], [lo, hi]: [f64; 2]) -> bool {
        let Some(i) = self.selected.filter(|&i| i < points.len()) else {
            ui.weak("Select a point to see its numbers.");
            return false;
        };
        let span = if hi > lo { hi - lo } else { 1.0 };
        let mut point = points[i];
        let mut value = lo + point.value * span;
        let mut is_changed = false;
        ui.horizontal(|ui| {
            let label = ui.label("Value").id;
            let number = DragValue::new(&mut value).speed(span / 300.0).range(lo..=hi);
            if ui.add(number).labelled_by(label).changed() {
                point.value = ((value - lo) / span).clamp(0.0, 1.0);
                is_changed = true;
            }
            let label = ui.label("Opacity").id;
            let opacity = DragValue::new(&mut point.opacity).speed(0.002).range(0.0..=1.0).max_decimals(4);
            is_changed |= ui.add(opacity).labelled_by(label).changed();
            is_changed |= colour_button(ui, &mut point.colour);
        });
        if is_changed {
            points[i] = ControlPoint { colour: point.colour, ..points[i] };
            place(points, i, [point.value, point.opacity]);
        }
        is_changed
    }
}

/// Shows window and level, which scale and shift all points.
fn window_level(ui: &mut Ui, points: &mut [ControlPoint]) -> bool {
    let (first, last) = (points[0].value, points[points.len() - 1].value);
    let (mut window, mut level) = (last - first, 0.5 * (first + last));
    let mut is_changed = false;
    ui.horizontal(|ui| {
        let mut number = |name: &str, value: &mut f64, least: f64| {
            let label = ui.label(name).id;
            let number = DragValue::new(value).speed(0.002).range(least..=1.0).max_decimals(3);
            is_changed |= ui.add(number).labelled_by(label).changed();
        };
        number("Window", &mut window, 0.001);
        number("Level", &mut level, 0.0);
    });
    if is_changed {
        let old = (last - first).max(1e-9);
        for point in points.iter_mut() {
            let part = if last > first { (point.value - first) / old } else { 0.5 };
            point.value = (level + (part - 0.5) * window).clamp(0.0, 1.0);
        }
    }
    is_changed
}

/// Moves point `i` to (value, opacity), between its neighbours; returns whether it moved.
fn place(points: &mut [ControlPoint], i: usize, [value, opacity]: [f64; 2]) -> bool {
    let lo = if i > 0 { points[i - 1].value } else { 0.0 };
    let hi = points.get(i + 1).map_or(1.0, |next| next.value);
    let moved = ControlPoint { value: value.clamp(lo, hi), opacity: opacity.clamp(0.0, 1.0), ..points[i] };
    std::mem::replace(&mut points[i], moved) != moved
}

impl CurvePoint for ControlPoint {
    fn position(&self, plot: Rect) -> Pos2 {
        position(plot, self)
    }

    /// The point has the function's colour there.
    fn add(points: &mut Vec<Self>, plot: Rect, at: Pos2) -> usize {
        let [value, opacity] = value_at(plot, at);
        let colour = TransferFunction::new(points.clone()).map_or([1.0; 3], |transfer| {
            let [r, g, b, _] = transfer.evaluate(value);
            [r, g, b]
        });
        let i = points.partition_point(|point| point.value <= value);
        points.insert(i, Self::new(value, colour, opacity));
        i
    }

    fn drag(points: &mut [Self], i: usize, plot: Rect, at: Pos2) -> bool {
        place(points, i, value_at(plot, at))
    }
}

/// Plot area in `rect`, with a margin for points at its edges.
fn plot_of(rect: Rect) -> Rect {
    rect.shrink(6.0)
}

fn position(plot: Rect, point: &ControlPoint) -> Pos2 {
    let height = point.opacity.powf(ROOT) as f32;
    pos2(plot.left() + point.value as f32 * plot.width(), plot.bottom() - height * plot.height())
}

/// Value and opacity at a position in the plot.
fn value_at(plot: Rect, at: Pos2) -> [f64; 2] {
    let value = f64::from((at.x - plot.left()) / plot.width()).clamp(0.0, 1.0);
    let height = f64::from((plot.bottom() - at.y) / plot.height()).clamp(0.0, 1.0);
    [value, height.powf(1.0 / ROOT)]
}

fn colour([r, g, b]: [f64; 3]) -> Color32 {
    let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
    Color32::from_rgb(byte(r), byte(g), byte(b))
}

/// Polyline of the opacity curve, one vertex per point of width.
fn curve(plot: Rect, transfer: &TransferFunction) -> Vec<Pos2> {
    let steps = plot.width().max(1.0) as usize;
    let at = |i: usize| {
        let value = i as f64 / steps as f64;
        let [.., opacity] = transfer.evaluate(value);
        position(plot, &ControlPoint::new(value, [0.0; 3], opacity))
    };
    (0..=steps).map(at).collect()
}

/// Fills the area under the curve with the function's colours at the opacity `cover`.
fn filled(painter: &Painter, plot: Rect, transfer: &TransferFunction, cover: f32) {
    let mut mesh = Mesh::default();
    for pair in curve(plot, transfer).windows(2) {
        let value = f64::from((pair[0].x - plot.left()) / plot.width());
        let [r, g, b, _] = transfer.evaluate(value);
        let fill = colour([r, g, b]).gamma_multiply(cover);
        let top = 0.5 * (pair[0].y + pair[1].y);
        mesh.add_colored_rect(Rect::from_min_max(pos2(pair[0].x, top), pos2(pair[1].x, plot.bottom())), fill);
    }
    painter.add(Shape::mesh(mesh));
}

/// Shows a list of presets and colour maps with their colours; returns a chosen one.
pub fn presets_ui(ui: &mut Ui, current: &TransferChoice, volume: &OpenVolume) -> Option<TransferChoice> {
    let mut chosen = None;
    let text = current.text();
    let is_edited = matches!(current, TransferChoice::Json(_) | TransferChoice::Function(_));
    let shown = if is_edited { "edited" } else { &*text };
    let label = ui.label("Preset").id;
    let list = ComboBox::from_id_salt("presets").selected_text(shown).width(130.0).show_ui(ui, |ui| {
        for name in presets::names() {
            ui.horizontal(|ui| {
                if let Ok(transfer) = presets::find(name, volume) {
                    let (rect, _) = ui.allocate_exact_size(vec2(60.0, 12.0), Sense::hover());
                    strip(ui.painter(), rect, &transfer);
                }
                if ui.selectable_label(name == text, name).clicked() {
                    chosen = Some(name.into());
                }
            });
        }
    });
    list.response.labelled_by(label);
    chosen
}

/// Draws the colours of `transfer` from left to right.
fn strip(painter: &Painter, rect: Rect, transfer: &TransferFunction) {
    let steps = 30;
    let mut mesh = Mesh::default();
    for i in 0..steps {
        let [left, right] = [i, i + 1].map(|i| rect.left() + i as f32 / steps as f32 * rect.width());
        let [r, g, b, _] = transfer.evaluate((f64::from(i) + 0.5) / f64::from(steps));
        let piece = Rect::from_min_max(pos2(left, rect.top()), pos2(right, rect.bottom()));
        mesh.add_colored_rect(piece, colour([r, g, b]));
    }
    painter.add(Shape::mesh(mesh));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<ControlPoint> {
        [0.0, 0.4, 1.0].map(|value| ControlPoint::new(value, [1.0, 0.5, 0.0], value * 0.5)).to_vec()
    }

    #[test]
    fn places_read_as_they_are_drawn() {
        let plot = Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 100.0));
        for point in points() {
            let [value, opacity] = value_at(plot, position(plot, &point));
            assert!((value - point.value).abs() < 1e-6 && (opacity - point.opacity).abs() < 1e-6);
        }
    }

    #[test]
    fn points_stay_between_their_neighbours() {
        let mut points = points();
        assert!(place(&mut points, 1, [2.0, 3.0]));
        assert_eq!((points[1].value, points[1].opacity), (1.0, 1.0));
        assert!(!place(&mut points, 1, [1.5, 1.0]));
        assert!(place(&mut points, 0, [0.2, 0.0]));
        TransferFunction::new(points).unwrap();
    }

    #[test]
    fn added_points_have_the_colour_that_is_there() {
        let plot = Rect::from_min_size(Pos2::ZERO, vec2(100.0, 100.0));
        let mut points = points();
        let i = ControlPoint::add(&mut points, plot, pos2(70.0, 50.0));
        assert_eq!(i, 2);
        assert_eq!(points[2].colour, [1.0, 0.5, 0.0]);
        assert!((points[2].opacity - 0.25).abs() < 1e-6);
    }
}
