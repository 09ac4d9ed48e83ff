use crate::ui::picture::plane_drag::FARTHEST;
use eframe::egui::{Slider, Ui};
use fovolnet::RenderOverrides;
use fovolnet::core::{Camera, ClipPlanes};

/// Panel for planes that cut the volume. New ones face `camera`.
pub fn planes(ui: &mut Ui, settings: &mut RenderOverrides, camera: &Camera) {
    // The side away from the eye is kept, so that the cut face is seen.
    let facing = |distance: f64| {
        let (forward, ..) = camera.axes();
        [forward.x, forward.y, forward.z, distance]
    };
    let mut planes = settings.clip_plane.clone().unwrap_or_default();
    let mut removed = None;
    for (number, plane) in planes.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let label = ui.label(format!("Plane {}", number + 1)).id;
            let length = plane[..3].iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
            let mut distance = plane[3] / length;
            let slider = Slider::new(&mut distance, -FARTHEST..=FARTHEST).max_decimals(3);
            if ui.add(slider).labelled_by(label).changed() {
                plane[3] = distance * length;
            }
            if ui.small_button("Face").on_hover_text("Turns the plane to face the eye").clicked() {
                *plane = facing(distance);
            }
            if ui.small_button("Flip").on_hover_text("Keeps the other side").clicked() {
                *plane = plane.map(|x| -x);
            }
            if ui.small_button("Remove").clicked() {
                removed = Some(number);
            }
        });
    }
    if let Some(number) = removed {
        planes.remove(number);
    }
    let has_room = planes.len() < ClipPlanes::MOST;
    let add = ui.add_enabled(has_room, eframe::egui::Button::new("Add a plane"));
    if add.on_hover_text("Cuts the volume in the middle, facing the eye").clicked() {
        planes.push(facing(0.0));
    }
    if planes != settings.clip_plane.clone().unwrap_or_default() {
        settings.clip_plane = (!planes.is_empty()).then_some(planes);
    }
}
