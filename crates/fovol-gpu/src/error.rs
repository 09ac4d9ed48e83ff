/// What can fail on a GPU.
pub type Result<T> = std::result::Result<T, GpuError>;

/// What can go wrong with a GPU.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter is there, or none that was asked for.
    #[error("no GPU can be used: {found}; {mend}")]
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
    /// The device has no memory left.
    #[error(
        "the GPU has no memory left while {doing}; close other programs, take a smaller --size, average voxels with --downsample 2, or use --device cpu"
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
    /// That the driver refused what it was `doing`, with its words, which may take many lines, on one.
    pub fn refused(doing: &'static str, message: &str) -> Self {
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Refused { doing, message }
    }

    /// `Ok` where `needed` is within `allowed`.
    /// # Errors
    /// [`Self::Limit`] where it is not.
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
