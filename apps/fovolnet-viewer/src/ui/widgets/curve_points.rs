//! Points of a curve in a plot, which are dragged, added and taken away.

use eframe::egui::{Key, Pos2, Rect, Response, Ui};

/// Distance at which the pointer catches a point, in points.
const NEAR: f32 = 10.0;

/// Point of a curve. Points of a curve are in order from left to right.
pub trait CurvePoint: Sized {
    /// Place of the point in `plot`.
    fn position(&self, plot: Rect) -> Pos2;

    /// Adds a point at the place `at` in `plot`; returns its index.
    fn add(points: &mut Vec<Self>, plot: Rect, at: Pos2) -> usize;

    /// Moves point `i` to the place `at` in `plot`, between its neighbours; returns whether it moved.
    fn drag(points: &mut [Self], i: usize, plot: Rect, at: Pos2) -> bool;
}

/// Handles pointer and keyboard in `plot`: drags the `selected` of `points`, adds one and takes one away. Returns whether
/// anything changed.
pub fn edit_points<P: CurvePoint>(
    ui: &Ui,
    (response, plot): (&Response, Rect),
    selected: &mut Option<usize>,
    points: &mut Vec<P>,
) -> bool {
    let pressed = response.drag_started() || response.clicked() || response.secondary_clicked();
    if let Some(at) = ui.input(|input| input.pointer.press_origin()).or(response.interact_pointer_pos())
        && pressed
    {
        *selected = near(points, plot, at);
    }
    let mut is_changed = false;
    if let Some(at) = response.interact_pointer_pos() {
        if response.double_clicked() && near(points, plot, at).is_none() {
            *selected = Some(P::add(points, plot, at));
            is_changed = true;
        } else if let Some(i) = *selected
            && response.dragged()
        {
            is_changed |= P::drag(points, i, plot, at);
        }
    }
    let deletes = response.secondary_clicked()
        || (response.hovered() && ui.input(|input| input.key_pressed(Key::Delete)));
    if let Some(i) = *selected
        && deletes
        && points.len() > 1
    {
        points.remove(i);
        (*selected, is_changed) = (None, true);
    }
    is_changed
}

/// The point that the pointer catches at `at`.
fn near<P: CurvePoint>(points: &[P], plot: Rect, at: Pos2) -> Option<usize> {
    let distance = |i: &usize| points[*i].position(plot).distance(at);
    let nearest = (0..points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.filter(|i| distance(i) < NEAR)
}
