//! Mask, march and reconstruction of frame after frame.

mod cpu;
mod estimate;
#[cfg(feature = "gpu")]
mod gpu;
mod reference;
mod sampled;
mod transparent;
mod view;

#[cfg(feature = "gpu")]
use crate::Device;
use crate::{
    Clip, Error, Machine, OpenDevice, OpenVolume, RenderSettings, Result, SpeedSettings, WorldBox, scene,
    world_box,
};
use cpu::CpuMarcher;
use fovol_core::{Camera, Fovea, Frame, FrameSize, SampleList, SampleMask, Scene, keep_workers_spinning};
use fovol_render::cpu::{RenderOptions, Simd};
use fovol_render::scene::RayResult;
#[cfg(feature = "gpu")]
pub(crate) use gpu::{device_precision, reconstructs};
use sampled::{HostReconstruction, Sampled, Sampler};
use serde::Serialize;
use std::time::Instant;
pub use view::Viewpoint;
use view::{Paths, View};

/// Milliseconds that the parts of a frame took; 0 for what did not run, or is not known apart. Reports have the four parts that
/// make up a frame; [`Timings::finer`] has what these consist of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Timings {
    /// Mask and compaction, or drawing positions.
    pub mask: f64,
    /// What of that made the list of pixels.
    #[serde(skip)]
    pub compact: f64,
    /// Marching and scatter.
    pub march: f64,
    /// What of that made the sparse frame.
    #[serde(skip)]
    pub scatter: f64,
    /// Motion and filling.
    pub reconstruct: f64,
    /// What of that found motion.
    #[serde(skip)]
    pub motion: f64,
    /// All of it.
    pub total: f64,
}

impl Timings {
    /// What `reduce` makes of each part of `all`: a mean or a median.
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

    /// As those of a frame for which the cached shadows were made in `ms` milliseconds: marching begins with that.
    #[must_use]
    pub fn with_shadow_grid(self, ms: f64) -> Self {
        Self { march: self.march + ms, total: self.total + ms, ..self }
    }

    /// Every stage with its milliseconds; together they are the frame but for what lies between them.
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

/// One frame, and what led to it.
#[derive(Debug, Clone)]
pub struct RenderedFrame {
    /// Its number.
    pub index: u32,
    /// What was sampled: alpha 1 there, transparent black elsewhere.
    pub sparse: Frame,
    /// Which pixels were sampled.
    pub mask: SampleMask,
    /// The full frame; the sparse one where reconstruction is off.
    pub frame: Frame,
    /// For each pixel the way to where it was in the last frame, see [`crate::MotionFinder`]; found where a network uses it or
    /// [`Pipeline::find_motion`] asked for it, from the second frame on.
    pub motion: Option<Vec<[f32; 2]>>,
    /// How many pixels were marched, repeated ones included.
    pub samples: usize,
    /// How many of them repeated others, where positions were drawn.
    pub lost: Option<usize>,
    /// How long it took.
    pub timings: Timings,
}

/// What is known of a frame that stays on the device once it is done.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoneFrame {
    /// Its number.
    pub index: u32,
    /// How many pixels were marched, repeated ones included.
    pub samples: usize,
    /// How long the device took.
    pub timings: Timings,
}

/// A frame that stays on the device, see [`Pipeline::display_from`].
#[cfg(feature = "gpu")]
#[derive(Debug, Clone)]
pub struct DeviceFrame {
    /// Its number.
    pub index: u32,
    /// The full frame: opaque colours of the display in rgba8unorm. Whatever is submitted to the queue later finds it made;
    /// the third frame after it takes its place.
    pub picture: wgpu::Texture,
    /// What is known of the frame two before this one, which is done; none where the last two began anew.
    pub done: Option<DoneFrame>,
}

/// Mask, march and reconstruction of frame after frame.
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

/// Where rays are marched.
#[derive(Debug)]
enum Marcher {
    Cpu(Box<CpuMarcher>),
    #[cfg(feature = "gpu")]
    Gpu(Box<gpu::GpuMarcher>),
}

impl Pipeline {
    /// Prepares `volume` for rendering as `settings` say.
    ///
    /// # Errors
    /// Settings that cannot be rendered with, files that they name and that cannot be read, a device that was asked for
    /// and cannot be used, more memory than there is.
    pub fn new(volume: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        Self::on(speed.device.clone().unwrap_or_default().open()?, volume, settings, speed)
    }

    /// Prepares `volume` for rendering as `settings` say on a device that is open, which several may share; of the device
    /// in `speed` counts only whether the processor may take its place.
    ///
    /// # Errors
    /// As [`Self::new`].
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
        let simd = speed.simd.unwrap_or_else(Simd::best);
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

    /// Goes on as `settings` say. What they share with the settings so far is kept, the memory of a network too: another
    /// camera, gaze or density costs nothing, another transfer function or light a small part of beginning anew.
    ///
    /// # Errors
    /// As [`Self::new`]; everything stays as it was then, unless the device is lost.
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

    /// Goes on with another part of the volume, which shares nothing with the one so far.
    fn begin_anew(&mut self, settings: &RenderSettings) -> Result<()> {
        let finds_motion = self.reconstruction.finds_motion;
        *self = Self::on(self.device.clone(), &self.volume, settings, &self.speed)?;
        self.reconstruction.finds_motion = finds_motion;
        Ok(())
    }

    /// The volume.
    pub fn volume(&self) -> &OpenVolume {
        &self.volume
    }

    /// The size of the frames.
    pub fn size(&self) -> FrameSize {
        self.settings.frame_size()
    }

    /// This machine as it is used here.
    pub fn machine(&self) -> Machine {
        self.machine.clone()
    }

    /// Milliseconds that the cached shadows took to make on the processor, before any frame; 0 where there are none. No frame's
    /// [`Timings`] have them, see [`Timings::with_shadow_grid`].
    pub fn shadow_grid_ms(&self) -> f64 {
        match &self.marcher {
            Marcher::Cpu(marcher) => marcher.shadow_grid_time().as_secs_f64() * 1e3,
            #[cfg(feature = "gpu")]
            Marcher::Gpu(_) => 0.0,
        }
    }

    /// What whoever asked for this should know: that something else is used than was asked for, or something slow.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The camera of frame `i`.
    pub fn camera(&self, i: u32) -> Camera {
        self.paths.camera(i)
    }

    /// How the volume stands in the world of [`Self::camera`].
    pub fn world(&self) -> &WorldBox {
        &self.world
    }

    /// The world's `camera` in the space of the marched box.
    fn in_box(&self, camera: &Camera) -> Camera {
        self.clip.camera(&self.world.camera(camera))
    }

    /// The fovea of frame `i`.
    pub fn fovea(&self, i: u32) -> Fovea {
        self.paths.fovea(i)
    }

    /// What the rays of the pixels of `list` bring back, in its order, seen from `camera`.
    ///
    /// # Errors
    /// A list for frames of another size, a device that is lost.
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

    /// Frame `i`. Networks take it for the one after the last that was rendered; see [`Self::reset`].
    ///
    /// # Errors
    /// A network that cannot go on, a device that is lost.
    pub fn render(&mut self, i: u32) -> Result<RenderedFrame> {
        self.render_from(i, &Viewpoint { camera: self.camera(i), fovea: self.fovea(i) })
    }

    /// Frame `i` seen from where somebody stands, wherever the settings' paths lead.
    ///
    /// # Errors
    /// As [`Self::render`].
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

    /// Frame `i` seen from where somebody stands, as a picture that stays on the device: nothing of it goes through the host.
    /// Returns when the device has been told; while it makes this frame the next one may be asked for, and waits for the
    /// one before. `None` where frames come by way of the host: on a processor, in precisions and fillings that run there,
    /// where masks are not listed, and where motion is asked for.
    ///
    /// # Errors
    /// As [`Self::render`].
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

    /// Waits for the frames that [`Self::display_from`] has under way; what is known of them, in their order.
    ///
    /// # Errors
    /// A device that is lost.
    #[cfg(feature = "gpu")]
    pub fn finish_display(&mut self) -> Result<Vec<DoneFrame>> {
        match &mut self.marcher {
            Marcher::Cpu(_) => Ok(Vec::new()),
            Marcher::Gpu(marcher) => marcher.finish_display(),
        }
    }

    /// From now on finds motion also where no network uses it; not where every pixel is marched.
    pub fn find_motion(&mut self) {
        self.reconstruction.finds_motion = true;
    }

    /// Forgets the frames so far, as after a cut.
    pub fn reset(&mut self) {
        self.marcher.reset();
        self.reconstruction.reset();
    }
}

impl Marcher {
    /// On `device`, and what should be known about it.
    fn new(
        device: &OpenDevice,
        scene: &Scene,
        settings: &RenderSettings,
        speed: &SpeedSettings,
    ) -> Result<(Self, Vec<String>)> {
        match device {
            OpenDevice::Cpu => Ok((Self::on_cpu(scene, settings, speed)?, Vec::new())),
            #[cfg(feature = "gpu")]
            OpenDevice::Gpu(gpu) => Self::on_gpu(gpu, scene, settings, speed),
        }
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        gpu: &fovol_gpu::Gpu,
        scene: &Scene,
        settings: &RenderSettings,
        speed: &SpeedSettings,
    ) -> Result<(Self, Vec<String>)> {
        let is_required = matches!(speed.device, Some(Device::Gpu(_)));
        let slow = || {
            let name = gpu.info().name;
            format!(
                "{name} is a program on the processor, slower than --device cpu; it is good for tests only"
            )
        };
        match gpu::GpuMarcher::new(gpu, scene, settings, speed) {
            Err(error) if !is_required && error.is_of_gpu() => {
                let note = format!("rendering on the processor: {error}");
                Ok((Self::on_cpu(scene, settings, speed)?, vec![note]))
            }
            marcher => {
                let marcher = marcher?;
                let mut notes: Vec<String> = gpu.is_software().then(slow).into_iter().collect();
                notes.extend(gpu.note().map(str::to_owned));
                if speed.filtering.is_some_and(|wanted| wanted != marcher.filtering()) {
                    notes.push(format!(
                        "voxels are interpolated exactly: samplers of {} do not filter their type",
                        gpu.info().name
                    ));
                }
                Ok((Self::Gpu(Box::new(marcher)), notes))
            }
        }
    }

    fn on_cpu(scene: &Scene, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let options =
            RenderOptions { simd: speed.simd.unwrap_or_else(Simd::best), skip_empty: !speed.no_skip };
        Ok(Self::Cpu(Box::new(CpuMarcher::new(scene, options, Sampler::new(settings))?)))
    }

    fn gpu_name(&self) -> Option<String> {
        match self {
            Self::Cpu(_) => None,
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => Some(marcher.gpu().info().name),
        }
    }

    /// What makes full frames of its samples as `settings` say, where it does not do so itself.
    fn host_reconstruction(&self, settings: &RenderSettings) -> Result<HostReconstruction> {
        match self {
            Self::Cpu(_) => HostReconstruction::new(settings),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) if reconstructs(settings) => Ok(HostReconstruction::nothing()),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => HostReconstruction::new(settings),
        }
    }

    /// Goes on with another scene around the same volume, and other settings.
    fn change(&mut self, scene: &Scene, settings: &RenderSettings, reconstructs_alike: bool) -> Result<()> {
        #[cfg(not(feature = "gpu"))]
        let _ = reconstructs_alike;
        match self {
            Self::Cpu(marcher) => marcher.change(scene, settings),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.change(scene, settings, reconstructs_alike),
        }
    }

    fn march_list(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.march_list(camera, list)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.march_list(camera, list),
        }
    }

    fn reset(&mut self) {
        match self {
            Self::Cpu(_) => {}
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.reset(),
        }
    }

    fn sample(&mut self, view: &View) -> Result<Sampled> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.sample(view)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.sample(view),
        }
    }
}

/// How long something takes.
struct Timer(Instant);

impl Timer {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds so far.
    fn ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}
