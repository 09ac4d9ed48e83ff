use crate::errors::{raised, wrong};
use crate::frame::Frame;
use fovolnet::core::{FrameSize, path_of_text};
use fovolnet::io::video::{FrameRate, VideoWriter};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Writes a clip frame by frame. The file gets its name when it is finished.
#[pyclass(frozen, module = "fovolnet")]
pub struct Clip(Mutex<Option<VideoWriter>>);

impl Clip {
    fn with<T>(&self, work: impl FnOnce(&mut Option<VideoWriter>) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn closed() -> PyErr {
    wrong("the clip is finished; make another one")
}

#[pymethods]
impl Clip {
    /// Begins the clip `path` with frames of `width` by `height` pixels, `fps` a second (a number or a fraction, as text).
    #[new]
    fn new(path: &str, width: u32, height: u32, fps: &str) -> PyResult<Self> {
        let size = FrameSize::new(width, height).map_err(|error| raised(&error))?;
        let rate: FrameRate = fps.parse().map_err(wrong)?;
        let writer = VideoWriter::create(&path_of_text(path), size, rate).map_err(|error| raised(&error))?;
        Ok(Self(Mutex::new(Some(writer))))
    }

    /// Appends a frame.
    fn push(&self, py: Python<'_>, frame: &Frame) -> PyResult<()> {
        py.detach(|| self.with(|writer| writer.as_mut().map(|writer| writer.push(&frame.0.frame))))
            .ok_or_else(closed)?
            .map_err(|error| raised(&error))
    }

    /// Completes the clip and returns its path, which ends in .y4m where ffmpeg is needed and not installed.
    fn finish(&self, py: Python<'_>) -> PyResult<String> {
        let finished = py.detach(|| self.with(Option::take).map(VideoWriter::finish));
        let path = finished.ok_or_else(closed)?.map_err(|error| raised(&error))?;
        Ok(fovolnet::core::text_of_path(&path))
    }
}
