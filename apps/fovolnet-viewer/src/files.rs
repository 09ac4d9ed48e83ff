//! Asking for the name of a file.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

/// What a file is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A volume or a session to open.
    Open,
    /// A session to save.
    SaveSession,
    /// A picture to write.
    SavePicture,
    /// A clip to write.
    SaveVideo,
    /// A transfer function to read.
    ReadTransfer,
    /// A transfer function to write.
    SaveTransfer,
}

impl Purpose {
    /// The title of a dialogue.
    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open a volume or a session",
            Self::SaveSession => "Save the session",
            Self::SavePicture => "Export a picture",
            Self::SaveVideo => "Export a video",
            Self::ReadTransfer => "Read a transfer function",
            Self::SaveTransfer => "Save the transfer function",
        }
    }

    /// What the names of such files end in, the usual first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Open => &[],
            Self::SaveSession => &["toml"],
            Self::SavePicture => &["png"],
            Self::SaveVideo => &["mp4", "y4m", "webm", "mkv", "gif"],
            Self::ReadTransfer => &["json", "itf"],
            Self::SaveTransfer => &["json"],
        }
    }

    /// Whether the file is there already.
    pub fn reads(self) -> bool {
        matches!(self, Self::Open | Self::ReadTransfer)
    }
}

/// Shows the system's own dialogue; what was chosen comes through the receiver, nothing where it was closed or the system has
/// none.
pub fn browse(
    purpose: Purpose,
    suggested: PathBuf,
    wake: impl FnOnce() + Send + 'static,
) -> Receiver<PathBuf> {
    let (send, chosen) = channel();
    let ask = move || {
        let mut dialogue = rfd::FileDialog::new().set_title(purpose.title());
        if let Some(folder) = suggested.parent().filter(|folder| folder.is_dir()) {
            dialogue = dialogue.set_directory(folder);
        }
        if let Some(name) = suggested.file_name().filter(|_| !purpose.reads()) {
            dialogue = dialogue.set_file_name(name.to_string_lossy());
        }
        if !purpose.extensions().is_empty() {
            dialogue = dialogue.add_filter(purpose.title(), purpose.extensions());
        }
        let path = if purpose.reads() { dialogue.pick_file() } else { dialogue.save_file() };
        if let Some(path) = path {
            // Nobody may be there any more.
            let _ = send.send(path);
        }
        wake();
    };
    // Without a thread there is no dialogue, as on systems that have none.
    let _ = std::thread::Builder::new().name("dialogue".into()).spawn(ask);
    chosen
}
