//! Handles of clip planes over the picture.

use super::marks::{Projection, line};
use super::plane_drag::DraggedPlane;
use crate::session::opened::Opened;
use eframe::egui::{
    Color32, CursorIcon, Painter, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2, WidgetInfo, accesskit::Role,
};

/// Colour of handles.
const HANDLE: Color32 = Color32::from_rgb(255, 190, 90);
/// Radius of the disc in points. It is seen around the tip where the arrow points along the view.
const DISC: f32 = 10.0;
/// Radius of the arrow's tip.
const TIP: f32 = 5.0;

/// Draws a disc and an arrow for each clip plane over the picture seen in `projection`. Dragging the disc moves the
/// plane, dragging the tip of the arrow turns it.
pub fn show(ui: &mut Ui, opened: &mut Opened, projection: &Projection, rect: Rect) {
    let Some(before) = opened.document.settings().clip_plane.clone() else { return };
    let mut planes = before.clone();
    let painter = ui.painter_at(rect);
    for (number, numbers) in planes.iter_mut().enumerate() {
        let Some(plane) = DraggedPlane::new(*numbers) else { continue };
        let ends = [plane.disc(), plane.tip()].map(|end| projection.project(end));
        let [Some(disc), Some(tip)] = ends else { continue };
        let discs = handle(ui, (disc, DISC), "Move plane", number);
        let tips = handle(ui, (tip, TIP + 2.0), "Turn plane", number);
        draw(&painter, [disc, tip], &discs, &tips);
        let delta = |response: &Response| Some(response.drag_delta()).filter(|delta| *delta != Vec2::ZERO);
        if let Some(delta) = delta(&discs) {
            *numbers = plane.moved(projection, delta).numbers();
        }
        if let Some(delta) = delta(&tips) {
            *numbers = plane.turned(projection, delta).numbers();
        }
    }
    if planes != before {
        opened.document.settings_mut().clip_plane = Some(planes);
    }
}

/// Place of a handle that can be dragged.
fn handle(ui: &Ui, (at, radius): (Pos2, f32), name: &str, number: usize) -> Response {
    let rect = Rect::from_center_size(at, Vec2::splat(2.0 * radius));
    let response = ui.interact(rect, ui.scope_id().with((name, number)), Sense::drag());
    let name = format!("{name} {}", number + 1);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    response.on_hover_and_drag_cursor(CursorIcon::Grab)
}

fn draw(painter: &Painter, [disc, tip]: [Pos2; 2], discs: &Response, tips: &Response) {
    let lit = |response: &Response| {
        let is_held = response.hovered() || response.dragged();
        if is_held { Color32::WHITE } else { HANDLE }
    };
    painter.circle(
        disc,
        DISC,
        lit(discs).gamma_multiply(0.35),
        Stroke::new(3.5, Color32::from_black_alpha(110)),
    );
    painter.circle_stroke(disc, DISC, Stroke::new(2.0, lit(discs)));
    line(painter, disc, tip, 2.0, HANDLE);
    painter.circle(tip, TIP, lit(tips), Stroke::new(1.5, Color32::from_black_alpha(160)));
}
