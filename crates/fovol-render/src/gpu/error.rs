use fovol_core::FrameSize;
use fovol_gpu::GpuError;

/// The result of the operations of this module.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong with rendering on a GPU, in one line that says how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Numbers of the scene that cannot be rendered with.
    #[error(transparent)]
    Scene(#[from] fovol_core::Error),
    /// The device does not do it.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A list of pixels of another frame.
    #[error("the list is for frames of {list}, the buffers are for {frame}; make both for one size")]
    Size {
        /// The size that the list is for.
        list: FrameSize,
        /// The size of the buffers.
        frame: FrameSize,
    },
}
