/// What training can be wrong about, in one line that says how to mend it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A configuration or weights that make no network.
    #[error(transparent)]
    Network(#[from] fovol_net::Error),
    /// Tensors that a network cannot be given.
    #[error("{0}")]
    Input(String),
    /// A saved state that does not belong here.
    #[error("the saved state cannot be used: {0}")]
    Saved(String),
    /// A clip that cannot be made or used.
    #[error("{0}")]
    Clip(String),
    /// A file that cannot be read or written.
    #[error("cannot {action} {path}: {why}")]
    File {
        /// What was tried.
        action: &'static str,
        /// On which file.
        path: String,
        /// Why it failed.
        why: String,
    },
    /// Something of the renderer.
    #[error(transparent)]
    Render(#[from] fovolnet::Error),
    /// Numbers that no scene has.
    #[error(transparent)]
    Scene(#[from] fovol_core::Error),
    /// Settings that do not fit together.
    #[error("{0}")]
    Config(String),
    /// A run that went astray.
    #[error("{0}")]
    Diverged(String),
    /// Something that libtorch refuses.
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

/// What can fail here.
pub type Result<T> = std::result::Result<T, Error>;
