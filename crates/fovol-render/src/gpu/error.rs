use fovol_core::FrameSize;
use fovol_gpu::GpuError;

/// The result of the operations of this module.
pub type Result<T> = std::result::Result<T, Error>;

/// Errors of rendering on a GPU. Messages take one line and name the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene holds numbers that cannot be rendered.
    #[error(transparent)]
    Scene(#[from] fovol_core::Error),
    /// The device failed or lacks a capability.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The environment asks for a way to march that there is not.
    #[error("FOVOLNET_GPU_MARCH: {0}")]
    Strategy(String),
    /// The list is for frames of another size.
    #[error("the list is for frames of {list}, the buffers are for {frame}; make both for one size")]
    Size {
        /// The size that the list is for.
        list: FrameSize,
        /// The size of the buffers.
        frame: FrameSize,
    },
}
