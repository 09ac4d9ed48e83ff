/// Errors of training; each message is one line that says how to mend it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Configuration or weights that make no network.
    #[error(transparent)]
    Network(#[from] fovol_net::Error),
    /// Input tensors that do not fit the network or the loss.
    #[error("{0}")]
    Input(String),
    /// Saved state that does not belong to this run.
    #[error("the saved state cannot be used: {0}")]
    Saved(String),
    /// Clip that cannot be made or used.
    #[error("{0}")]
    Clip(String),
    /// File that cannot be read or written.
    #[error("cannot {action} {path}: {why}")]
    File {
        /// The attempted action.
        action: &'static str,
        /// The file.
        path: String,
        /// The reason.
        why: String,
    },
    /// Error of the renderer.
    #[error(transparent)]
    Render(#[from] fovolnet::Error),
    /// Scene parameters out of range.
    #[error(transparent)]
    Scene(#[from] fovol_core::Error),
    /// Settings that contradict each other.
    #[error("{0}")]
    Config(String),
    /// Training that diverged.
    #[error("{0}")]
    Diverged(String),
    /// Error of libtorch.
    #[error("libtorch: {0}")]
    Torch(#[from] tch::TchError),
}

impl Error {
    pub(crate) fn file(action: &'static str, path: &std::path::Path, why: &std::io::Error) -> Self {
        Self::File { action, path: path.display().to_string(), why: why.to_string() }
    }
}

impl From<fovolnet::io::Error> for Error {
    fn from(error: fovolnet::io::Error) -> Self {
        Self::Render(error.into())
    }
}

/// Result with the errors of training.
pub type Result<T> = std::result::Result<T, Error>;
