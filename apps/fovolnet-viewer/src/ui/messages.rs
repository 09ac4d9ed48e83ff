//! Messages for the user in the window.

use eframe::egui::{Align2, Area, Context, Frame, Id, Label, Order, RichText, Ui, vec2};

/// Messages for the user.
#[derive(Debug, Default)]
pub struct Messages {
    notes: Vec<(String, f64)>,
    errors: Vec<String>,
    /// Error that prevents pictures.
    picture: Option<String>,
}

/// Seconds that a note stays, plus a little for each character.
const STAY: f64 = 4.0;
const STAY_A_CHARACTER: f64 = 0.05;
/// Most messages shown at once.
const MOST: usize = 4;

impl Messages {
    /// Shows a note that disappears by itself.
    pub fn note(&mut self, text: String, time: f64) {
        let until = time + STAY + STAY_A_CHARACTER * text.len() as f64;
        self.notes.retain(|(said, _)| *said != text);
        self.notes.push((text, until));
    }

    /// Shows an error until it is dismissed or cleared.
    pub fn error(&mut self, text: String) {
        if !self.errors.contains(&text) {
            self.errors.push(text);
        }
    }

    /// Sets the error that prevents pictures; `None` clears it.
    pub fn set_picture_error(&mut self, text: Option<String>) {
        self.picture = text;
    }

    /// Error that prevents pictures.
    pub fn picture_error(&self) -> Option<&str> {
        self.picture.as_deref()
    }

    /// Clears all errors, for example when their file is closed.
    pub fn clear_errors(&mut self) {
        self.errors.clear();
        self.picture = None;
    }

    /// All current errors.
    pub fn errors(&self) -> impl Iterator<Item = &str> {
        self.picture.iter().chain(&self.errors).map(String::as_str)
    }

    /// All current notes.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.notes.iter().map(|(text, _)| text.as_str())
    }

    /// Shows the messages at the lower left of the window.
    pub fn show(&mut self, context: &Context) {
        let time = context.input(|input| input.time);
        self.notes.retain(|(_, until)| *until > time);
        if self.errors.is_empty() && self.notes.is_empty() && self.picture.is_none() {
            return;
        }
        if let Some(next) = self.notes.iter().map(|(_, until)| until - time).min_by(f64::total_cmp) {
            context.request_repaint_after_secs(next as f32 + 0.05);
        }
        let area = Area::new(Id::unique("messages")).order(Order::Foreground);
        area.anchor(Align2::LEFT_BOTTOM, vec2(12.0, -100.0)).show(context, |ui| {
            ui.set_max_width(440.0);
            if let Some(text) = &self.picture {
                Frame::popup(ui.style()).show(ui, |ui| wrong(ui, text));
            }
            let mut taken = None;
            for (i, text) in self.errors.iter().enumerate().rev().take(MOST) {
                Frame::popup(ui.style()).show(ui, |ui| {
                    ui.horizontal_top(|ui| {
                        if ui.small_button("×").clicked() {
                            taken = Some(i);
                        }
                        wrong(ui, text);
                    });
                });
            }
            for (text, _) in self.notes.iter().rev().take(MOST) {
                Frame::popup(ui.style()).show(ui, |ui| ui.add(Label::new(text).wrap()));
            }
            if let Some(i) = taken {
                self.errors.remove(i);
            }
        });
    }
}

/// Shows an error text in the error colour.
fn wrong(ui: &mut Ui, text: &str) {
    let text = RichText::new(text).color(ui.visuals().error_fg_color);
    ui.add(Label::new(text).wrap());
}
