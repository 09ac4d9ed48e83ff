use crate::encoding::Encoding;
use crate::errors::{interrupted, raised, wrong};
use crate::interrupts::check_process;
use crate::refinement::Refinement;
use crate::settings;
use crate::volume::Volume;
use fovolnet::core::{Camera, Fovea, Frame, FrameSize, ShadowMode, stop};
use fovolnet::io::image::resized;
use fovolnet::{
    Candidate, Error, Freedom, Limit, MadeFrame, OpenVolume, Pipeline, Planner, RenderSettings, Sampling,
    Shown, SpeedSettings, Viewpoint, Way, WorldBox, camera_path, scene,
};
use numpy::PyArray3;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Eye, target, and vertical field of view in degrees.
type Eye = ([f64; 3], [f64; 3], f64);

/// Makes the pictures of an interactive view: frames within a budget while it moves, then the full frame piece by piece.
///
/// It works on the calling thread without the interpreter's lock, and does not look for signals: call it from a thread of its own.
#[pyclass(frozen, module = "fovolnet")]
pub struct FrameProducer(Mutex<State>);

struct State {
    volume: OpenVolume,
    asked: RenderSettings,
    freedom: Freedom,
    speed: SpeedSettings,
    planner: Planner,
    next_frame: u32,
    /// None before the first picture, and after an interruption or an error of a device.
    pipeline: Option<Pipeline>,
    view: Option<View>,
}

/// The current picture.
struct View {
    camera: Camera,
    picture: Picture,
}

enum Picture {
    /// Frame as it was made, perhaps smaller than asked for, and whether it is the full frame.
    Moving(Frame, bool),
    Resting(Box<Refinement>),
}

impl Picture {
    fn frame(&self) -> &Frame {
        match self {
            Self::Moving(frame, _) => frame,
            Self::Resting(refinement) => refinement.picture(),
        }
    }

    /// Share of the pixels that are as in the full frame.
    fn share(&self) -> f64 {
        match self {
            Self::Moving(_, is_full) => f64::from(u8::from(*is_full)),
            Self::Resting(refinement) => refinement.share(),
        }
    }
}

/// How a frame in motion was made.
struct Made {
    size: FrameSize,
    way: &'static str,
    ms: f64,
}

impl State {
    /// Pipeline with `settings`, and whether light, colours or clip are others than before.
    fn change(&mut self, settings: &RenderSettings) -> fovolnet::Result<bool> {
        match &mut self.pipeline {
            Some(pipeline) => pipeline.change_scene(settings),
            None => {
                self.planner = Planner::new();
                self.pipeline = Some(Pipeline::new(&self.volume, settings, &self.speed)?);
                Ok(false)
            }
        }
    }

    fn open(&mut self) -> &mut Pipeline {
        self.pipeline.as_mut().expect("it was just changed")
    }

    /// Makes a frame of a view in motion in about `budget` milliseconds.
    fn go_to(&mut self, camera: Camera, fovea: Fovea, budget: f64) -> fovolnet::Result<Made> {
        let started = Instant::now();
        let asked = self.asked.clone();
        let viewpoint = Viewpoint { camera, fovea };
        let index = self.next_frame;
        let may_be_cached = self.freedom.ways(&asked).contains(&Way::CachedLight);
        if self.pipeline.is_none() {
            self.change(&asked)?;
        }
        let Self { pipeline, planner, freedom, .. } = self;
        let pipeline = pipeline.as_mut().expect("it is open");
        if planner.candidate().is_none() {
            planner.measure((pipeline, &viewpoint, &asked), index, None, may_be_cached)?;
        }
        planner.choose(&asked, *freedom, Limit::Time(budget));
        let changing = Instant::now();
        let scene_changed = pipeline.change_scene(&planner.settings(&asked))?;
        let change_ms = milliseconds(changing);
        let rendered = pipeline.render_from(index, &viewpoint)?;
        let probing = Instant::now();
        let shown = Shown { frame: &rendered.frame, on_screen: true };
        planner.measure((pipeline, &viewpoint, &asked), index, Some(shown), may_be_cached)?;
        let probe_ms = milliseconds(probing);
        let ms = rendered.timings.total;
        planner.learn(&asked, MadeFrame { ms, change_ms, probe_ms, scene_changed });
        let candidate = planner.candidate().expect("one was chosen");
        let full = Candidate { way: Way::ExactLight, scale: 1.0, step: 1.0, density: 1.0 };
        self.next_frame = index.wrapping_add(1);
        let size = rendered.frame.size();
        self.view = Some(View { camera, picture: Picture::Moving(rendered.frame, candidate == full) });
        Ok(Made { size, way: candidate.way.name(), ms: milliseconds(started) })
    }

    /// Marches more pixels of the resting view. Returns the share that is done.
    fn refine(&mut self, gaze: [f64; 2], ms: f64) -> fovolnet::Result<f64> {
        let Some(mut view) = self.view.take() else { return Ok(1.0) };
        if let Picture::Moving(frame, false) = view.picture {
            let frame = resized(&frame, self.asked.size);
            view.picture = Picture::Resting(Box::new(Refinement::new(&self.asked, view.camera, frame)));
        }
        if let Picture::Resting(refinement) = &mut view.picture
            && refinement.share() < 1.0
        {
            let asked = self.asked.clone();
            self.change(&asked)?;
            refinement.advance(self.open(), gaze, ms)?;
        }
        let share = view.picture.share();
        self.view = Some(view);
        Ok(share)
    }
}

impl FrameProducer {
    /// Runs `work` without the interpreter's lock.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State) -> fovolnet::Result<T> + Send,
    ) -> PyResult<T> {
        check_process()?;
        py.detach(|| {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let done = stop::catch(|| work(&mut state));
            if done.as_ref().map_or(true, |done| done.as_ref().is_err_and(Error::is_of_gpu)) {
                // It may be half changed, or its device is lost.
                (state.pipeline, state.view) = (None, None);
            }
            drop(state);
            done.map_err(|_| interrupted())?.map_err(|error| raised(&error))
        })
    }

    /// The current picture.
    fn of_picture<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&Frame) -> T + Send) -> PyResult<T> {
        let done = self.with(py, |state| Ok(state.view.as_ref().map(|view| work(view.picture.frame()))))?;
        done.ok_or_else(|| wrong("there is no picture yet; call go_to"))
    }
}

#[pymethods]
impl FrameProducer {
    /// A producer of pictures of `volume`. `settings` is a JSON object with the names of the command line's flags. Opens nothing yet.
    #[new]
    #[pyo3(signature = (volume, settings = "{}", device = None, threads = None))]
    fn new(volume: &Volume, settings: &str, device: Option<&str>, threads: Option<usize>) -> PyResult<Self> {
        let (asked, freedom) = of_views(settings)?;
        let speed = settings::of_speed(device, threads)?;
        let volume = volume.opened.clone();
        let planner = Planner::new();
        let state =
            State { volume, asked, freedom, speed, planner, next_frame: 0, pipeline: None, view: None };
        Ok(Self(Mutex::new(state)))
    }

    /// Checks settings for `volume`. Renders and opens nothing.
    #[staticmethod]
    fn check(py: Python<'_>, volume: &Volume, settings: &str) -> PyResult<()> {
        let (asked, _) = of_views(settings)?;
        let volume = volume.opened.clone();
        py.detach(|| scene(&volume, &asked)).map(|_| ()).map_err(|error| raised(&error))
    }

    /// Takes other settings for the next pictures, at the size of the last ones.
    fn change(&self, py: Python<'_>, settings: &str) -> PyResult<()> {
        let (asked, freedom) = of_views(settings)?;
        self.with(py, |state| {
            state.asked = RenderSettings { size: state.asked.size, ..asked };
            state.freedom = freedom;
            Ok(())
        })
    }

    /// Camera of `settings` for `volume`: eye, target, vertical field of view in degrees. Opens nothing.
    #[staticmethod]
    fn default_camera(volume: &Volume, settings: &str) -> PyResult<Eye> {
        let settings = settings::of_pictures(settings)?;
        let of = || camera_path(&settings, &WorldBox::new(&volume.opened.volume, &settings)?);
        let camera = of().map_err(|error| raised(&error))?.camera(0);
        Ok((camera.eye.to_array(), camera.target.to_array(), camera.fovy))
    }

    /// Makes a picture of a view in motion in about `budget` milliseconds, at most as large as `size`. `gaze` is a place of the
    /// picture, 0 to 1 from the top left. Returns a dict: width, height, way, ms, and share, 1 for the full frame.
    #[pyo3(signature = (camera, size, gaze = (0.5, 0.5), budget = 80.0))]
    fn go_to<'py>(
        &self,
        py: Python<'py>,
        camera: Eye,
        size: (u32, u32),
        gaze: (f64, f64),
        budget: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let camera =
            Camera::new(camera.0.into(), camera.1.into(), camera.2).map_err(|error| raised(&error))?;
        let size = FrameSize::new(size.0, size.1).map_err(|error| raised(&error))?;
        let (made, share) = self.with(py, |state| {
            state.asked.size = size;
            let camera = Camera { projection: state.asked.projection, ..camera };
            let fovea = Fovea { gaze: [gaze.0, gaze.1], ..state.asked.fovea(state.next_frame)? };
            let made = state.go_to(camera, fovea, budget)?;
            Ok((made, state.view.as_ref().map_or(0.0, |view| view.picture.share())))
        })?;
        let facts = PyDict::new(py);
        facts.set_item("width", made.size.width)?;
        facts.set_item("height", made.size.height)?;
        facts.set_item("way", made.way)?;
        facts.set_item("ms", made.ms)?;
        facts.set_item("share", share)?;
        Ok(facts)
    }

    /// Works about `ms` milliseconds on the full frame of the last view, around `gaze` first. Returns the share that is done; the
    /// picture of share 1 equals that of a `Renderer`.
    #[pyo3(signature = (gaze = (0.5, 0.5), ms = 70.0))]
    fn refine(&self, py: Python<'_>, gaze: (f64, f64), ms: f64) -> PyResult<f64> {
        self.with(py, |state| state.refine([gaze.0, gaze.1], ms))
    }

    /// The current picture: its bytes as `jpeg`, `png` or `raw` (RGBA), its width and its height.
    #[pyo3(signature = (encoding = "jpeg", quality = 85))]
    fn encode<'py>(
        &self,
        py: Python<'py>,
        encoding: &str,
        quality: u8,
    ) -> PyResult<(Bound<'py, PyBytes>, u32, u32)> {
        let encoding = Encoding::named(encoding, quality)?;
        let (bytes, size) = self.of_picture(py, |frame| (encoding.of(frame), frame.size()))?;
        let bytes = bytes.map_err(|error| wrong(format!("the picture cannot be encoded: {error}")))?;
        Ok((PyBytes::new(py, &bytes), size.width, size.height))
    }

    /// The current picture: uint8 of shape (height, width, 3).
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let (size, numbers) = self.of_picture(py, |frame| (frame.size(), frame.to_rgb8()))?;
        crate::pictures::picture(py, size, 3, numbers)
    }
}

/// Settings of views, and what a planner may decide for them in motion.
fn of_views(json: &str) -> PyResult<(RenderSettings, Freedom)> {
    let given = settings::overrides(json)?;
    let asked = given.resolve().map_err(|error| raised(&error))?;
    // Whoever asks for shadows gets exact ones at rest; in motion cached ones are worth more than a smaller frame.
    let shadows = asked.shadows == ShadowMode::On;
    let freedom = Freedom { shadows, ..given.freedom() };
    let freedom = Freedom { size: true, ..freedom };
    // The full frame is what a view rests at, and a canvas is opaque.
    Ok((RenderSettings { transparent: false, sampling: Sampling::Full, ..asked }, freedom))
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
