use crate::errors::{raised, wrong};
use crate::interrupts::interruptible;
use crate::pictures::{picture, samples_of};
use crate::settings;
use fovolnet::Reconstructor as Inner;
use fovolnet::core::FrameSize;
use numpy::{PyArray3, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Reconstructs the sparse frames of one clip, of any renderer. Networks remember earlier frames.
#[pyclass(frozen, module = "fovolnet")]
pub struct Reconstructor {
    inner: Mutex<Inner>,
    size: FrameSize,
}

#[pymethods]
impl Reconstructor {
    /// A reconstructor of frames of `width` by `height` pixels. `settings` is a JSON object with the names of the command line's
    /// flags.
    #[new]
    #[pyo3(signature = (width, height, settings = "{}"))]
    fn new(py: Python<'_>, width: u32, height: u32, settings: &str) -> PyResult<Self> {
        let size = FrameSize::new(width, height).map_err(|error| raised(&error))?;
        let settings = settings::of_pictures(settings)?;
        let inner = interruptible(py, || Inner::new(&settings, size))?.map_err(|error| raised(&error))?;
        Ok(Self { inner: Mutex::new(inner), size })
    }

    /// Reconstructs the next frame of the clip: `colours` is float32 of shape (height, width, 3), 0 to 1; `mask`, bool of shape
    /// (height, width), says which of them count; `motion`, float32 of shape (height, width, 2), is the way of each pixel to its place
    /// in the last frame. Returns float32 of shape (height, width, 4).
    #[pyo3(signature = (colours, mask, motion = None))]
    fn reconstruct<'py>(
        &self,
        py: Python<'py>,
        colours: PyReadonlyArrayDyn<'py, f32>,
        mask: PyReadonlyArrayDyn<'py, bool>,
        motion: Option<PyReadonlyArrayDyn<'py, f32>>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let sparse = samples_of(&colours, &mask)?;
        let [height, width] = [self.size.height as usize, self.size.width as usize];
        let motion = motion
            .map(|motion| {
                if motion.shape() != [height, width, 2] {
                    let shape = motion.shape();
                    return Err(wrong(format!(
                        "motion has the shape ({height}, {width}, 2) here, not {shape:?}"
                    )));
                }
                let numbers = motion
                    .as_slice()
                    .map_err(|_| wrong("motion lies in C order; use numpy.ascontiguousarray"))?;
                Ok(numbers.chunks_exact(2).map(|way| [way[0], way[1]]).collect::<Vec<_>>())
            })
            .transpose()?;
        let frame = interruptible(py, || {
            self.inner.lock().unwrap_or_else(PoisonError::into_inner).reconstruct(&sparse, motion.as_deref())
        })?
        .map_err(|error| raised(&error))?;
        picture(py, frame.size(), 4, frame.pixels().iter().flatten().copied().collect())
    }

    /// Forgets earlier frames, as after a cut.
    fn reset(&self) {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).reset();
    }

    /// Whether it uses the motion of pixels.
    #[getter]
    fn uses_motion(&self) -> bool {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).uses_motion()
    }
}
