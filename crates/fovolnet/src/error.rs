/// What can go wrong between the settings and a picture. Every message is one line: what, where, how to
/// mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file.
    #[error(transparent)]
    Io(#[from] fovol_io::Error),
    /// A number or extent.
    #[error(transparent)]
    Core(#[from] fovol_core::Error),
    /// A procedural volume.
    #[error(transparent)]
    Procedural(#[from] fovol_io::procedural::Error),
    /// Frames that cannot be compared.
    #[error(transparent)]
    Metrics(#[from] fovol_metrics::Error),
    /// A network or its weights.
    #[error(transparent)]
    Network(#[from] fovol_net::Error),
    /// A setting that makes no sense, with the reason and the remedy.
    #[error("{0}")]
    Setting(String),
}

/// The result of the operations of this crate.
pub type Result<T> = std::result::Result<T, Error>;
