//! Text field for a file name, with checks.

use crate::ui::dialogues::files::{self, Purpose};
use crate::ui::start_page::middle_cut;
use eframe::egui::{Label, RichText, TextEdit, Ui};
use fovolnet::core::{path_of_text, text_of_path};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

/// Text field for a file name, typed or chosen.
#[derive(Debug)]
pub(crate) struct FileField {
    purpose: Purpose,
    text: String,
    /// Whether the field was shown before.
    is_known: bool,
    browsing: Option<Receiver<PathBuf>>,
}

impl FileField {
    /// Field for `purpose` with the initial path `suggested`.
    pub fn new(purpose: Purpose, suggested: &Path) -> Self {
        Self { purpose, text: text_of_path(suggested), is_known: false, browsing: None }
    }

    /// Purpose of the file.
    pub fn purpose(&self) -> Purpose {
        self.purpose
    }

    fn path(&self) -> PathBuf {
        path_of_text(self.text.trim()).into_owned()
    }

    /// File to read or write: the typed path, with the default extension if it has none.
    pub fn target(&self) -> PathBuf {
        with_extension(self.path(), self.purpose)
    }

    /// Shows the field; returns whether Enter was pressed in it.
    pub fn ui(&mut self, ui: &mut Ui) -> bool {
        if let Some(path) = self.browsing.as_ref().and_then(|browsing| browsing.try_recv().ok()) {
            self.text = text_of_path(&path);
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
        entered.inner
    }

    /// Reason why the file cannot be read or written.
    pub fn problem(&self) -> Option<&'static str> {
        let path = self.path();
        if self.text.trim().is_empty() {
            return Some("Type a path, or browse.");
        }
        if self.purpose.reads() {
            return None;
        }
        if let Some(problem) = self.ending_problem() {
            return Some(problem);
        }
        let is_there = path.parent().is_none_or(|folder| folder.as_os_str().is_empty() || folder.is_dir());
        (!is_there).then_some("There is no such folder.")
    }

    /// Problem with the extension of an output file.
    fn ending_problem(&self) -> Option<&'static str> {
        let path = self.target();
        let ends_in = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
        match self.purpose {
            Purpose::SavePicture if !ends_in("png") => Some("Pictures are PNG: end the name in .png."),
            Purpose::SaveVideo if ends_in("toml") => Some("Sessions end in .toml, clips in .mp4 or .y4m."),
            _ => None,
        }
    }
}

/// Adds the default extension to `path` if it has none.
fn with_extension(path: PathBuf, purpose: Purpose) -> PathBuf {
    match purpose.extensions().first() {
        Some(usual) if path.extension().is_none() && path.file_name().is_some() => path.with_extension(usual),
        _ => path,
    }
}

/// Warns about those of `files` that exist and will be replaced.
pub(crate) fn will_be_replaced(ui: &mut Ui, files: &[PathBuf]) {
    for file in files.iter().filter(|file| file.is_file()) {
        let name =
            file.file_name().map_or_else(|| file.display().to_string(), |name| name.display().to_string());
        warning(ui, format!("{} is there already and will be replaced.", middle_cut(&name, 60)));
    }
}

/// Shows a warning.
pub(crate) fn warning(ui: &mut Ui, text: impl Into<String>) {
    let text = RichText::new(text).color(ui.visuals().warn_fg_color);
    ui.add(Label::new(text).wrap());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_without_an_ending_get_one() {
        let named = |text: &str, purpose| with_extension(PathBuf::from(text), purpose).display().to_string();
        assert_eq!(named("a/b", Purpose::SavePicture), "a/b.png");
        assert_eq!(named("a/b.jpg", Purpose::SavePicture), "a/b.jpg");
        assert_eq!(named("", Purpose::SavePicture), "");
        assert_eq!(named("a/b", Purpose::Open), "a/b");
    }

    #[test]
    fn folders_that_are_not_there_are_a_problem_and_nothing_is_too() {
        let problem = |text: &str| FileField::new(Purpose::SaveSession, Path::new(text)).problem();
        assert!(problem("").is_some() && problem("/no/such/folder/a.toml").is_some());
        assert!(problem("a.toml").is_none());
    }

    #[test]
    fn a_picture_is_not_written_under_the_ending_of_something_else() {
        let problem = |text: &str, purpose| FileField::new(purpose, Path::new(text)).problem();
        assert!(problem("a.jpg", Purpose::SavePicture).is_some());
        assert!(problem("a.toml", Purpose::SavePicture).is_some());
        assert!(problem("a.toml", Purpose::SaveVideo).is_some());
        for good in ["a", "a.png", "a.PNG"] {
            assert_eq!(problem(good, Purpose::SavePicture), None);
        }
        assert_eq!(problem("a.mkv", Purpose::SaveVideo), None);
    }
}
