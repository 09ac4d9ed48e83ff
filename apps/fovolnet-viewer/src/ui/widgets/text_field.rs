use eframe::egui::{Id, Response, TextEdit, Ui};

/// Field for the text of a setting.
///
/// The setting may have another text for the same value, such as `0.5,0` for `0.5,0.0`. So the field keeps the text that
/// is typed until it loses the focus.
#[derive(Debug, Clone, Copy)]
pub struct TextField {
    /// Unique name of the field.
    pub name: &'static str,
    /// Width in points.
    pub width: f32,
    /// Explanation that appears under the pointer.
    pub hint: &'static str,
    /// Text that an empty field shows.
    pub usual: &'static str,
}

impl TextField {
    /// Shows the field with the text `given`; returns its text.
    pub fn ui(&self, ui: &mut Ui, given: &str) -> (String, Response) {
        let id = Id::unique(("text field", self.name));
        let typed: Option<String> = ui.data(|data| data.get_temp(id));
        let mut text = typed.unwrap_or_else(|| given.to_owned());
        let edit = TextEdit::singleline(&mut text).hint_text(self.usual).desired_width(self.width);
        let response = ui.add(edit).on_hover_text(self.hint);
        let has_focus = response.has_focus();
        ui.data_mut(|data| {
            if has_focus {
                data.insert_temp(id, text.clone());
            } else {
                data.remove_temp::<String>(id);
            }
        });
        (text, response)
    }
}
