use crate::frames::display_mode::DisplayMode;
use crate::frames::presented::{Presented, Progress};
use crate::session::places::Preferences;
use eframe::egui::{DragValue, Ui};
use fovolnet::RenderSettings;

/// Panel for the frame rate in motion.
pub fn budget(ui: &mut Ui, preferences: &mut Preferences, shown: Option<&Presented>) {
    ui.horizontal(|ui| {
        let mut keeps = preferences.rate > 0.0;
        if ui.checkbox(&mut keeps, "Keep").changed() {
            preferences.rate = if keeps { Preferences::default().rate } else { 0.0 };
        }
        ui.add_enabled_ui(keeps, |ui| {
            let rate = DragValue::new(&mut preferences.rate).range(1.0..=240.0).speed(0.2).max_decimals(0);
            let rate = ui.add(rate);
            let label = ui.label("frames a second in motion").id;
            rate.labelled_by(label);
        });
    });
    ui.checkbox(&mut preferences.converges, "Still views become the full frame");
    let Some(shown) = shown else { return };
    if let Some(plan) = shown.plan.as_ref().filter(|_| shown.progress == Progress::Moving) {
        let RenderSettings { pb, sigma, step, reconstruction, .. } = &shown.settings;
        let way = match plan.way.is_full() {
            true => format!("every pixel, {}, step {step:.2}", plan.way),
            false => format!("{}, P_b {pb:.3}, σ {sigma:.3}, step {step:.2}, {reconstruction}", plan.way),
        };
        ui.weak(format!("Now {}, {way}", plan.size)).on_hover_text(&plan.why);
    }
}

/// Panel for the display mode.
pub fn looks(ui: &mut Ui, look: &mut DisplayMode) {
    ui.horizontal_wrapped(|ui| {
        for each in DisplayMode::ALL {
            ui.selectable_value(look, each, each.name()).on_hover_text(each.explanation());
        }
    });
}
