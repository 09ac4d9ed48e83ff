use eframe::egui::{Button, Ui};

/// Shows buttons; returns true to accept, false to cancel, `None` if neither was clicked. A `problem` disables
/// accepting.
pub fn accept_buttons(ui: &mut Ui, accept: &str, problem: Option<&str>) -> Option<bool> {
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let accepts = ui.add_enabled(problem.is_none(), Button::new(accept)).clicked();
        let cancels = ui.button("Cancel").clicked();
        if let Some(problem) = problem {
            ui.weak(problem);
        }
        if accepts { Some(true) } else { cancels.then_some(false) }
    })
    .inner
}
