/// Result of an operation on a GPU.
pub type Result<T> = std::result::Result<T, GpuError>;

/// Failure of an operation on a GPU.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter, or none that fits the request.
    #[error("no GPU can be used: {found}; {mend}")]
    NoAdapter {
        /// The adapters of this machine, as text.
        found: String,
        /// Advice to the user.
        mend: &'static str,
    },
    /// The environment names checks that do not exist.
    #[error("FOVOLNET_GPU_CHECKS: {0}")]
    Checks(String),
    /// A request exceeds a limit of the device.
    #[error("{what} needs {needed}, and this GPU allows {allowed} ({limit}); {mend}")]
    Limit {
        /// The thing that is too large.
        what: String,
        /// The amount that it needs.
        needed: u64,
        /// The amount that the device allows.
        allowed: u64,
        /// Name of the limit in WebGPU.
        limit: &'static str,
        /// Advice to the user.
        mend: &'static str,
    },
    /// The device has no memory left.
    #[error(
        "the GPU has no memory left while {doing}; close other programs, take a smaller --size, average voxels with --downsample 2, or use --device cpu"
    )]
    OutOfMemory {
        /// The operation that failed.
        doing: &'static str,
    },
    /// The driver refused a command.
    #[error("the GPU refused {doing}: {message}; update its driver, or use --device cpu")]
    Refused {
        /// The operation that failed.
        doing: &'static str,
        /// The driver's message, on one line.
        message: String,
    },
    /// The device is gone: reset by the driver, unplugged, or destroyed by its owner.
    #[error("the GPU was lost while {doing} ({message}); open it again, or use --device cpu")]
    Lost {
        /// The operation that failed.
        doing: &'static str,
        /// The reason, as far as it is known.
        message: String,
    },
}

impl GpuError {
    /// Makes a [`Self::Refused`] of the operation `doing`. `message` may have several lines; they are joined into
    /// one.
    pub fn refused(doing: &'static str, message: &str) -> Self {
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Refused { doing, message }
    }

    /// Checks that `needed` is at most `allowed`.
    ///
    /// # Errors
    /// [`Self::Limit`] where it is more.
    pub fn check_limit(
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
