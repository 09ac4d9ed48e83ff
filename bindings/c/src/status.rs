use fovolnet::{Error, one_line};

/// Result of a call: FOVOLNET_OK, or the kind of the error. fovolnet_last_error has its text.
pub type FovolnetStatus = i32;

/// Success.
pub const FOVOLNET_OK: FovolnetStatus = 0;
/// A null pointer, a wrong size, an unknown name, a setting that cannot be used, or too little memory.
pub const FOVOLNET_ERROR_INVALID: FovolnetStatus = 1;
/// A file that is missing, unreadable or broken.
pub const FOVOLNET_ERROR_FILE: FovolnetStatus = 2;
/// The graphics processor failed. The CPU may still work: set "device" to "cpu".
pub const FOVOLNET_ERROR_GPU: FovolnetStatus = 3;
/// fovolnet_cancel ended the call.
pub const FOVOLNET_CANCELLED: FovolnetStatus = 4;
/// The frame has no such channel.
pub const FOVOLNET_ABSENT: FovolnetStatus = 5;
/// A fault of the library. Please report it.
pub const FOVOLNET_ERROR_INTERNAL: FovolnetStatus = 6;

/// Code and text of a failed call.
#[derive(Debug)]
pub(crate) struct Failure {
    pub status: FovolnetStatus,
    pub text: String,
}

impl Failure {
    /// Failure of a wrong argument.
    pub fn invalid(text: impl Into<String>) -> Self {
        Self { status: FOVOLNET_ERROR_INVALID, text: text.into() }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Io(_) => FOVOLNET_ERROR_FILE,
            error if error.is_of_gpu() => FOVOLNET_ERROR_GPU,
            _ => FOVOLNET_ERROR_INVALID,
        };
        Self { status, text: one_line(&error) }
    }
}

impl From<fovolnet::core::Error> for Failure {
    fn from(error: fovolnet::core::Error) -> Self {
        Error::from(error).into()
    }
}
