use crate::session::opened::Opened;
use crate::ui::slices::slices_state::Slices;
use crate::ui::slices::value_window::ValueWindow;
use eframe::egui::{Button, DragValue, Ui};
use fovolnet::VolumeSettings;

/// Panel for window and level of the slices, and for rulers. Returns changed settings, with which the file must be read
/// again.
pub fn slices(ui: &mut Ui, slices: &mut Slices, opened: &Opened) -> Option<VolumeSettings> {
    let mut read = None;
    let usual = ValueWindow::over(opened.volume.volume.range());
    let shown = slices.shown_window(opened);
    let mut window = shown;
    let field = |ui: &mut Ui, name: &str, number: &mut f64| {
        let label = ui.label(name).id;
        let field = DragValue::new(number).speed(0.002 * usual.width).max_decimals(3);
        ui.add(field).labelled_by(label);
    };
    ui.add_enabled_ui(opened.slice_colours.are_greys(&opened.volume), |ui| {
        ui.horizontal(|ui| {
            field(ui, "Window", &mut window.width);
            field(ui, "Level", &mut window.centre);
            if ui.add_enabled(slices.window.is_some(), Button::new("Reset")).clicked() {
                slices.window = None;
            }
        });
        let use_it = ui.add_enabled(shown != usual, Button::new("Use for the picture"));
        if use_it.on_hover_text("The 3-D picture shows these values, too").clicked() {
            let window = Some([shown.centre, shown.width]);
            read = Some(VolumeSettings { window, range: None, ..opened.document.session().read.clone() });
        }
    });
    if window != shown && window.width > 0.0 {
        slices.window = Some(window);
    }
    ui.horizontal(|ui| {
        ui.toggle_value(&mut slices.measures, "Ruler").on_hover_text("Drag from one point to another");
        let has_some = slices.rulers.iter().next().is_some();
        if ui.add_enabled(has_some, Button::new("Clear rulers")).clicked() {
            slices.rulers.clear();
        }
    });
    read
}
