//! Answers of dialogues.

use crate::session::export::Export;
use crate::ui::dialogues::files::Purpose;
use fovolnet::{Session, VolumeSettings};
use std::path::PathBuf;

/// Action that waits for a dialogue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    /// Open this source.
    Open(String),
    /// Close the session.
    Close,
    /// End the viewer.
    Quit,
}

/// Answer of a dialogue.
#[derive(Debug, PartialEq)]
pub enum Answer {
    /// Cancel.
    Cancel,
    /// The chosen file and its purpose.
    File(Purpose, PathBuf),
    /// Start this export.
    Export(Box<Export>),
    /// Save the session, then continue.
    Save(Next),
    /// Discard the changes and continue.
    Discard(Next),
    /// Open this file with these settings.
    Layout(String, Box<VolumeSettings>),
    /// Delete the autosave.
    Forget,
    /// Restore this session.
    Restore(Box<Session>),
    /// Drop the export and end the viewer.
    Leave,
}
