//! What is looked at and how: what a session file holds, with what is needed to work on it.

use crate::kept;
use eframe::egui::util::undoer::Undoer;
use fovolnet::core::{TransferFunction, path_of_text};
use fovolnet::{OpenVolume, RenderSettings, Result, Session, VolumeSettings, presets};
use std::path::{Path, PathBuf};

/// A session that somebody works on.
#[derive(Debug)]
pub struct Document {
    session: Session,
    /// What a file has, or what anybody can have without one.
    saved: Option<Session>,
    file: Option<PathBuf>,
    undoer: Undoer<RenderSettings>,
}

impl Document {
    /// A new session of the volume `source`.
    ///
    /// # Errors
    /// What the system said when the volume's file was read.
    pub fn new(source: &str, read: VolumeSettings, render: RenderSettings) -> Result<Self> {
        Ok(Self::of(Session::new(source, read, render)?, None))
    }

    /// The session in the file `path`, with `over` on top.
    ///
    /// # Errors
    /// A file that is missing or says something unknown.
    pub fn open(path: &Path, read: VolumeSettings, over: RenderSettings) -> Result<Self> {
        let mut session = Session::read(path)?;
        session.read = session.read.overridden_by(read);
        session.render = session.render.overridden_by(over);
        Ok(Self::of(session, Some(path.to_owned())))
    }

    /// What was being worked on when the program ended; not saved anywhere else.
    pub fn restored(session: Session) -> Self {
        Self { saved: None, ..Self::of(session, None) }
    }

    fn of(session: Session, file: Option<PathBuf>) -> Self {
        Self { saved: Some(session.clone()), session, file, undoer: Undoer::default() }
    }

    /// The session as it is now.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// How the volume is shown.
    pub fn settings(&self) -> &RenderSettings {
        &self.session.render
    }

    /// How the volume is shown, to change it.
    pub fn settings_mut(&mut self) -> &mut RenderSettings {
        &mut self.session.render
    }

    /// The file that the session lies in.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Whether it is what was being worked on when a viewer crashed, and no file has it yet.
    pub fn is_restored(&self) -> bool {
        self.saved.is_none()
    }

    /// Whether there is something that no file has.
    pub fn is_changed(&self) -> bool {
        self.saved.as_ref() != Some(&self.session)
    }

    /// Whether there is something that no file has and somebody would miss: from where the volume is looked at now, and which
    /// frame of its path is shown, is found again with a move of the hand.
    pub fn has_unsaved_work(&self) -> bool {
        let apart = |session: &Session| {
            let render = RenderSettings { camera: None, first_frame: None, ..session.render.clone() };
            Session { render, ..session.clone() }
        };
        self.saved.as_ref().is_none_or(|saved| apart(saved) != apart(&self.session))
    }

    /// A name for the title of a window.
    pub fn name(&self) -> String {
        let path = self.file.clone().unwrap_or_else(|| path_of_text(&self.session.volume).into_owned());
        path.file_name().map_or_else(|| self.session.volume.clone(), |name| name.display().to_string())
    }

    /// Writes the session to `path`, which it belongs to from now on.
    ///
    /// # Errors
    /// A file that is looked at and is no session; what the system said.
    pub fn save(&mut self, path: &Path) -> Result<()> {
        kept::check(path, |path| Session::read(path).is_ok())?;
        self.session = self.session.clone().sealed();
        self.session.write(path)?;
        self.file = Some(path.to_owned());
        self.saved = Some(self.session.clone());
        Ok(())
    }

    /// Has a look at `time` seconds for what can be undone later.
    pub fn remember(&mut self, time: f64) {
        self.undoer.feed_state(time, &self.session.render);
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        self.undoer.has_undo(&self.session.render)
    }

    /// Whether there is something to do again.
    pub fn can_redo(&self) -> bool {
        self.undoer.has_redo(&self.session.render)
    }

    /// Goes back to before the last change.
    pub fn undo(&mut self) {
        if let Some(before) = self.undoer.undo(&self.session.render) {
            self.session.render = before.clone();
        }
    }

    /// Does again what was undone last.
    pub fn redo(&mut self) {
        if let Some(after) = self.undoer.redo(&self.session.render) {
            self.session.render = after.clone();
        }
    }

    /// The transfer function in force.
    ///
    /// # Errors
    /// What is wrong with the name or the file that the session gives.
    pub fn transfer_function(&self, volume: &OpenVolume) -> Result<TransferFunction> {
        presets::chosen(self.settings(), volume)
    }

    /// Takes another transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        let render = &mut self.session.render;
        render.tf = Some(presets::text(transfer));
        // It is over what is shown already.
        (render.tf_range, render.scale) = (None, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        Document::new("head", VolumeSettings::default(), RenderSettings::default()).unwrap()
    }

    /// As if a second had passed after each of `changes`.
    fn changed(document: &mut Document, changes: &[f64]) {
        document.remember(0.0);
        for (i, &ambient) in changes.iter().enumerate() {
            document.settings_mut().ambient = Some(ambient);
            let time = 10.0 * (i + 1) as f64;
            document.remember(time);
            document.remember(time + 5.0);
        }
    }

    #[test]
    fn changes_are_undone_and_done_again() {
        let mut document = document();
        changed(&mut document, &[0.1, 0.2]);
        assert!(document.can_undo() && !document.can_redo());
        document.undo();
        assert_eq!(document.settings().ambient, Some(0.1));
        document.undo();
        assert_eq!(document.settings().ambient, None);
        assert!(document.can_redo());
        document.redo();
        document.redo();
        assert_eq!(document.settings().ambient, Some(0.2));
    }

    #[test]
    fn what_no_file_has_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a session.toml");
        let mut document = document();
        assert!(!document.is_changed());
        document.settings_mut().camera = Some([1.0, 0.5, 1.5, 0.0, 0.0, 0.0, 35.0]);
        assert!(document.is_changed() && !document.has_unsaved_work(), "a look is no work");
        document.settings_mut().step = Some(0.7);
        assert!(document.is_changed() && document.has_unsaved_work());
        document.save(&path).unwrap();
        assert!(!document.is_changed());
        assert_eq!(document.name(), "a session.toml");
        let opened = Document::open(&path, VolumeSettings::default(), RenderSettings::default()).unwrap();
        assert_eq!(opened.session(), document.session());
        document.save(&path).unwrap();
        let restored = Document::restored(opened.session().clone());
        assert!(restored.is_changed() && restored.has_unsaved_work());
    }

    #[test]
    fn the_volume_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let volume = folder.path().join("v_2x2x2_uint8.raw");
        std::fs::write(&volume, [7; 8]).unwrap();
        let source = volume.display().to_string();
        let mut document =
            Document::new(&source, VolumeSettings::default(), RenderSettings::default()).unwrap();
        let error = document.save(&volume).unwrap_err().to_string();
        assert!(error.contains("another name"), "{error}");
        assert_eq!(std::fs::read(&volume).unwrap(), [7; 8]);
    }
}
