//! One slice, and what the mouse does in it.

use super::orientation::Lie;
use super::placed_slice::{PlacedSlice, nearest};
use super::reading::reading;
use super::slice_marks as marks;
use super::slices_state::Slices;
use crate::session::opened::Opened;
use eframe::egui::{
    Color32, CursorIcon, Event, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Sense, Shape, Ui,
    WidgetInfo, accesskit::Role, pos2,
};

/// Room for letters around a slice, in points.
const MARGIN: f32 = 22.0;
/// Points of a touchpad for a step to the next slice.
const POINTS_A_STEP: f32 = 40.0;

/// Shows the slice of `lies[which]` in `room`. Returns the words on the voxel under the pointer.
pub fn show(
    ui: &mut Ui,
    slices: &mut Slices,
    opened: &Opened,
    (lies, which): (&[Lie; 3], usize),
    room: Rect,
) -> Option<String> {
    let volume = &opened.volume.volume;
    let lie = lies[which];
    let response = ui.interact(room, ui.scope_id().with(("slice", which)), Sense::click_and_drag());
    let name = format!("{} slice", lie.name);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    let placed = PlacedSlice::new(lie, volume.grid(), room.shrink(MARGIN));
    act(ui, &response, slices, opened, &placed);
    let number = slices.crosshair[lie.across.axis];
    slices.draw(ui.ctx(), opened, which, lie);
    let painter = ui.painter_at(room);
    painter.rect_filled(room, 0.0, Color32::BLACK);
    let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    for texture in slices.textures(which) {
        painter.add(Shape::image(texture.id(), placed.rect, whole, Color32::WHITE));
    }
    marks::crosshair(&painter, &placed, lies, slices.crosshair);
    marks::rulers(&painter, &placed, number, volume, slices.rulers.iter());
    marks::title(&painter, &lie, number, room);
    marks::edges(&painter, &lie, room);
    marks::scale(&painter, &placed, volume, room);
    let at = response.hover_pos()?;
    if slices.measures {
        ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
    }
    reading(&opened.volume, placed.voxel(at, number))
}

/// Does what the mouse asks for.
fn act(ui: &Ui, response: &Response, slices: &mut Slices, opened: &Opened, placed: &PlacedSlice) {
    let dims = opened.volume.volume.grid().dims();
    let axis = placed.lie.across.axis;
    let number = slices.crosshair[axis];
    // A quick click presses and releases within a frame.
    let is_pressed = response.is_pointer_button_down_on() && ui.input(|input| input.pointer.primary_down());
    if slices.measures {
        measure(ui, response, slices, placed, number);
    } else if (is_pressed || response.clicked())
        && let Some(at) = response.interact_pointer_pos()
    {
        slices.crosshair = nearest(placed.voxel(at, number), dims);
    }
    if response.dragged_by(PointerButton::Secondary) {
        let delta = response.drag_delta();
        slices.drag_window(opened, delta.x.into(), delta.y.into());
    }
    if response.double_clicked() && !slices.measures {
        slices.window = None;
    }
    if response.hovered() {
        slices.wheel += wheel(ui);
        let steps = slices.wheel.trunc();
        slices.wheel -= steps;
        let forward = if placed.lie.across.rises { steps } else { -steps };
        slices.crosshair[axis] =
            (number as f64 + f64::from(forward)).clamp(0.0, (dims[axis] - 1) as f64) as usize;
    }
}

/// Draws a ruler.
fn measure(ui: &Ui, response: &Response, slices: &mut Slices, placed: &PlacedSlice, number: usize) {
    let plane = Some(placed.lie.plane);
    if response.drag_started_by(PointerButton::Primary)
        && let Some(at) = ui.input(|input| input.pointer.press_origin())
    {
        slices.rulers.begin(placed.voxel(at, number), plane);
    }
    if slices.rulers.draws_in(plane) {
        if let Some(at) = response.interact_pointer_pos() {
            slices.rulers.draw_to(placed.voxel(at, number), plane);
        }
        if !ui.input(|input| input.pointer.primary_down()) {
            slices.rulers.end();
        }
    }
}

/// Steps of the wheel since the last frame; fractions come from touchpads.
fn wheel(ui: &Ui) -> f32 {
    let steps = |event: &Event| match event {
        Event::MouseWheel { unit: MouseWheelUnit::Point, delta, .. } => delta.y / POINTS_A_STEP,
        Event::MouseWheel { delta, .. } => delta.y,
        _ => 0.0,
    };
    ui.input(|input| input.events.iter().map(steps).sum())
}
