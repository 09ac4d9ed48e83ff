//! Rendering pipeline: mask, march and reconstruction of one frame after another.

mod camera_path;
mod cpu;
mod estimate;
mod frames;
#[cfg(feature = "gpu")]
mod gpu;
mod gradient_note;
mod marcher;
mod open_marcher;
mod pieced_picture;
mod rays;
mod reference;
mod report;
mod sampled;
mod timings;
mod transparent;
mod view;

use crate::volume::{isosurface_note, orientation_notes};
use crate::{
    Choice, CroppedVolume, Error, Guide, Machine, OpenDevice, OpenVolume, RenderSettings, Result, Sampling,
    SpeedSettings, WorldBox, scene,
};
pub use camera_path::camera_path;
use fovol_core::{Camera, Fovea, FrameSize, Region, SampleList, ShadowMode, keep_workers_spinning};
use fovol_render::cpu::march::SampleCount;
use fovol_render::scene::RayResult;
#[cfg(feature = "gpu")]
pub use frames::{DeviceFrame, DoneFrame};
pub use frames::{FrameGuide, RenderedFrame};
use gradient_note::gradient_note;
use marcher::Marcher;
use open_marcher::open_marcher;
pub use pieced_picture::PiecedPicture;
pub use rays::Rays;
pub use report::{FrameReport, MeanReport, RenderReport};
use sampled::HostReconstruction;
use timings::Timer;
pub use timings::Timings;
pub use view::Viewpoint;
use view::{Paths, View};

/// Pipeline that renders one frame after another: mask, march and reconstruction.
#[derive(Debug)]
pub struct Pipeline {
    volume: OpenVolume,
    cropped: CroppedVolume,
    world: WorldBox,
    settings: RenderSettings,
    speed: SpeedSettings,
    device: OpenDevice,
    marcher: Box<dyn Marcher>,
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
        Self::on(speed.device().open()?, volume, settings, speed)
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
        settings.check_transparency()?;
        let threads =
            rayon::ThreadPoolBuilder::new().num_threads(speed.threads.unwrap_or(0)).build().map_err(|e| {
                Error::Setting(format!("cannot start the threads ({e}); give a smaller --threads"))
            })?;
        let cropped = CroppedVolume::new(volume, settings.crop)?;
        let world = WorldBox::new(&volume.volume, settings)?;
        let scene = cropped.of(scene(volume, settings)?);
        estimate::fits_into_memory(&device, &scene, settings)?;
        let (marcher, mut notes) = threads.install(|| open_marcher(&device, &scene, settings, speed))?;
        notes.extend(gradient_note(&scene));
        notes.extend(orientation_notes(&volume.volume, settings)?);
        notes.extend(isosurface_note(&volume.volume, settings));
        check_marcher(&*marcher, settings)?;
        let reconstruction = marcher.host_reconstruction(settings)?;
        let machine =
            Machine { gpu: marcher.gpu_name(), ..Machine::this(threads.current_num_threads(), speed.simd()) };
        Ok(Self {
            volume: volume.clone(),
            cropped,
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
        settings.check_transparency()?;
        check_marcher(&*self.marcher, settings)?;
        let scene = scene(&self.volume, settings)?;
        let world = WorldBox::new(&self.volume.volume, settings)?;
        let paths = Paths::new(settings, &world)?;
        if self.settings.crop != settings.crop {
            return self.begin_anew(settings);
        }
        let scene = self.cropped.of(scene);
        let reconstructs_alike = self.settings.reconstructs_as(settings);
        let Self { threads, marcher, reconstruction, .. } = self;
        threads.install(|| {
            let anew = (!reconstructs_alike).then(|| marcher.host_reconstruction(settings)).transpose()?;
            marcher.change(&scene, settings, reconstructs_alike)?;
            if let Some(anew) = anew {
                let old = std::mem::replace(reconstruction, anew);
                reconstruction.keep_as(&old);
            }
            Ok::<_, Error>(())
        })?;
        (self.paths, self.world) = (paths, world);
        self.settings = settings.clone();
        Ok(())
    }

    /// Starts over with another part of the volume; nothing of the old scene can be kept.
    fn begin_anew(&mut self, settings: &RenderSettings) -> Result<()> {
        let anew = Self::on(self.device.clone(), &self.volume, settings, &self.speed)?;
        let old = std::mem::replace(self, anew);
        self.reconstruction.keep_as(&old.reconstruction);
        Ok(())
    }

    /// Shows another volume, such as the next time point, with the same settings. A network on the CPU goes on with what it has
    /// seen.
    ///
    /// # Errors
    /// Errors of [`Self::new`]. The pipeline is then unchanged.
    pub fn show(&mut self, volume: &OpenVolume) -> Result<()> {
        let anew = Self::on(self.device.clone(), volume, &self.settings, &self.speed)?;
        let old = std::mem::replace(self, anew);
        self.reconstruction = old.reconstruction;
        Ok(())
    }

    /// Guide of the frames.
    pub fn guide(&self) -> Guide {
        #[cfg(feature = "gpu")]
        if self.marcher.gpu_name().is_some() {
            return self.settings.on_gpu().guide_kind();
        }
        self.settings.guide_kind()
    }

    /// Rendered volume.
    pub fn volume(&self) -> &OpenVolume {
        &self.volume
    }

    /// Size of the frames.
    pub fn size(&self) -> FrameSize {
        self.settings.size
    }

    /// Description of the machine as this pipeline uses it.
    pub fn machine(&self) -> Machine {
        self.machine.clone()
    }

    /// Milliseconds that the CPU took for the grid of cached shadows, before any frame; 0 without one. The [`Timings`]
    /// of frames do not include it, see [`Timings::with_shadow_grid`].
    pub fn shadow_grid_ms(&self) -> f64 {
        self.marcher.shadow_grid_time().as_secs_f64() * 1e3
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
        self.cropped.camera(&self.world.camera(camera))
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
        self.march_with(|marcher, camera| marcher.march_list(camera, list), camera)
    }

    /// Ray results of `march` for `camera` in world space, with depths in world space.
    fn march_with(
        &mut self,
        march: impl FnOnce(&mut dyn Marcher, &Camera) -> Result<Vec<RayResult>> + Send,
        camera: &Camera,
    ) -> Result<Vec<RayResult>> {
        let whole = self.world.camera(camera);
        let camera = self.cropped.camera(&whole);
        let marcher = &mut *self.marcher;
        let mut marched = self.threads.install(|| march(marcher, &camera))?;
        for pixel in &mut marched {
            pixel.depth = self.cropped.distance(pixel.depth, &whole);
        }
        Ok(marched)
    }

    /// Marches the pixels of `list` with other shadows and another step, in voxels, than those of the settings; also
    /// returns the number of samples, where it is counted. `None` if the device cannot do so.
    pub(crate) fn march_as(
        &mut self,
        how: (ShadowMode, f64),
        camera: &Camera,
        list: &SampleList,
    ) -> Result<Option<(Vec<RayResult>, Option<SampleCount>)>> {
        let camera = self.in_box(camera);
        let marcher = &mut *self.marcher;
        self.threads.install(|| marcher.march_as(how, &camera, list))
    }

    /// Milliseconds that the last cached shadows took, whatever shadows the scene has, if they are known.
    pub(crate) fn cached_shadows_ms(&self) -> Option<f64> {
        self.marcher.cached_shadows_time().map(|time| time.as_secs_f64() * 1e3)
    }

    /// Region of frames of `size` in which the volume can be seen by `camera`, in world space.
    pub(crate) fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        self.marcher.visible_region(&self.in_box(camera), size)
    }

    /// Changes the settings as [`Self::change`] does; tells whether light, transfer function or clip were changed.
    ///
    /// # Errors
    /// Errors of [`Self::change`].
    pub fn change_scene(&mut self, settings: &RenderSettings) -> Result<bool> {
        let of = |settings: &RenderSettings| {
            let RenderSettings { light, transfer_function, transfer_range, scale, nan, .. } = settings;
            let values = (transfer_function.clone(), *transfer_range, *scale, *nan);
            (
                *light,
                values,
                settings.crop,
                settings.planes,
                settings.mode,
                settings.iso,
                settings.interpolation,
            )
        };
        let changed = of(&self.settings) != of(settings);
        self.change(settings)?;
        Ok(changed)
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
        if self.settings.transparent {
            return self.render_without_background(i, viewpoint);
        }
        let started = Timer::start();
        let (camera, fovea) = (self.in_box(&viewpoint.camera), viewpoint.fovea);
        let view = View { index: i, size: self.size(), camera, fovea };
        let (marcher, reconstruction) = (&mut self.marcher, &mut self.reconstruction);
        self.threads.install(|| {
            keep_workers_spinning(|| {
                let sampled = marcher.sample(&view, reconstruction.wanted())?;
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
        if self.reconstruction.is_needed(&self.settings) {
            return Ok(None);
        }
        let marcher = &mut self.marcher;
        self.threads.install(|| marcher.display(&view))
    }

    /// Waits for the frames of [`Self::display_from`] in progress; returns facts about them, in order.
    ///
    /// # Errors
    /// A lost device.
    #[cfg(feature = "gpu")]
    pub fn finish_display(&mut self) -> Result<Vec<DoneFrame>> {
        self.marcher.finish_display()
    }

    /// Finds motion from now on, even if no network uses it. Not for frames with every pixel marched.
    pub fn find_motion(&mut self) {
        self.reconstruction.finds_motion = true;
    }

    /// Keeps the guide and the light ratio of frames from now on.
    pub fn keep_guide(&mut self) {
        self.reconstruction.keeps_guide = true;
    }

    /// Forgets all earlier frames, as after a cut.
    pub fn reset(&mut self) {
        self.marcher.reset();
        self.reconstruction.reset();
    }
}

/// Checks that `marcher` can do what is asked for.
///
/// # Errors
/// Guides of frames without lists, on a GPU.
fn check_marcher(marcher: &dyn Marcher, settings: &RenderSettings) -> Result<()> {
    let has_guide = matches!(settings.guide, Choice::Fixed(guide) if guide != Guide::None);
    if has_guide && settings.sampling == Sampling::Reject && marcher.gpu_name().is_some() {
        return Err(Error::Setting(
            "frames of a GPU cannot have a guide with --sampling reject; add --device cpu, or leave it out"
                .into(),
        ));
    }
    Ok(())
}
