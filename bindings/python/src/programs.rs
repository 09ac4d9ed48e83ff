//! The programs of the project, which the package carries.

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command `fovolnet` with `arguments`, the first of which is the program, and returns its exit status.
///
/// It is meant for a process of its own: it listens to signals, and changes the limits of the process.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| fovolnet_cli::run(arguments))
}

/// Runs the command `fovolnet-viewer` with `arguments`, the first of which is the program, and returns its exit status.
///
/// It is meant for the first thread of a process of its own, for the same reasons.
#[pyfunction]
pub fn run_viewer(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| fovolnet_viewer::run(arguments))
}
