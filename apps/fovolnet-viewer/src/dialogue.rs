//! Questions that are asked before something is done.

use crate::commands::{GESTURES, all};
use crate::export::{Export, Kind};
use crate::files::{self, Purpose};
use crate::layout_form::LayoutForm;
use eframe::egui::{Button, Context, DragValue, Grid, Id, Modal, RichText, ScrollArea, TextEdit, Ui};
use fovolnet::core::{FrameSize, MAX_FRAME_SIDE};
use fovolnet::{Session, VolumeSettings};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

/// A question.
#[derive(Debug)]
pub enum Dialogue {
    /// Which file?
    File(FilePrompt),
    /// Export what?
    Export(ExportForm),
    /// What of the changes that no file has, before this is done?
    Unsaved(Next),
    /// Go on with what was not saved when the viewer ended last?
    Restore(Box<Session>),
    /// How do the voxels of a file lie?
    Layout(LayoutForm),
    /// Which keys are there?
    Help,
}

/// What is to be done when a question is answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    /// Open this.
    Open(String),
    /// Close the session.
    Close,
    /// End the viewer.
    Quit,
}

/// An answer.
#[derive(Debug, PartialEq)]
pub enum Answer {
    /// Never mind.
    Cancel,
    /// This file.
    File(Purpose, PathBuf),
    /// This.
    Export(Box<Export>),
    /// Save first.
    Save(Next),
    /// Without saving.
    Discard(Next),
    /// Open this file so.
    Layout(String, VolumeSettings),
    /// Nobody wants what was not saved.
    Forget,
    /// Go on with it.
    Restore(Box<Session>),
}

impl Dialogue {
    /// Shows it; the answer when there is one.
    pub fn show(&mut self, context: &Context) -> Option<Answer> {
        let modal = Modal::new(Id::unique("dialogue")).show(context, |ui| {
            ui.set_max_width(460.0);
            match self {
                Self::File(prompt) => prompt.ui(ui),
                Self::Export(form) => form.ui(ui),
                Self::Unsaved(next) => unsaved(ui, next),
                Self::Restore(session) => restore(ui, session),
                Self::Layout(form) => layout(ui, form),
                Self::Help => help(ui),
            }
        });
        if modal.should_close() {
            return Some(Answer::Cancel);
        }
        modal.inner
    }
}

/// The name of a file, typed or chosen.
#[derive(Debug)]
pub struct FileField {
    purpose: Purpose,
    text: String,
    /// Whether it was shown before.
    is_known: bool,
    browsing: Option<Receiver<PathBuf>>,
}

impl FileField {
    fn new(purpose: Purpose, suggested: &Path) -> Self {
        Self { purpose, text: suggested.display().to_string(), is_known: false, browsing: None }
    }

    fn path(&self) -> PathBuf {
        PathBuf::from(self.text.trim())
    }

    /// Whether Enter was pressed in it.
    fn ui(&mut self, ui: &mut Ui) -> bool {
        if let Some(path) = self.browsing.as_ref().and_then(|browsing| browsing.try_recv().ok()) {
            self.text = path.display().to_string();
        }
        let entered = ui.horizontal(|ui| {
            let edit = ui
                .add(TextEdit::singleline(&mut self.text).desired_width(330.0).hint_text("path of the file"));
            if !std::mem::replace(&mut self.is_known, true) {
                edit.request_focus();
            }
            let entered = edit.lost_focus() && ui.input(|input| input.key_pressed(eframe::egui::Key::Enter));
            if ui.button("Browse…").clicked() {
                let context = ui.ctx().clone();
                self.browsing =
                    Some(files::browse(self.purpose, self.path(), move || context.request_repaint()));
            }
            entered
        });
        if !self.purpose.reads() && self.path().exists() {
            ui.colored_label(ui.visuals().warn_fg_color, "This file is there already and will be replaced.");
        }
        entered.inner
    }

    /// What keeps the file from being read or written.
    fn problem(&self) -> Option<&'static str> {
        let path = self.path();
        if self.text.trim().is_empty() {
            return Some("Type a path, or browse.");
        }
        if self.purpose.reads() {
            return None;
        }
        let is_there = path.parent().is_none_or(|folder| folder.as_os_str().is_empty() || folder.is_dir());
        (!is_there).then_some("There is no such folder.")
    }
}

/// Asks for a file.
#[derive(Debug)]
pub struct FilePrompt(FileField);

impl FilePrompt {
    /// For `purpose`, with `suggested` to begin with.
    pub fn new(purpose: Purpose, suggested: &Path) -> Self {
        Self(FileField::new(purpose, suggested))
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.heading(self.0.purpose.title());
        let entered = self.0.ui(ui);
        let accept = if self.0.purpose.reads() { "Open" } else { "Save" };
        let answer = buttons(ui, accept, self.0.problem());
        match answer {
            Some(true) => {}
            None if entered && self.0.problem().is_none() => {}
            Some(false) => return Some(Answer::Cancel),
            None => return None,
        }
        Some(Answer::File(self.0.purpose, with_extension(self.0.path(), self.0.purpose)))
    }
}

/// Asks what to export.
#[derive(Debug)]
pub struct ExportForm {
    is_video: bool,
    file: FileField,
    size: [u32; 2],
    is_full: bool,
    is_transparent: bool,
    with_session: bool,
    frames: u32,
    fps: u32,
}

impl ExportForm {
    /// A picture of `size`.
    pub fn picture(size: FrameSize, suggested: &Path) -> Self {
        Self {
            is_video: false,
            file: FileField::new(Purpose::SavePicture, suggested),
            size: size.into(),
            is_full: true,
            is_transparent: false,
            with_session: true,
            frames: 1,
            fps: 30,
        }
    }

    /// A video of `frames` frames.
    pub fn video(size: FrameSize, frames: u32, suggested: &Path) -> Self {
        let file = FileField::new(Purpose::SaveVideo, suggested);
        Self { is_video: true, file, frames, ..Self::picture(size, suggested) }
    }

    fn ui(&mut self, ui: &mut Ui) -> Option<Answer> {
        ui.heading(self.file.purpose.title());
        self.file.ui(ui);
        Grid::new("export").num_columns(2).show(ui, |ui| {
            ui.label("Size");
            ui.horizontal(|ui| {
                let [width, height] = &mut self.size;
                for (side, suffix) in [(width, " wide"), (height, " high")] {
                    ui.add(DragValue::new(side).range(1..=MAX_FRAME_SIDE).suffix(suffix));
                }
            });
            ui.end_row();
            if self.is_video {
                ui.label("Length");
                ui.horizontal(|ui| {
                    ui.add(DragValue::new(&mut self.frames).range(1..=100_000).suffix(" frames"));
                    ui.add(DragValue::new(&mut self.fps).range(1..=240).suffix(" a second"));
                });
                ui.end_row();
            }
        });
        ui.checkbox(&mut self.is_full, "Measure every pixel")
            .on_hover_text("Otherwise sampled and reconstructed as the session says: faster, not exact");
        if !self.is_video {
            ui.checkbox(&mut self.is_transparent, "Transparent background");
        }
        ui.checkbox(&mut self.with_session, "Write the session beside it")
            .on_hover_text("`fovolnet render` makes the same pixels of it");
        if self.is_video && !fovolnet::io::video::ffmpeg_installed() && !self.file.text.ends_with(".y4m") {
            ui.colored_label(
                ui.visuals().warn_fg_color,
                "ffmpeg is not installed: the clip will be a .y4m file, large and without loss.",
            );
        }
        match buttons(ui, "Export", self.file.problem())? {
            true => Some(Answer::Export(Box::new(self.export()?))),
            false => Some(Answer::Cancel),
        }
    }

    fn export(&self) -> Option<Export> {
        let kind = match self.is_video {
            true => Kind::Video { frames: self.frames, fps: self.fps },
            false => Kind::Picture { is_transparent: self.is_transparent },
        };
        Some(Export {
            path: with_extension(self.file.path(), self.file.purpose),
            size: FrameSize::new(self.size[0], self.size[1]).ok()?,
            is_full: self.is_full,
            with_session: self.with_session,
            kind,
        })
    }
}

/// `path`, with the usual ending where it has none.
fn with_extension(path: PathBuf, purpose: Purpose) -> PathBuf {
    match purpose.extensions().first() {
        Some(usual) if path.extension().is_none() => path.with_extension(usual),
        _ => path,
    }
}

/// Whether to go on (true) or to stop (false).
fn buttons(ui: &mut Ui, accept: &str, problem: Option<&str>) -> Option<bool> {
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

fn layout(ui: &mut Ui, form: &mut LayoutForm) -> Option<Answer> {
    let problem = form.ui(ui);
    match buttons(ui, "Open", problem)? {
        true => Some(Answer::Layout(form.source().to_owned(), form.settings())),
        false => Some(Answer::Cancel),
    }
}

fn help(ui: &mut Ui) -> Option<Answer> {
    ui.heading("Keys and mouse");
    ScrollArea::vertical().max_height(ui.ctx().content_rect().height() - 160.0).show(ui, |ui| {
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
    ui.button("Close").clicked().then_some(Answer::Cancel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_without_an_ending_get_one() {
        let named = |text: &str, purpose| with_extension(PathBuf::from(text), purpose).display().to_string();
        assert_eq!(named("a/b", Purpose::SavePicture), "a/b.png");
        assert_eq!(named("a/b.jpg", Purpose::SavePicture), "a/b.jpg");
        assert_eq!(named("a/b", Purpose::Open), "a/b");
    }

    #[test]
    fn folders_that_are_not_there_are_a_problem_and_nothing_is_too() {
        let problem = |text: &str| FileField::new(Purpose::SaveSession, Path::new(text)).problem();
        assert!(problem("").is_some() && problem("/no/such/folder/a.toml").is_some());
        assert!(problem("a.toml").is_none());
    }
}
