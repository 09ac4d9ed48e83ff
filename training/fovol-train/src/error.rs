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
    /// Something that libtorch refuses.
    #[error("libtorch: {0}")]
    Torch(#[from] tch::TchError),
}

/// What can fail here.
pub type Result<T> = std::result::Result<T, Error>;
