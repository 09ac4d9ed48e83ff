use crate::ui::widgets::colour_button::colour_button;
use eframe::egui::{ScrollArea, Ui};
use fovolnet::presets::ShownLabel;

/// Height of the list, in points; longer lists scroll.
const HEIGHT: f32 = 220.0;

/// Panel for the labels of a label map: which are shown, and in which colours. Returns whether anything changed.
pub fn labels(ui: &mut Ui, labels: &mut [ShownLabel]) -> bool {
    let mut is_changed = false;
    ui.horizontal(|ui| {
        for (name, opacity) in [("Show all", ShownLabel::OPACITY), ("Hide all", 0.0)] {
            if ui.button(name).clicked() {
                labels.iter_mut().for_each(|label| label.opacity = opacity);
                is_changed = true;
            }
        }
    });
    ScrollArea::vertical().id_salt("labels").max_height(HEIGHT).show(ui, |ui| {
        for label in labels {
            ui.horizontal(|ui| {
                is_changed |= colour_button(ui, &mut label.colour);
                let mut is_shown = label.opacity > 0.0;
                let value = label.value;
                let name = if label.name.is_empty() {
                    format!("label {value}")
                } else {
                    format!("{} ({value})", label.name)
                };
                if ui.checkbox(&mut is_shown, name).changed() {
                    label.opacity = if is_shown { ShownLabel::OPACITY } else { 0.0 };
                    is_changed = true;
                }
            });
        }
    });
    is_changed
}
