//! Modal dialogues.

use crate::ui::commands::{GESTURES, HELP, all};
use crate::ui::dialogues::answer::{Answer, Next};
use crate::ui::dialogues::export_form::ExportForm;
use crate::ui::dialogues::file_field::{FileField, will_be_replaced};
use crate::ui::dialogues::files::Purpose;
use crate::ui::dialogues::layout_form::LayoutForm;
use crate::ui::widgets::accept_buttons::accept_buttons;
use eframe::egui::{Context, Grid, Id, Modal, RichText, ScrollArea, Ui, style::ScrollStyle};
use fovolnet::Session;
use std::path::Path;

/// Modal dialogue.
#[derive(Debug)]
pub enum Dialogue {
    /// Choice of a file.
    File(FilePrompt),
    /// Export of a picture or clip.
    Export(ExportForm),
    /// Question about unsaved changes before the given action.
    Unsaved(Next),
    /// Offer to restore the session of a crashed viewer.
    Restore(Box<Session>),
    /// Layout of a raw file's voxels.
    Layout(LayoutForm),
    /// Asks whether to end the viewer although this export is under way.
    Leave(String),
    /// Help for keys and mouse.
    Help,
}

impl Dialogue {
    /// Shows the dialogue; returns an answer when there is one.
    pub fn show(&mut self, context: &Context) -> Option<Answer> {
        let modal = Modal::new(Id::unique("dialogue")).show(context, |ui| {
            ui.set_max_width(460.0);
            match self {
                Self::File(prompt) => prompt.ui(ui),
                Self::Export(form) => form.ui(ui),
                Self::Unsaved(next) => unsaved(ui, next),
                Self::Restore(session) => restore(ui, session),
                Self::Layout(form) => layout(ui, form),
                Self::Leave(export) => leave(ui, export),
                Self::Help => help(ui),
            }
        });
        if modal.should_close() {
            return Some(Answer::Cancel);
        }
        modal.inner
    }
}

/// Dialogue for a file name.
#[derive(Debug)]
pub struct FilePrompt(FileField);

impl FilePrompt {
    /// Dialogue for `purpose` with the initial path `suggested`.
    pub fn new(purpose: Purpose, suggested: &Path) -> Self {
        Self(FileField::new(purpose, suggested))
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.heading(self.0.purpose().title());
        let entered = self.0.ui(ui);
        if !self.0.purpose().reads() {
            will_be_replaced(ui, &[self.0.target()]);
        }
        let accept = if self.0.purpose().reads() { "Open" } else { "Save" };
        let answer = accept_buttons(ui, accept, self.0.problem());
        match answer {
            Some(true) => {}
            None if entered && self.0.problem().is_none() => {}
            Some(false) => return Some(Answer::Cancel),
            None => return None,
        }
        Some(Answer::File(self.0.purpose(), self.0.target()))
    }
}

fn unsaved(ui: &mut Ui, next: &Next) -> Option<Answer> {
    ui.heading("Save the changes?");
    ui.label("What you changed of this session is in no file yet.");
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button("Save").clicked() {
            return Some(Answer::Save(next.clone()));
        }
        if ui.button("Do not save").clicked() {
            return Some(Answer::Discard(next.clone()));
        }
        ui.button("Cancel").clicked().then_some(Answer::Cancel)
    })
    .inner
}

fn restore(ui: &mut Ui, session: &Session) -> Option<Answer> {
    ui.heading("Go on where you were?");
    ui.label("The viewer ended last time before this session was saved:");
    ui.label(RichText::new(&session.volume).strong());
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button("Go on with it").clicked() {
            return Some(Answer::Restore(Box::new(session.clone())));
        }
        ui.button("Forget it").clicked().then_some(Answer::Forget)
    })
    .inner
}

fn leave(ui: &mut Ui, export: &str) -> Option<Answer> {
    ui.heading("Leave during the export?");
    ui.label("An export is running, which ends with the viewer and leaves no file:");
    ui.label(RichText::new(export).strong());
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.button("Leave and drop it").clicked() {
            return Some(Answer::Leave);
        }
        ui.button("Stay").clicked().then_some(Answer::Cancel)
    })
    .inner
}

fn layout(ui: &mut Ui, form: &mut LayoutForm) -> Option<Answer> {
    let problem = form.ui(ui);
    match accept_buttons(ui, "Open", problem)? {
        true => Some(Answer::Layout(form.source().to_owned(), Box::new(form.settings()))),
        false => Some(Answer::Cancel),
    }
}

fn help(ui: &mut Ui) -> Option<Answer> {
    ui.heading("Keys and mouse");
    ui.spacing_mut().scroll = ScrollStyle::solid();
    let height = ui.ctx().content_rect().height() - 160.0;
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
        Grid::new("help").num_columns(2).spacing([24.0, 3.0]).show(ui, |ui| {
            for (gesture, what) in GESTURES {
                ui.strong(*gesture);
                ui.label(*what);
                ui.end_row();
            }
            for entry in all() {
                if let Some(keys) = entry.shortcut {
                    ui.strong(ui.ctx().format_shortcut(&keys));
                    ui.label(entry.name);
                    ui.end_row();
                }
            }
        });
    });
    ui.add_space(8.0);
    // The shortcut that opened the help also closes it.
    let mut keys = HELP.iter().filter_map(|entry| entry.shortcut);
    let is_pressed = ui.input_mut(|input| keys.any(|key| input.consume_shortcut(&key)));
    (ui.button("Close").clicked() || is_pressed).then_some(Answer::Cancel)
}
