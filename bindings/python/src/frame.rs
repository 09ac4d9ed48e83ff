use crate::interrupts::check_process;
use crate::pictures::{picture, plane, sampled};
use fovolnet::RenderedFrame;
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A rendered frame.
///
/// Arrays are made anew at every access: keep them where they are needed more than once.
#[pyclass(frozen, module = "fovolnet")]
pub struct Frame(pub RenderedFrame);

#[pymethods]
impl Frame {
    /// Number of the frame.
    #[getter]
    fn index(&self) -> u32 {
        self.0.index
    }

    /// Height and width in pixels.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        let size = self.0.frame.size();
        (size.height, size.width)
    }

    /// The picture: uint8 of shape (height, width, 3), display colours.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        check_process()?;
        picture(py, self.0.frame.size(), 3, self.0.frame.to_rgb8())
    }

    /// The picture with opacity: uint8 of shape (height, width, 4), colours not premultiplied.
    #[getter]
    fn image_rgba<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        check_process()?;
        picture(py, self.0.frame.size(), 4, self.0.frame.to_rgba8())
    }

    /// The picture: float32 of shape (height, width, 4), display colours 0 to 1 and opacity.
    #[getter]
    fn rgba<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let numbers = self.0.frame.pixels().iter().flatten().copied().collect();
        picture(py, self.0.frame.size(), 4, numbers)
    }

    /// Colours of the marched pixels: float32 of shape (height, width, 4); zeros elsewhere, alpha 1 where marched.
    #[getter]
    fn sparse<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let frame = self.0.samples_picture();
        picture(py, frame.size(), 4, frame.pixels().iter().flatten().copied().collect())
    }

    /// Which pixels were marched: bool of shape (height, width).
    #[getter]
    fn mask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<bool>>> {
        plane(py, self.0.mask.size(), sampled(&self.0.mask))
    }

    /// Distances of the marched pixels from the eye: float32 of shape (height, width), in world units, in which the longest side of
    /// the volume is 1; infinite elsewhere and where nothing shows. None if every pixel was marched.
    #[getter]
    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let Some(sparse) = &self.0.sparse else { return Ok(None) };
        let size = sparse.size();
        let mut depths = vec![f32::INFINITY; size.pixels()];
        for (pixel, depth) in sparse.pixels().iter().zip(sparse.depths()) {
            depths[usize::from(pixel.y) * size.width as usize + usize::from(pixel.x)] = *depth;
        }
        plane(py, size, depths).map(Some)
    }

    /// Way of each pixel to its place in the last frame: float32 of shape (height, width, 2), right and down. None for the first
    /// frame, and unless a network uses it.
    #[getter]
    fn motion<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let Some(motion) = &self.0.motion else { return Ok(None) };
        picture(py, self.0.frame.size(), 2, motion.iter().flatten().copied().collect()).map(Some)
    }

    /// Number of marched pixels, repeated ones included.
    #[getter]
    fn samples(&self) -> usize {
        self.0.samples
    }

    /// Share of the pixels that were marched.
    #[getter]
    fn density(&self) -> f64 {
        self.0.samples as f64 / self.0.frame.size().pixels() as f64
    }

    /// Times of the stages in milliseconds: a dict from their names, and the total.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let times = PyDict::new(py);
        for (stage, ms) in self
            .0
            .timings
            .finer()
            .into_iter()
            .chain([("plan", self.0.timings.plan), ("total", self.0.timings.total)])
        {
            times.set_item(stage, ms)?;
        }
        Ok(times)
    }

    fn __repr__(&self) -> String {
        let size = self.0.frame.size();
        format!("<fovolnet.Frame {} of {size}, density {:.4}>", self.0.index, self.density())
    }
}
