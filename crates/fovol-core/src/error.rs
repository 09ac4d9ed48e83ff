use crate::memory;

/// Errors of the basic types.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Grid, frame or other extent that is empty or absurdly large.
    #[error("{what} is {found}, expected {expected}")]
    Extent {
        /// The measured quantity.
        what: String,
        /// The value found.
        found: String,
        /// The accepted values.
        expected: String,
    },
    /// Number that is not finite or lies outside its interval.
    #[error("{name} is {value}, expected {expected}")]
    Value {
        /// Name of the parameter.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The accepted values.
        expected: &'static str,
    },
    /// Fewer bytes than dimensions and type need.
    #[error(
        "the volume needs {needed} bytes for its dimensions and type, only {found} are there; check dims and dtype"
    )]
    TooFewBytes {
        /// Bytes that dims × components × type need.
        needed: u64,
        /// Bytes present.
        found: u64,
    },
    /// Transfer function that cannot be evaluated.
    #[error("transfer function: {0}")]
    TransferFunction(String),
    /// Camera path or keyframe that cannot be followed.
    #[error("camera path: {0}")]
    CameraPath(String),
    /// Several volumes that cannot be shown together.
    #[error("volumes at the same points: {0}")]
    Layers(String),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] memory::Shortage),
}

/// Result with the errors of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Returns `value` if it is finite and `ok`, else an [`Error::Value`].
pub fn checked(name: &'static str, value: f64, expected: &'static str, ok: bool) -> Result<f64> {
    if value.is_finite() && ok { Ok(value) } else { Err(Error::Value { name, value, expected }) }
}
