//! File dialogues of the system.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};

/// Purpose of a file.
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
    /// Title of the dialogue.
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

    /// File name extensions, the default first.
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

    /// Whether the file is an input.
    pub fn reads(self) -> bool {
        matches!(self, Self::Open | Self::ReadTransfer)
    }
}

/// Opens the system's file dialogue on a thread. The chosen file arrives through the receiver; nothing arrives if the
/// dialogue was closed or the system has none.
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
            // The receiver may be gone.
            let _ = send.send(path);
        }
        wake();
    };
    // If no thread can be started, there is no dialogue, as on systems that have none.
    let _ = std::thread::Builder::new().name("dialogue".into()).spawn(ask);
    chosen
}
