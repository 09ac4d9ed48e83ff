//! View of the picture with mouse and keyboard navigation.

use crate::session::opened::Opened;
use crate::ui::picture::marks::{self, AxisNames, Projection};
use crate::ui::picture::{navigation, plane_handles};
use crate::ui::slices::{ruler::Rulers, slice_marks};
use eframe::egui::{Color32, Key, PointerButton, Rect, Response, Sense, Shape, Ui, Vec2, vec2};
use fovolnet::RenderSettings;
use fovolnet::core::Camera;
use glam::DVec3;

/// Degrees of rotation per point of a drag.
const TURN: f64 = 0.35;
/// Flight speed in distances of the target per second.
const FLIGHT: f64 = 0.6;

/// Result of showing the picture.
#[derive(Debug)]
pub struct Handled {
    /// Rectangle of the picture.
    pub rect: Rect,
    /// Position of the pointer over the picture, as fractions from its top left.
    pub pointer: Option<[f64; 2]>,
    /// Whether the left button is held down that was pressed over the picture.
    pub is_pressed: bool,
    /// Whether the user asked to reset the view.
    pub resets: bool,
}

/// Fills the rest of `ui` with the `picture`, if there is one, and handles navigation. Where the left button `measures`, it
/// does not turn the view.
pub fn show(
    ui: &mut Ui,
    opened: &mut Opened,
    measures: bool,
    picture: impl FnOnce(Rect) -> Option<Shape>,
) -> Handled {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    ui.painter().add(picture(rect).unwrap_or_else(|| Shape::rect_filled(rect, 0.0, Color32::BLACK)));
    turn(ui, &response, opened, (rect, measures));
    fly(ui, opened);
    let pointer = response.hover_pos().map(|at| {
        let part = (at - rect.min) / rect.size();
        [f64::from(part.x), f64::from(part.y)]
    });
    let is_pressed = response.is_pointer_button_down_on() && ui.input(|input| input.pointer.primary_down());
    Handled { rect, pointer, is_pressed, resets: response.double_clicked() && !measures }
}

/// Handles rotation, panning and zoom.
fn turn(ui: &Ui, response: &Response, opened: &mut Opened, (rect, measures): (Rect, bool)) {
    let camera = opened.camera();
    let (shift, turns_light) = ui.input(|input| (input.modifiers.shift, input.key_down(Key::L)));
    let delta = response.drag_delta();
    if delta != Vec2::ZERO {
        let moves = shift
            || response.dragged_by(PointerButton::Middle)
            || response.dragged_by(PointerButton::Secondary);
        if turns_light {
            turn_light(opened, &camera, delta);
        } else if moves {
            let part = delta / rect.height();
            opened.stand_at(&navigation::pan(&camera, part.x.into(), part.y.into()));
        } else if !measures {
            let [right, up] = [-f64::from(delta.x) * TURN, f64::from(delta.y) * TURN];
            opened.stand_at(&navigation::orbit(&camera, right, up));
        }
    }
    if response.hovered() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (-f64::from(scroll) * 0.003).exp() / f64::from(pinch);
        if (factor - 1.0).abs() > 1e-6 {
            opened.stand_at(&navigation::zoom(&opened.camera(), factor));
        }
    }
}

/// Rotates the session's light by a drag.
fn turn_light(opened: &mut Opened, camera: &Camera, delta: Vec2) {
    let light = opened.document.settings().light.unwrap_or(RenderSettings::default().light.into());
    let turned = marks::turned_light(DVec3::from_array(light), camera, delta);
    opened.document.settings_mut().light = Some(turned.to_array());
}

/// Moves the camera while keys are pressed.
fn fly(ui: &Ui, opened: &mut Opened) {
    let is_asked = ui.ctx().memory(|memory| memory.top_modal_layer().is_some());
    if is_asked || ui.ctx().egui_wants_keyboard_input() {
        return;
    }
    let (way, seconds) = ui.input(|input| {
        if input.modifiers.command || input.modifiers.alt {
            return (DVec3::ZERO, 0.0);
        }
        let along = |forth: Key, back: Key| {
            f64::from(u8::from(input.key_down(forth))) - f64::from(u8::from(input.key_down(back)))
        };
        let way = DVec3::new(along(Key::D, Key::A), along(Key::E, Key::Q), along(Key::W, Key::S));
        let faster = if input.modifiers.shift { 3.0 } else { 1.0 };
        (way * faster, f64::from(input.stable_dt.min(0.1)))
    });
    if way != DVec3::ZERO {
        let camera = opened.camera();
        let speed = FLIGHT * (camera.eye - camera.target).length().clamp(0.2, 3.0);
        opened.stand_at(&navigation::fly(&camera, way * speed * seconds));
        ui.ctx().request_repaint();
    }
}

/// Draws `rulers` over the picture of `camera` in `rect`, also those of slices.
pub fn rulers(ui: &Ui, opened: &Opened, camera: &Camera, rulers: &Rulers, rect: Rect) {
    let volume = &opened.volume.volume;
    let (painter, projection) = (ui.painter_at(rect), Projection::new(*camera, rect));
    for ruler in rulers.iter() {
        let world = |voxel: DVec3| opened.world().to_world(volume.grid().grid_to_world(voxel + 0.5));
        if let [Some(from), Some(to)] = ruler.ends.map(|end| projection.project(world(end))) {
            slice_marks::ruler(&painter, [from, to], ruler.length(volume), volume);
        }
    }
}

/// Draws box, axes, scales and gaze over the picture of `camera` in `rect`. A click on an axis turns the view.
pub fn marks(ui: &mut Ui, opened: &mut Opened, camera: &Camera, gaze: Option<[f64; 2]>, rect: Rect) {
    let painter = ui.painter_at(rect);
    let volume = std::sync::Arc::clone(&opened.volume.volume);
    let (grid, world) = (volume.grid(), *opened.world());
    let projection = Projection::new(*camera, rect);
    let faint = Color32::from_white_alpha(70);
    marks::bounding_box(&painter, &projection, world.whole_corners(), faint);
    if opened.document.settings().clip.is_some() {
        marks::bounding_box(&painter, &projection, world.shown_corners(), Color32::from_rgb(255, 190, 90));
    }
    plane_handles::show(ui, opened, &projection, rect);
    marks::scale_bar(&painter, camera, grid, volume.units(), rect);
    marks::colour_bar(&painter, opened.transfer(), opened.backdrop.histogram().range(), rect);
    if let Some(gaze) = gaze {
        let sigma = opened.document.settings().sigma.unwrap_or(RenderSettings::default().sigma);
        marks::gaze(&painter, gaze, sigma, rect);
    }
    let corner = rect.right_top() + vec2(-marks::AXES - 12.0, 12.0);
    let axes = Rect::from_min_size(corner, Vec2::splat(marks::AXES));
    let names = if world.is_patient() { AxisNames::PATIENT } else { AxisNames::GRID };
    for (end, _, direction) in marks::axes(&painter, camera, axes, names) {
        let id = ui.unique_id().with(("axis", direction));
        let response = ui.interact(Rect::from_center_size(end, Vec2::splat(14.0)), id, Sense::click());
        if response.clicked() {
            let towards = DVec3::from_array(direction.map(f64::from));
            let camera = opened.camera();
            opened.stand_at(&navigation::look_from(&camera, towards));
        }
    }
}
