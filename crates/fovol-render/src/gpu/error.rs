use fovol_core::FrameSize;

/// The result of the operations of this module.
pub type Result<T> = std::result::Result<T, GpuError>;

/// What can go wrong with a GPU.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// Numbers of the scene that cannot be rendered with.
    #[error(transparent)]
    Scene(#[from] fovol_core::Error),
    /// No adapter is there, or none that was asked for.
    #[error("no GPU to render with: {found}; {mend}")]
    NoAdapter {
        /// What is there.
        found: String,
        /// What would help.
        mend: &'static str,
    },
    /// More than a device allows.
    #[error("{what} needs {needed}, and this GPU allows {allowed} ({limit}); {mend}")]
    Limit {
        /// What is too large.
        what: String,
        /// How much it needs.
        needed: u64,
        /// How much there may be.
        allowed: u64,
        /// The name of the limit in WebGPU.
        limit: &'static str,
        /// What would help.
        mend: &'static str,
    },
    /// A list of pixels of another frame.
    #[error("the list is for frames of {list}, the buffers are for {frame}; make both for one size")]
    Size {
        /// The size that the list is for.
        list: FrameSize,
        /// The size of the buffers.
        frame: FrameSize,
    },
    /// The device has no memory left.
    #[error(
        "the GPU has no memory left while {doing}; close other programs, take a smaller volume or frame, or --device cpu"
    )]
    OutOfMemory {
        /// What was being done.
        doing: &'static str,
    },
    /// The driver refused a command.
    #[error("the GPU refused {doing}: {message}; update its driver, or use --device cpu")]
    Refused {
        /// What was being done.
        doing: &'static str,
        /// What the driver said, on one line.
        message: String,
    },
    /// The device is gone: reset by the driver, unplugged, or destroyed by its owner.
    #[error("the GPU was lost while {doing} ({message}); open it again, or use --device cpu")]
    Lost {
        /// What was being done.
        doing: &'static str,
        /// What is known about it.
        message: String,
    },
}

impl GpuError {
    /// A driver's words, which may take many lines, on one.
    pub(super) fn refused(doing: &'static str, message: &str) -> Self {
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Refused { doing, message }
    }

    /// `Ok` where `needed` is within `allowed`.
    pub(super) fn check_limit(
        what: impl Into<String>,
        needed: u64,
        (limit, allowed): (&'static str, u64),
        mend: &'static str,
    ) -> Result<()> {
        if needed <= allowed {
            return Ok(());
        }
        Err(Self::Limit { what: what.into(), needed, allowed, limit, mend })
    }
}
