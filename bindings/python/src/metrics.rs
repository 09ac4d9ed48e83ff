//! Quality of pictures.

use crate::errors::raised;
use crate::pictures::frame_of;
use fovolnet::metrics::{self, SsimSettings};
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;

/// Peak signal-to-noise ratio of two pictures in dB: float32 of shape (height, width, 3 or 4), 0 to 1.
#[pyfunction]
fn psnr(reference: PyReadonlyArrayDyn<'_, f32>, test: PyReadonlyArrayDyn<'_, f32>) -> PyResult<f64> {
    metrics::psnr(&frame_of(&reference)?, &frame_of(&test)?).map_err(|error| raised(&error))
}

/// Structural similarity of two pictures, with the Gaussian window of its authors.
#[pyfunction]
fn ssim(reference: PyReadonlyArrayDyn<'_, f32>, test: PyReadonlyArrayDyn<'_, f32>) -> PyResult<f64> {
    let settings = SsimSettings::gaussian();
    metrics::ssim(&frame_of(&reference)?, &frame_of(&test)?, &settings).map_err(|error| raised(&error))
}

pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(psnr, module)?)?;
    module.add_function(wrap_pyfunction!(ssim, module)?)
}
