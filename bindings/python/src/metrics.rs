//! Quality of pictures and clips.

use crate::errors::raised;
use crate::interrupts::interruptible;
use crate::pictures::frame_of;
use fovolnet::core::Frame;
use fovolnet::metrics::{self, ColorVideoVdp, Display, FovVideoVdp, SsimSettings};
use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

type Pictures<'py> = PyReadonlyArrayDyn<'py, f32>;

/// Compares two pictures without the interpreter's lock.
fn compared(
    py: Python<'_>,
    [a, b]: [&Pictures<'_>; 2],
    metric: impl FnOnce(&Frame, &Frame) -> metrics::Result<f64> + Send,
) -> PyResult<f64> {
    let (a, b) = (frame_of(a)?, frame_of(b)?);
    interruptible(py, || metric(&a, &b))?.map_err(|error| raised(&error))
}

/// Peak signal-to-noise ratio of two pictures in dB: float32 of shape (height, width, 3 or 4), 0 to 1.
#[pyfunction]
pub fn psnr(py: Python<'_>, reference: Pictures<'_>, test: Pictures<'_>) -> PyResult<f64> {
    compared(py, [&reference, &test], metrics::psnr)
}

/// Structural similarity of two pictures, with the Gaussian window of its authors.
#[pyfunction]
pub fn ssim(py: Python<'_>, reference: Pictures<'_>, test: Pictures<'_>) -> PyResult<f64> {
    compared(py, [&reference, &test], |a, b| metrics::ssim(a, b, &SsimSettings::gaussian()))
}

/// Structural similarity of two pictures at five resolutions.
#[pyfunction]
pub fn ms_ssim(py: Python<'_>, reference: Pictures<'_>, test: Pictures<'_>) -> PyResult<f64> {
    compared(py, [&reference, &test], metrics::ms_ssim)
}

/// Temporal PSNR of two pairs of neighbouring frames in dB.
#[pyfunction]
pub fn tpsnr(
    py: Python<'_>,
    reference: (Pictures<'_>, Pictures<'_>),
    test: (Pictures<'_>, Pictures<'_>),
) -> PyResult<f64> {
    let reference = [frame_of(&reference.0)?, frame_of(&reference.1)?];
    let test = [frame_of(&test.0)?, frame_of(&test.1)?];
    interruptible(py, || metrics::tpsnr(reference.each_ref(), test.each_ref()))?
        .map_err(|error| raised(&error))
}

enum Judge {
    Light(Box<FovVideoVdp>),
    Colour(Box<ColorVideoVdp>),
}

/// Just-objectionable differences of a clip, frame by frame: FovVideoVDP, or ColorVideoVDP where colours count.
#[pyclass(frozen, module = "fovolnet")]
pub struct Jod(Mutex<Judge>);

#[pymethods]
impl Jod {
    /// A judge of clips with `fps` frames a second on the display `display`; of one still picture where `fps` is None.
    #[new]
    fn new(display: &str, fps: Option<f64>, colour: bool) -> PyResult<Self> {
        let judge = || -> metrics::Result<Judge> {
            let display = Display::named(display)?;
            Ok(match (colour, fps) {
                (false, Some(fps)) => Judge::Light(Box::new(FovVideoVdp::video(&display, fps)?)),
                (false, None) => Judge::Light(Box::new(FovVideoVdp::image(&display)?)),
                (true, Some(fps)) => Judge::Colour(Box::new(ColorVideoVdp::video(&display, fps)?)),
                (true, None) => Judge::Colour(Box::new(ColorVideoVdp::image(&display)?)),
            })
        };
        judge().map(|judge| Self(Mutex::new(judge))).map_err(|error| raised(&error))
    }

    /// Looks at the next frame of both clips; `gaze` is where the eye looks, as fractions of the frame from its top left.
    #[pyo3(signature = (reference, test, gaze = None))]
    fn push(
        &self,
        py: Python<'_>,
        reference: Pictures<'_>,
        test: Pictures<'_>,
        gaze: Option<[f64; 2]>,
    ) -> PyResult<()> {
        let (a, b) = (frame_of(&reference)?, frame_of(&test)?);
        interruptible(py, || match &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Judge::Light(judge) => judge.push(&a, &b, gaze),
            Judge::Colour(judge) => judge.push(&a, &b),
        })?
        .map_err(|error| raised(&error))
    }

    /// JOD of the frames so far: 10 where no difference can be seen, lower the more it disturbs. None without frames.
    fn value(&self) -> Option<f64> {
        match &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Judge::Light(judge) => judge.jod(),
            Judge::Colour(judge) => judge.jod(),
        }
    }
}
