use crate::errors::{raised, wrong};
use crate::frame::Frame;
use crate::interrupts::interruptible;
use crate::pictures::{picture, plane};
use crate::settings;
use crate::volume::Volume;
use fovolnet::core::{Fovea, Pixel, SampleList};
use fovolnet::{Device, OpenVolume, Pipeline, RenderSettings, SpeedSettings, Viewpoint};
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Renders frames of a volume with settings.
///
/// Settings are JSON objects with the names of the command line's flags.
#[pyclass(frozen, module = "fovolnet")]
pub struct Renderer(Mutex<State>);

struct State {
    volume: OpenVolume,
    settings: RenderSettings,
    speed: SpeedSettings,
    /// None after an interruption, until the next frame.
    pipeline: Option<Pipeline>,
}

impl State {
    fn pipeline(&mut self) -> fovolnet::Result<&mut Pipeline> {
        if self.pipeline.is_none() {
            self.pipeline = Some(Pipeline::new(&self.volume, &self.settings, &self.speed)?);
        }
        Ok(self.pipeline.as_mut().expect("it was just made"))
    }
}

impl Renderer {
    /// Runs `work` without the interpreter's lock. A pipeline whose work was interrupted is made anew.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State) -> fovolnet::Result<T> + Send,
    ) -> PyResult<T> {
        let done = interruptible(py, || {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let result = work(&mut state);
            drop(state);
            result
        });
        if done.is_err() {
            py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).pipeline = None);
        }
        done?.map_err(|error| raised(&error))
    }
}

#[pymethods]
impl Renderer {
    #[new]
    #[pyo3(signature = (volume, settings = "{}", device = None, threads = None))]
    fn new(
        py: Python<'_>,
        volume: &Volume,
        settings: &str,
        device: Option<&str>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let settings = settings::of_pictures(settings)?;
        let device = device.map(|device| device.parse::<Device>().map_err(wrong)).transpose()?;
        let speed = SpeedSettings { device, threads, ..SpeedSettings::default() };
        let state = State { volume: volume.opened.clone(), settings, speed, pipeline: None };
        let renderer = Self(Mutex::new(state));
        renderer.with(py, |state| state.pipeline().map(|_| ()))?;
        Ok(renderer)
    }

    /// Takes other settings; what both have in common stays.
    fn change(&self, py: Python<'_>, settings: &str) -> PyResult<()> {
        let settings = settings::of_pictures(settings)?;
        self.with(py, |state| {
            state.pipeline()?.change(&settings)?;
            state.settings = settings;
            Ok(())
        })
    }

    /// Shows another volume with the same settings. Networks go on with what they have seen.
    fn show(&self, py: Python<'_>, volume: &Volume) -> PyResult<()> {
        let volume = volume.opened.clone();
        self.with(py, |state| {
            state.pipeline()?.show(&volume)?;
            state.volume = volume;
            Ok(())
        })
    }

    /// Renders frame `i`, seen by the camera of the settings or along their path; `gaze` is where the eye looks, as fractions of the
    /// frame from its top left. Frames have the motion of their pixels where `motion` is true.
    #[pyo3(signature = (i = 0, gaze = None, motion = false))]
    fn render(&self, py: Python<'_>, i: u32, gaze: Option<[f64; 2]>, motion: bool) -> PyResult<Frame> {
        self.with(py, |state| {
            let pipeline = state.pipeline()?;
            if motion {
                pipeline.find_motion();
            }
            let Some(gaze) = gaze else { return pipeline.render(i) };
            let fovea = Fovea { gaze, ..pipeline.fovea(i) };
            fovea.check()?;
            pipeline.render_from(i, &Viewpoint { camera: pipeline.camera(i), fovea })
        })
        .map(Frame)
    }

    /// Distance of every pixel of frame `i` from the eye, along its ray, to where its opacity passes one half: float32 of shape
    /// (height, width), in world units; infinite where it never does.
    #[pyo3(signature = (i = 0))]
    fn depth<'py>(&self, py: Python<'py>, i: u32) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (size, depths) = self.with(py, |state| {
            let pipeline = state.pipeline()?;
            let (size, camera) = (pipeline.size(), pipeline.camera(i));
            let rows = 0..size.height as u16;
            let pixels = rows.flat_map(|y| (0..size.width as u16).map(move |x| Pixel { x, y })).collect();
            let rays = pipeline.march(&camera, &SampleList::new(size, pixels))?;
            Ok((size, rays.iter().map(|ray| ray.depth).collect()))
        })?;
        plane(py, size, depths)
    }

    /// Frame `i` with every pixel marched and exact shadows: float32 of shape (height, width, 4).
    #[pyo3(signature = (i = 0))]
    fn reference<'py>(&self, py: Python<'py>, i: u32) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let frame = self.with(py, |state| state.pipeline()?.reference(i))?;
        picture(py, frame.size(), 4, frame.pixels().iter().flatten().copied().collect())
    }

    /// The camera of frame `i`: eye, target, vertical field of view in degrees.
    #[pyo3(signature = (i = 0))]
    fn camera(&self, py: Python<'_>, i: u32) -> PyResult<([f64; 3], [f64; 3], f64)> {
        self.with(py, |state| {
            let camera = state.pipeline()?.camera(i);
            Ok((camera.eye.to_array(), camera.target.to_array(), camera.fovy))
        })
    }

    /// Forgets all earlier frames, as after a cut.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |state| {
            state.pipeline()?.reset();
            Ok(())
        })
    }

    /// Assumptions and omissions, one line each.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |state| Ok(state.pipeline()?.notes().to_vec()))
    }

    /// Name of the GPU that renders, or None where the processor does.
    #[getter]
    fn gpu(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.with(py, |state| Ok(state.pipeline()?.machine().gpu))
    }

    /// Width and height of frames in pixels.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<(u32, u32)> {
        self.with(py, |state| {
            let size = state.pipeline()?.size();
            Ok((size.width, size.height))
        })
    }
}
