//! Rendering pipeline: mask, march and reconstruction of one frame after another.

mod cpu;
mod estimate;
#[cfg(feature = "gpu")]
mod gpu;
mod marcher;
mod reference;
mod sampled;
mod transparent;
mod view;

use crate::{
    Clip, Error, Machine, OpenDevice, OpenVolume, RenderSettings, Result, SpeedSettings, WorldBox, scene,
    world_box,
};
use fovol_core::{Camera, Fovea, Frame, FrameSize, SampleList, SampleMask, keep_workers_spinning};
use fovol_render::cpu::best_simd;
use fovol_render::scene::RayResult;
#[cfg(feature = "gpu")]
pub(crate) use gpu::{device_precision, reconstructs};
use marcher::Marcher;
use sampled::HostReconstruction;
use serde::Serialize;
use std::time::Instant;
pub use view::Viewpoint;
use view::{Paths, View};

/// Times of the stages of a frame in milliseconds; 0 for stages that did not run or were not timed apart. Reports hold
/// mask, march, reconstruct and total; [`Timings::finer`] splits them further.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Timings {
    /// Mask and compaction, or drawing random positions.
    pub mask: f64,
    /// Compaction of the mask to a list of pixels; part of `mask`.
    #[serde(skip)]
    pub compact: f64,
    /// Marching and scatter.
    pub march: f64,
    /// Scatter of ray results to the sparse frame; part of `march`.
    #[serde(skip)]
    pub scatter: f64,
    /// Motion and filling.
    pub reconstruct: f64,
    /// Estimation of motion; part of `reconstruct`.
    #[serde(skip)]
    pub motion: f64,
    /// Whole frame.
    pub total: f64,
}

impl Timings {
    /// Applies `reduce`, such as a mean or a median, to each stage over `all`.
    pub fn reduced(all: &[Self], reduce: impl Fn(&mut [f64]) -> f64) -> Self {
        let part = |of: fn(&Self) -> f64| reduce(&mut all.iter().map(of).collect::<Vec<_>>());
        Self {
            mask: part(|t| t.mask),
            compact: part(|t| t.compact),
            march: part(|t| t.march),
            scatter: part(|t| t.scatter),
            reconstruct: part(|t| t.reconstruct),
            motion: part(|t| t.motion),
            total: part(|t| t.total),
        }
    }

    /// Adds `ms` milliseconds for the grid of cached shadows to the march and the total.
    #[must_use]
    pub fn with_shadow_grid(self, ms: f64) -> Self {
        Self { march: self.march + ms, total: self.total + ms, ..self }
    }

    /// Names and times of all stages. Their sum is the total without the gaps between stages.
    pub fn finer(&self) -> [(&'static str, f64); 6] {
        [
            ("mask", self.mask - self.compact),
            ("compact", self.compact),
            ("march", self.march - self.scatter),
            ("scatter", self.scatter),
            ("motion", self.motion),
            ("fill", self.reconstruct - self.motion),
        ]
    }
}

/// Rendered frame and its intermediate results.
#[derive(Debug, Clone)]
pub struct RenderedFrame {
    /// Frame number.
    pub index: u32,
    /// Sparse frame: alpha 1 at samples, transparent black elsewhere.
    pub sparse: Frame,
    /// Sampled pixels.
    pub mask: SampleMask,
    /// Full frame; the sparse one if reconstruction is off.
    pub frame: Frame,
    /// Motion of each pixel to its position in the last frame, see [`crate::MotionFinder`]. Present from the second
    /// frame on, if a network uses motion or [`Pipeline::find_motion`] was called.
    pub motion: Option<Vec<[f32; 2]>>,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Number of repeated pixels, if positions were drawn at random.
    pub lost: Option<usize>,
    /// Times of the stages.
    pub timings: Timings,
}

/// Facts about a finished frame that stayed on the device.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoneFrame {
    /// Frame number.
    pub index: u32,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Times on the device.
    pub timings: Timings,
}

/// Frame that stays on the device, see [`Pipeline::display_from`].
#[cfg(feature = "gpu")]
#[derive(Debug, Clone)]
pub struct DeviceFrame {
    /// Frame number.
    pub index: u32,
    /// Full frame: opaque display colours in rgba8unorm. Later submissions to the queue see it finished. The third
    /// frame after this one overwrites it.
    pub picture: wgpu::Texture,
    /// Facts about the frame two before this one, which is finished. `None` for the first two frames after a fresh
    /// start.
    pub done: Option<DoneFrame>,
}

/// Pipeline that renders one frame after another: mask, march and reconstruction.
#[derive(Debug)]
pub struct Pipeline {
    volume: OpenVolume,
    clip: Clip,
    world: WorldBox,
    settings: RenderSettings,
    speed: SpeedSettings,
    device: OpenDevice,
    marcher: Marcher,
    reconstruction: HostReconstruction,
    paths: Paths,
    machine: Machine,
    notes: Vec<String>,
    threads: rayon::ThreadPool,
}

impl Pipeline {
    /// Prepares `volume` for rendering with `settings`.
    ///
    /// # Errors
    /// Invalid settings, files that cannot be read, a requested device that cannot be used, too little memory.
    pub fn new(volume: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        Self::on(speed.device.clone().unwrap_or_default().open()?, volume, settings, speed)
    }

    /// Prepares `volume` for rendering on an open device, which several pipelines may share. Of the device in `speed`
    /// only one thing counts: whether the CPU may replace the GPU.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn on(
        device: OpenDevice,
        volume: &OpenVolume,
        settings: &RenderSettings,
        speed: &SpeedSettings,
    ) -> Result<Self> {
        transparent::check(settings)?;
        let threads =
            rayon::ThreadPoolBuilder::new().num_threads(speed.threads.unwrap_or(0)).build().map_err(|e| {
                Error::Setting(format!("cannot start the threads ({e}); give a smaller --threads"))
            })?;
        let clip = Clip::new(&volume.volume, settings.clip)?;
        let world = WorldBox::new(&volume.volume, settings)?;
        let scene = clip.of(scene(volume, settings)?);
        estimate::check(&device, &scene, settings)?;
        let (marcher, mut notes) = threads.install(|| Marcher::new(&device, &scene, settings, speed))?;
        notes.extend(world_box::notes(&volume.volume, settings)?);
        let reconstruction = marcher.host_reconstruction(settings)?;
        let simd = speed.simd.unwrap_or_else(best_simd);
        let machine =
            Machine { gpu: marcher.gpu_name(), ..Machine::this(threads.current_num_threads(), simd) };
        Ok(Self {
            volume: volume.clone(),
            clip,
            world,
            settings: settings.clone(),
            speed: speed.clone(),
            device,
            marcher,
            reconstruction,
            paths: Paths::new(settings, &world)?,
            machine,
            notes,
            threads,
        })
    }

    /// Changes the settings. Everything that stays valid is kept, also the state of a network. Another camera, gaze or
    /// density costs nothing; another transfer function or light costs far less than a new pipeline.
    ///
    /// # Errors
    /// Errors of [`Self::new`]. The pipeline is then unchanged, unless the device was lost.
    pub fn change(&mut self, settings: &RenderSettings) -> Result<()> {
        if self.settings == *settings {
            return Ok(());
        }
        transparent::check(settings)?;
        let scene = scene(&self.volume, settings)?;
        let world = WorldBox::new(&self.volume.volume, settings)?;
        let paths = Paths::new(settings, &world)?;
        if self.settings.clip != settings.clip {
            return self.begin_anew(settings);
        }
        let scene = self.clip.of(scene);
        let reconstructs_alike = self.settings.reconstructs_as(settings);
        let Self { threads, marcher, reconstruction, .. } = self;
        threads.install(|| {
            let anew = (!reconstructs_alike).then(|| marcher.host_reconstruction(settings)).transpose()?;
            marcher.change(&scene, settings, reconstructs_alike)?;
            if let Some(anew) = anew {
                let finds_motion = reconstruction.finds_motion;
                *reconstruction = anew;
                reconstruction.finds_motion = finds_motion;
            }
            Ok::<_, Error>(())
        })?;
        (self.paths, self.world) = (paths, world);
        self.settings = settings.clone();
        Ok(())
    }

    /// Starts over with another part of the volume; nothing of the old scene can be kept.
    fn begin_anew(&mut self, settings: &RenderSettings) -> Result<()> {
        let finds_motion = self.reconstruction.finds_motion;
        *self = Self::on(self.device.clone(), &self.volume, settings, &self.speed)?;
        self.reconstruction.finds_motion = finds_motion;
        Ok(())
    }

    /// Rendered volume.
    pub fn volume(&self) -> &OpenVolume {
        &self.volume
    }

    /// Size of the frames.
    pub fn size(&self) -> FrameSize {
        self.settings.frame_size()
    }

    /// Description of the machine as this pipeline uses it.
    pub fn machine(&self) -> Machine {
        self.machine.clone()
    }

    /// Milliseconds that the CPU took for the grid of cached shadows, before any frame; 0 without one. The [`Timings`]
    /// of frames do not include it, see [`Timings::with_shadow_grid`].
    pub fn shadow_grid_ms(&self) -> f64 {
        match &self.marcher {
            Marcher::Cpu(marcher) => marcher.shadow_grid_time().as_secs_f64() * 1e3,
            #[cfg(feature = "gpu")]
            Marcher::Gpu(_) => 0.0,
        }
    }

    /// Notes for the user: on replacements for what was requested, and on slow choices.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Camera of frame `i`, in world space.
    pub fn camera(&self, i: u32) -> Camera {
        self.paths.camera(i)
    }

    /// Placement of the volume in the world space of [`Self::camera`].
    pub fn world(&self) -> &WorldBox {
        &self.world
    }

    /// Transforms `camera` from world space to the space of the marched box.
    fn in_box(&self, camera: &Camera) -> Camera {
        self.clip.camera(&self.world.camera(camera))
    }

    /// Fovea of frame `i`.
    pub fn fovea(&self, i: u32) -> Fovea {
        self.paths.fovea(i)
    }

    /// Marches the pixels of `list` seen from `camera`; results are in list order.
    ///
    /// # Errors
    /// A list for frames of another size, a lost device.
    pub fn march(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        self.march_with(Marcher::march_list, camera, list)
    }

    fn march_with(
        &mut self,
        march: fn(&mut Marcher, &Camera, &SampleList) -> Result<Vec<RayResult>>,
        camera: &Camera,
        list: &SampleList,
    ) -> Result<Vec<RayResult>> {
        let camera = self.in_box(camera);
        let marcher = &mut self.marcher;
        let mut marched = self.threads.install(|| march(marcher, &camera, list))?;
        for pixel in &mut marched {
            pixel.depth = self.clip.distance(pixel.depth);
        }
        Ok(marched)
    }

    /// Renders frame `i`. Networks treat it as the successor of the last rendered frame; see [`Self::reset`].
    ///
    /// # Errors
    /// Errors of the network, a lost device.
    pub fn render(&mut self, i: u32) -> Result<RenderedFrame> {
        self.render_from(i, &Viewpoint { camera: self.camera(i), fovea: self.fovea(i) })
    }

    /// Renders frame `i` from `viewpoint` instead of the camera and gaze of the settings.
    ///
    /// # Errors
    /// Errors of [`Self::render`].
    pub fn render_from(&mut self, i: u32, viewpoint: &Viewpoint) -> Result<RenderedFrame> {
        if self.settings.is_transparent() {
            return self.render_without_background(i, viewpoint);
        }
        let started = Timer::start();
        let (camera, fovea) = (self.in_box(&viewpoint.camera), viewpoint.fovea);
        let view = View { index: i, size: self.size(), camera, fovea };
        let (marcher, reconstruction) = (&mut self.marcher, &mut self.reconstruction);
        self.threads.install(|| {
            keep_workers_spinning(|| {
                let sampled = marcher.sample(&view)?;
                reconstruction.finish(&view, sampled, &started)
            })
        })
    }

    /// Renders frame `i` from `viewpoint` to a picture that stays on the device.
    ///
    /// Returns once the work is submitted. The next frame may be requested while this one is rendered; that call waits
    /// for the frame before this one. `None` if frames have to go through the host: on the CPU, with a precision or a
    /// fill that runs there, with sampling `reject`, or if motion was requested.
    ///
    /// # Errors
    /// Errors of [`Self::render`].
    #[cfg(feature = "gpu")]
    pub fn display_from(&mut self, i: u32, viewpoint: &Viewpoint) -> Result<Option<DeviceFrame>> {
        let (camera, fovea) = (self.in_box(&viewpoint.camera), viewpoint.fovea);
        let view = View { index: i, size: self.size(), camera, fovea };
        match &mut self.marcher {
            Marcher::Gpu(marcher) if !self.reconstruction.is_needed(&self.settings) => {
                self.threads.install(|| marcher.display(&view))
            }
            _ => Ok(None),
        }
    }

    /// Waits for the frames of [`Self::display_from`] in progress; returns facts about them, in order.
    ///
    /// # Errors
    /// A lost device.
    #[cfg(feature = "gpu")]
    pub fn finish_display(&mut self) -> Result<Vec<DoneFrame>> {
        match &mut self.marcher {
            Marcher::Cpu(_) => Ok(Vec::new()),
            Marcher::Gpu(marcher) => marcher.finish_display(),
        }
    }

    /// Finds motion from now on, even if no network uses it. Not for frames with every pixel marched.
    pub fn find_motion(&mut self) {
        self.reconstruction.finds_motion = true;
    }

    /// Forgets all earlier frames, as after a cut.
    pub fn reset(&mut self) {
        self.marcher.reset();
        self.reconstruction.reset();
    }
}

/// Stopwatch.
struct Timer(Instant);

impl Timer {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    fn ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}
