use std::path::PathBuf;

/// Errors of networks and their weights. Each message is one line that says how to mend the problem.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read or written.
    #[error("cannot {verb} {path}: {source}; check the path and its permissions")]
    Io {
        /// The attempted operation.
        verb: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A weights file that cannot be understood.
    #[error("{path}: {problem}")]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The problem and how to mend it.
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
    /// A frame of an impossible size.
    #[error(transparent)]
    Frame(#[from] fovol_core::Error),
    /// Too little memory.
    #[error(transparent)]
    Memory(#[from] fovol_core::memory::Shortage),
    /// An error of the GPU.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] fovol_gpu::GpuError),
}

/// Result of an operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;
