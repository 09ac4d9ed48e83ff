//! Controls of optional settings.

use eframe::egui::{ComboBox, Slider, Ui};
use std::ops::RangeInclusive;

/// Slider for an optional number.
pub fn number(
    ui: &mut Ui,
    name: &str,
    value: &mut Option<f64>,
    default: f64,
    range: RangeInclusive<f64>,
    logarithmic: bool,
) {
    let mut now = value.unwrap_or(default);
    let slider = Slider::new(&mut now, range).logarithmic(logarithmic).max_decimals(3).text(name);
    let response = ui.add(slider).on_hover_text("Double click: as usual");
    if response.changed() {
        *value = Some(now);
    }
    if response.double_clicked() {
        *value = None;
    }
}

/// List to choose from.
pub fn choice<T: Copy + PartialEq, N: Into<String>>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    all: &[T],
    name_of: impl Fn(T) -> N,
) {
    ui.horizontal(|ui| {
        let label = ui.label(name).id;
        let list = ComboBox::from_id_salt(name).selected_text(name_of(*value).into()).show_ui(ui, |ui| {
            for &each in all {
                ui.selectable_value(value, each, name_of(each).into());
            }
        });
        list.response.labelled_by(label);
    });
}

/// Stores `value` in a setting, unless the setting is empty and the value is the `usual` one.
pub fn set<T: Copy + PartialEq>(given: &mut Option<T>, value: T, usual: T) {
    if given.is_some() || value != usual {
        *given = Some(value);
    }
}
