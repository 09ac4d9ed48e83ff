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

/// Renders frames of a volume.
///
/// Its methods take settings as a JSON object with the names of the command line's flags. What these have in common with the last
/// ones stays.
#[pyclass(frozen, module = "fovolnet")]
pub struct Renderer(Mutex<State>);

struct State {
    volume: OpenVolume,
    speed: SpeedSettings,
    /// JSON of the last settings.
    given: String,
    /// None before the first frame, and after an interruption.
    pipeline: Option<Pipeline>,
}

impl State {
    /// The pipeline for `settings`, whose JSON is `given`.
    fn pipeline(&mut self, given: &str, settings: &RenderSettings) -> fovolnet::Result<&mut Pipeline> {
        match &mut self.pipeline {
            Some(pipeline) if self.given != given => pipeline.change(settings)?,
            Some(_) => {}
            empty => *empty = Some(Pipeline::new(&self.volume, settings, &self.speed)?),
        }
        given.clone_into(&mut self.given);
        Ok(self.pipeline.as_mut().expect("it was just made"))
    }
}

impl Renderer {
    /// Runs `work` with the pipeline for the settings `given`, without the interpreter's lock. A pipeline whose work was
    /// interrupted is made anew.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        given: &str,
        work: impl FnOnce(&mut Pipeline) -> fovolnet::Result<T> + Send,
    ) -> PyResult<T> {
        let settings = settings::of_pictures(given)?;
        let done = interruptible(py, || {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let result = state.pipeline(given, &settings).and_then(work);
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
    /// A renderer of `volume` on `device` with so many threads. It prepares the volume when it first renders.
    #[new]
    #[pyo3(signature = (volume, device = None, threads = None))]
    fn new(volume: &Volume, device: Option<&str>, threads: Option<usize>) -> PyResult<Self> {
        let device = device.map(|device| device.parse::<Device>().map_err(wrong)).transpose()?;
        let speed = SpeedSettings { device, threads, ..SpeedSettings::default() };
        let state = State { volume: volume.opened.clone(), speed, given: String::new(), pipeline: None };
        Ok(Self(Mutex::new(state)))
    }

    /// Shows another volume. Networks go on with what they have seen.
    fn show(&self, py: Python<'_>, volume: &Volume) -> PyResult<()> {
        let volume = volume.opened.clone();
        interruptible(py, || {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(pipeline) = &mut state.pipeline {
                pipeline.show(&volume)?;
            }
            state.volume = volume;
            Ok(())
        })?
        .map_err(|error: fovolnet::Error| raised(&error))
    }

    /// Renders frame `i`, seen by the camera of the settings or along their path; `gaze` is where the eye looks, as fractions of the
    /// frame from its top left. Frames have the motion of their pixels where `motion` is true.
    #[pyo3(signature = (settings, i = 0, gaze = None, motion = false))]
    fn render(
        &self,
        py: Python<'_>,
        settings: &str,
        i: u32,
        gaze: Option<[f64; 2]>,
        motion: bool,
    ) -> PyResult<Frame> {
        self.with(py, settings, |pipeline| {
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
    #[pyo3(signature = (settings, i = 0))]
    fn depth<'py>(&self, py: Python<'py>, settings: &str, i: u32) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (size, depths) = self.with(py, settings, |pipeline| {
            let (size, camera) = (pipeline.size(), pipeline.camera(i));
            let rows = 0..size.height as u16;
            let pixels = rows.flat_map(|y| (0..size.width as u16).map(move |x| Pixel { x, y })).collect();
            let rays = pipeline.march(&camera, &SampleList::new(size, pixels))?;
            Ok((size, rays.iter().map(|ray| ray.depth).collect()))
        })?;
        plane(py, size, depths)
    }

    /// Frame `i` with every pixel marched and exact shadows: float32 of shape (height, width, 4).
    #[pyo3(signature = (settings, i = 0))]
    fn reference<'py>(&self, py: Python<'py>, settings: &str, i: u32) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let frame = self.with(py, settings, |pipeline| pipeline.reference(i))?;
        picture(py, frame.size(), 4, frame.pixels().iter().flatten().copied().collect())
    }

    /// The camera of frame `i`: eye, target, vertical field of view in degrees.
    #[pyo3(signature = (settings, i = 0))]
    fn camera(&self, py: Python<'_>, settings: &str, i: u32) -> PyResult<([f64; 3], [f64; 3], f64)> {
        self.with(py, settings, |pipeline| {
            let camera = pipeline.camera(i);
            Ok((camera.eye.to_array(), camera.target.to_array(), camera.fovy))
        })
    }

    /// Forgets all earlier frames, as after a cut.
    fn reset(&self, py: Python<'_>) {
        py.detach(|| {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            state.pipeline.as_mut().into_iter().for_each(Pipeline::reset);
        });
    }

    /// Assumptions and omissions, one line each.
    fn notes(&self, py: Python<'_>, settings: &str) -> PyResult<Vec<String>> {
        self.with(py, settings, |pipeline| Ok(pipeline.notes().to_vec()))
    }

    /// Name of the GPU that renders, or None where the processor does.
    fn gpu(&self, py: Python<'_>, settings: &str) -> PyResult<Option<String>> {
        self.with(py, settings, |pipeline| Ok(pipeline.machine().gpu))
    }
}
