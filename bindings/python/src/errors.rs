use fovolnet::one_line;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use std::error::Error;

pyo3::create_exception!(
    fovolnet,
    FovolnetError,
    PyValueError,
    "Something cannot be read or rendered. The message is one line that says what is wrong, where, and how to mend it."
);

/// The exception for `error` of the library.
pub fn raised(error: &(dyn Error + 'static)) -> PyErr {
    FovolnetError::new_err(one_line(error))
}

/// The exception for a wrong argument.
pub fn wrong(message: impl Into<String>) -> PyErr {
    FovolnetError::new_err(message.into())
}

/// The exception for work that Ctrl-C ended.
pub fn interrupted() -> PyErr {
    PyKeyboardInterrupt::new_err(())
}
