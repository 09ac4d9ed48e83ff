use std::path::PathBuf;

/// What networks and their weights can be wrong about, in one line that says how to mend it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read or written.
    #[error("cannot {verb} {path}: {source}; check the path and its permissions")]
    Io {
        /// What was tried.
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A weights file that cannot be understood.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and how to mend it.
        problem: String,
    },
    /// Weights that do not fit a network.
    #[error(
        "the weights do not fit the network: {0}; take weights of this network, or its configuration from them"
    )]
    Weights(String),
    /// A configuration that makes no network.
    #[error("{0}")]
    Config(String),
    /// A state that cannot be used.
    #[error("the state of the network cannot be used: {0}")]
    State(String),
    /// A frame that cannot be.
    #[error(transparent)]
    Frame(#[from] fovol_core::Error),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] fovol_core::memory::Shortage),
    /// A device that does not do it.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] fovol_gpu::GpuError),
}

/// What can fail here.
pub type Result<T> = std::result::Result<T, Error>;
