//! Document of the viewer: a session with its file and undo history.

use crate::session::kept;
use eframe::egui::util::undoer::Undoer;
use fovolnet::core::{TransferFunction, path_of_text};
use fovolnet::{OpenVolume, RenderOverrides, Result, Session, TransferChoice, VolumeSettings, presets};
use std::path::{Path, PathBuf};

/// Session with its file and undo history.
#[derive(Debug, Clone)]
pub struct Document {
    session: Session,
    /// Last saved state, or the initial state of a new session. `None` after a restore.
    saved: Option<Session>,
    file: Option<PathBuf>,
    undoer: Undoer<RenderOverrides>,
}

impl Document {
    /// New session of the volume `source`.
    ///
    /// # Errors
    /// Errors of reading the volume's file.
    pub fn new(source: &str, read: VolumeSettings, render: RenderOverrides) -> Result<Self> {
        Ok(Self::of(Session::new(source, read, render)?, None))
    }

    /// Opens the session file `path`; `read` and `over` override its settings.
    ///
    /// # Errors
    /// A file that is missing or has unknown content.
    pub fn open(path: &Path, read: VolumeSettings, over: RenderOverrides) -> Result<Self> {
        let mut session = Session::read(path)?;
        session.read = session.read.overridden_by(read);
        session.render = session.render.overridden_by(over);
        Ok(Self::of(session, Some(path.to_owned())))
    }

    /// Restored session of a crashed viewer, which has not been saved.
    pub fn restored(session: Session) -> Self {
        Self { saved: None, ..Self::of(session, None) }
    }

    fn of(session: Session, file: Option<PathBuf>) -> Self {
        Self { saved: Some(session.clone()), session, file, undoer: Undoer::default() }
    }

    /// The current session.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Render settings.
    pub fn settings(&self) -> &RenderOverrides {
        &self.session.render
    }

    /// Mutable render settings.
    pub fn settings_mut(&mut self) -> &mut RenderOverrides {
        &mut self.session.render
    }

    /// This document with other settings for reading its volume.
    #[must_use]
    pub fn reading(&self, read: VolumeSettings) -> Self {
        let mut changed = self.clone();
        changed.session.read = read;
        changed
    }

    /// File of the session.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Whether the session was restored after a crash and has not been saved.
    pub fn is_restored(&self) -> bool {
        self.saved.is_none()
    }

    /// Whether anything is unsaved.
    pub fn is_changed(&self) -> bool {
        self.saved.as_ref() != Some(&self.session)
    }

    /// Whether changes are unsaved that the user would miss. Camera and frame number do not count, since they are
    /// quickly found again.
    pub fn has_unsaved_work(&self) -> bool {
        let apart = |session: &Session| {
            let render = RenderOverrides { camera: None, first_frame: None, ..session.render.clone() };
            Session { render, ..session.clone() }
        };
        self.saved.as_ref().is_none_or(|saved| apart(saved) != apart(&self.session))
    }

    /// Name for the window title.
    pub fn name(&self) -> String {
        let path = self.file.clone().unwrap_or_else(|| path_of_text(&self.session.volume).into_owned());
        path.file_name().map_or_else(|| self.session.volume.clone(), |name| name.display().to_string())
    }

    /// Saves the session to `path`, which becomes its file.
    ///
    /// # Errors
    /// A file that was opened and is not a session; errors of the file system.
    pub fn save(&mut self, path: &Path) -> Result<()> {
        kept::check(path, |path| Session::read(path).is_ok())?;
        self.session = self.session.clone().sealed();
        self.session.write(path)?;
        self.file = Some(path.to_owned());
        self.saved = Some(self.session.clone());
        Ok(())
    }

    /// Records the state at `time` seconds in the undo history.
    pub fn remember(&mut self, time: f64) {
        self.undoer.feed_state(time, &self.session.render);
    }

    /// Whether there is a change to undo.
    pub fn can_undo(&self) -> bool {
        self.undoer.has_undo(&self.session.render)
    }

    /// Whether there is a change to redo.
    pub fn can_redo(&self) -> bool {
        self.undoer.has_redo(&self.session.render)
    }

    /// Undoes the last change.
    pub fn undo(&mut self) {
        if let Some(before) = self.undoer.undo(&self.session.render) {
            self.session.render = before.clone();
        }
    }

    /// Redoes the change that was undone last.
    pub fn redo(&mut self) {
        if let Some(after) = self.undoer.redo(&self.session.render) {
            self.session.render = after.clone();
        }
    }

    /// Current transfer function.
    ///
    /// # Errors
    /// The session's name or file of a transfer function is invalid.
    pub fn transfer_function(&self, volume: &OpenVolume) -> Result<TransferFunction> {
        // No other setting counts, and no file of another one is read.
        let RenderOverrides { tf, tf_range, scale, nan, .. } = self.settings().clone();
        let given = RenderOverrides { tf, tf_range, scale, nan, ..RenderOverrides::default() };
        presets::chosen(&given.resolve()?, volume)
    }

    /// Sets another transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        let render = &mut self.session.render;
        render.tf = Some(TransferChoice::Json(presets::text(transfer)));
        // The function already covers the displayed range.
        (render.tf_range, render.scale) = (None, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        Document::new("head", VolumeSettings::default(), RenderOverrides::default()).unwrap()
    }

    /// Applies `changes` as if some seconds passed after each.
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
        document.settings_mut().camera = Some([1.0, 0.5, 1.5, 0.0, 0.0, 0.0, 35.0].into());
        assert!(document.is_changed() && !document.has_unsaved_work(), "a look is no work");
        document.settings_mut().step = Some(0.7);
        assert!(document.is_changed() && document.has_unsaved_work());
        document.save(&path).unwrap();
        assert!(!document.is_changed());
        assert_eq!(document.name(), "a session.toml");
        let opened = Document::open(&path, VolumeSettings::default(), RenderOverrides::default()).unwrap();
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
            Document::new(&source, VolumeSettings::default(), RenderOverrides::default()).unwrap();
        let error = document.save(&volume).unwrap_err().to_string();
        assert!(error.contains("another name"), "{error}");
        assert_eq!(std::fs::read(&volume).unwrap(), [7; 8]);
    }
}
