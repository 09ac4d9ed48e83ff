use crate::ui::widgets::range_slider::range_slider;
use eframe::egui::{Ui, vec2};
use fovolnet::{CropBox, NamedView, Orientation, RenderOverrides};

/// Panel for the volume's orientation and the named views. `has_placement` tells whether the file has a patient
/// position.
pub fn standing(ui: &mut Ui, settings: &mut RenderOverrides, has_placement: bool) {
    ui.horizontal(|ui| {
        ui.label("Orientation");
        ui.add_enabled_ui(has_placement, |ui| {
            for (choice, name) in
                [(None, "auto"), (Some(Orientation::Grid), "grid"), (Some(Orientation::Patient), "patient")]
            {
                ui.selectable_value(&mut settings.orientation, choice, name);
            }
        });
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("View");
        for view in NamedView::ALL {
            let is_shown = settings.view == Some(view) && settings.camera.is_none();
            if ui.selectable_label(is_shown, view.name()).clicked() {
                (settings.view, settings.camera, settings.path) = (Some(view), None, None);
                settings.first_frame = None;
            }
        }
    });
}

/// Panel for the crop box, in voxels of a volume of `dims`.
pub fn cropping(ui: &mut Ui, settings: &mut RenderOverrides, dims: [usize; 3]) {
    let before = settings.clip.unwrap_or(CropBox::WHOLE);
    let mut now = before;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let voxels = dims[axis] as f64;
        let range = &mut now.sides[axis];
        ui.horizontal(|ui| {
            ui.label(name);
            let [from, to] = range.map(|side| (side * voxels * 10.0).round() / 10.0);
            let numbers = format!("{from}–{to}");
            let width = ui.available_width() - 70.0;
            ui.allocate_ui(vec2(width, 18.0), |ui| range_slider(ui, range, 1.0 / voxels));
            ui.weak(numbers);
        });
    }
    ui.horizontal(|ui| {
        ui.label("Slice");
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let hint = "A slab of two voxels in the middle; drag it through the volume with its slider";
            if ui.button(name).on_hover_text(hint).clicked() {
                let half = 1.0 / dims[axis] as f64;
                now = CropBox::WHOLE;
                now.sides[axis] = [(0.5 - half).max(0.0), (0.5 + half).min(1.0)];
            }
        }
        if ui.button("Whole").clicked() {
            now = CropBox::WHOLE;
        }
    });
    if now != before {
        settings.clip = (now != CropBox::WHOLE).then_some(now);
    }
}
