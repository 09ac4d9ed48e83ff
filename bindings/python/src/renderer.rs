use crate::errors::raised;
use crate::frame::Frame;
use crate::interrupts::interruptible;
use crate::pictures::{picture, plane};
use crate::settings;
use crate::volume::Volume;
use fovolnet::core::{Pixel, SampleList};
use fovolnet::{Engine, Freedom, OpenVolume, SpeedSettings, Wanted};
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Renders frames of a volume.
///
/// Its methods take settings as a JSON object with the names of the command line's flags. What these have in common with the last
/// ones stays.
#[pyclass(frozen, module = "fovolnet")]
pub struct Renderer {
    state: Mutex<State>,
    speed: SpeedSettings,
}

struct State {
    volume: Arc<OpenVolume>,
    engine: Engine,
}

impl Renderer {
    fn state<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs `work` with the engine and what the settings `given` ask of it, without the interpreter's lock. An engine whose work
    /// was interrupted begins anew.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        given: &str,
        finds_motion: bool,
        work: impl FnOnce(&mut Engine, Wanted) -> fovolnet::Result<T> + Send,
    ) -> PyResult<T> {
        let overrides = settings::overrides(given)?;
        let limit = overrides.limit().map_err(|error| raised(&error))?;
        // Frames have the size that was asked for: masks and samples belong to it.
        let planning = limit.map(|limit| (limit, Freedom { size: false, ..overrides.freedom() }));
        let settings = overrides.resolve().map_err(|error| raised(&error))?;
        let done = interruptible(py, || {
            self.state(|State { volume, engine }| {
                let volume = Arc::clone(volume);
                work(engine, Wanted { volume, settings, speed: self.speed.clone(), planning, finds_motion })
            })
        });
        if done.is_err() {
            py.detach(|| self.state(|state| state.engine.abandon()));
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
        let speed = settings::of_speed(device, threads)?;
        let state = State { volume: Arc::new(volume.opened.clone()), engine: Engine::default() };
        Ok(Self { state: Mutex::new(state), speed })
    }

    /// Shows another volume. Networks go on with what they have seen.
    fn show(&self, py: Python<'_>, volume: &Volume) {
        let volume = Arc::new(volume.opened.clone());
        py.detach(|| self.state(|state| state.volume = volume));
    }

    /// Renders frame `i`, seen by the camera of the settings or along their path. Frames have the motion of their pixels where
    /// `motion` is true.
    #[pyo3(signature = (settings, i = 0, motion = false))]
    fn render(&self, py: Python<'_>, settings: &str, i: u32, motion: bool) -> PyResult<Frame> {
        self.with(py, settings, motion, |engine, wanted| engine.render(wanted, i)).map(Frame)
    }

    /// Distance of every pixel of frame `i` from the eye, along its ray, to where its opacity passes one half; where it
    /// never does, the mean distance of what shows: float32 of shape (height, width), in world units; infinite where nothing shows.
    #[pyo3(signature = (settings, i = 0))]
    fn depth<'py>(&self, py: Python<'py>, settings: &str, i: u32) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (size, depths) = self.with(py, settings, false, |engine, wanted| {
            let pipeline = engine.pipeline(wanted)?;
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
        let frame = self.with(py, settings, false, |engine, wanted| engine.reference(wanted, i))?.frame;
        picture(py, frame.size(), 4, frame.pixels().iter().flatten().copied().collect())
    }

    /// The camera of frame `i`: eye, target, vertical field of view in degrees.
    #[pyo3(signature = (settings, i = 0))]
    fn camera(&self, py: Python<'_>, settings: &str, i: u32) -> PyResult<([f64; 3], [f64; 3], f64)> {
        self.with(py, settings, false, |engine, wanted| {
            let camera = engine.pipeline(wanted)?.camera(i);
            Ok((camera.eye.to_array(), camera.target.to_array(), camera.fovy))
        })
    }

    /// Forgets all earlier frames, as after a cut.
    fn reset(&self, py: Python<'_>) {
        py.detach(|| self.state(|state| state.engine.reset()));
    }

    /// Assumptions and omissions, one line each.
    fn notes(&self, py: Python<'_>, settings: &str) -> PyResult<Vec<String>> {
        self.with(py, settings, false, |engine, wanted| Ok(engine.pipeline(wanted)?.notes().to_vec()))
    }

    /// Name of the GPU that renders, or None where the processor does.
    fn gpu(&self, py: Python<'_>, settings: &str) -> PyResult<Option<String>> {
        self.with(py, settings, false, |engine, wanted| Ok(engine.pipeline(wanted)?.machine().gpu))
    }
}
