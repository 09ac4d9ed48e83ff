//! What is said to the person at the window, where they look.

use eframe::egui::{Align2, Area, Context, Frame, Id, Label, Order, RichText, Ui, vec2};

/// What is said.
#[derive(Debug, Default)]
pub struct Messages {
    notes: Vec<(String, f64)>,
    errors: Vec<String>,
    /// What keeps pictures from being made.
    picture: Option<String>,
}

/// Seconds that a note stays, and a little more for each character.
const STAY: f64 = 4.0;
const STAY_A_CHARACTER: f64 = 0.05;
/// The most that is shown at once.
const MOST: usize = 4;

impl Messages {
    /// Says something that goes away by itself.
    pub fn note(&mut self, text: String, time: f64) {
        let until = time + STAY + STAY_A_CHARACTER * text.len() as f64;
        self.notes.retain(|(said, _)| *said != text);
        self.notes.push((text, until));
    }

    /// Says something that is wrong until it is right or taken away.
    pub fn error(&mut self, text: String) {
        if !self.errors.contains(&text) {
            self.errors.push(text);
        }
    }

    /// Says what keeps pictures from being made; nothing does without.
    pub fn set_picture_error(&mut self, text: Option<String>) {
        self.picture = text;
    }

    /// What keeps pictures from being made.
    pub fn picture_error(&self) -> Option<&str> {
        self.picture.as_deref()
    }

    /// What was wrong was with something that is no longer there.
    pub fn clear_errors(&mut self) {
        self.errors.clear();
        self.picture = None;
    }

    /// What is wrong.
    pub fn errors(&self) -> impl Iterator<Item = &str> {
        self.picture.iter().chain(&self.errors).map(String::as_str)
    }

    /// What is to be known.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.notes.iter().map(|(text, _)| text.as_str())
    }

    /// Shows them at the lower left of the window.
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

/// Something that is wrong, in the colour of such.
fn wrong(ui: &mut Ui, text: &str) {
    let text = RichText::new(text).color(ui.visuals().error_fg_color);
    ui.add(Label::new(text).wrap());
}
