use super::adaptive_mask::{AdaptiveMaskPass, DeviceImportance};
use super::error::Result;
use super::frame_buffers::FrameBuffers;
use super::guide_list::{GuideList, GuideSamples};
use super::layers::blends;
use super::list_buffers::{ListBuffers, Shaded};
use super::march_tuner::PlayedMarch;
use super::mask_limits::MaskSource;
use super::scene::{Contents, DeviceScene};
use super::stage::Stage;
use super::stages::Stages;
use super::strategy::MarchStrategy;
use super::volume_texture::TexelKind;
use crate::Filtering;
use fovol_core::{Camera, FrameSize, Region, SampleList, Scene, ShadowMode};
use fovol_gpu::{Choices, Gpu};

/// Which pixels of a frame are marched, and how they are found.
#[derive(Debug, Clone, Copy)]
pub enum Sampling<'a> {
    /// All pixels.
    Full,
    /// The pixels of a mask, one thread to every pixel of the frame; threads outside the mask end at once.
    Reject(MaskSource<'a>),
    /// The pixels of a mask, packed into a list before they are marched.
    Compact(MaskSource<'a>),
    /// The pixels of a mask whose density follows importance, as [`crate::cpu::adaptive_mask`] makes it, packed into a list.
    Adaptive(MaskSource<'a>, DeviceImportance<'a>),
    /// The pixels of a list from the host, as [`crate::cpu::direct`] draws it.
    List(&'a SampleList),
}

/// A scene prepared for marching on a GPU.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use fovol_core::{CameraPath, Fovea, FrameSize, Grid, Scene, TransferFunction, Volume};
/// use fovol_gpu::{AdapterRequest, Gpu};
/// use fovol_render::gpu::{MaskSource, Renderer, Sampling};
/// use fovol_render::noise::{Noise, NoiseKind};
///
/// let volume = Volume::from_values(Grid::new([2, 2, 2], [1.0; 3])?, vec![0u8, 50, 90, 20, 70, 255, 30, 10])?;
/// let scene = Scene::new(volume.into(), TransferFunction::grey_ramp(0.5));
/// let gpu = Gpu::open(&AdapterRequest::Hardware)?;
/// let renderer = Renderer::new(&gpu, &scene)?;
/// let mut buffers = renderer.frame_buffers(FrameSize::default())?;
/// let noise = Noise::new(NoiseKind::Stbn, 0);
/// let source = MaskSource { fovea: &Fovea::default(), noise: &noise, frame: 0 };
/// renderer.render(&mut buffers, &CameraPath::Orbit.camera(0), Sampling::Compact(source))?;
/// let sparse = buffers.read_frame()?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    stages: Stages,
    scene: DeviceScene,
    /// How voxels are to be interpolated.
    filtering: Filtering,
}

impl Renderer {
    /// Uploads `scene` to the device of `gpu`.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered with (see [`Scene::check`]), a volume that exceeds the device's
    /// limits, a device that is lost or has no memory left, a variable that names no [`MarchStrategy`].
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self> {
        Self::with_filtering(gpu, scene, Filtering::Exact)
    }

    /// Uploads `scene` to the device of `gpu`, whose voxels are interpolated as `filtering` says where the device can.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_filtering(gpu: &Gpu, scene: &Scene, filtering: Filtering) -> Result<Self> {
        let contents = Contents::new(gpu, scene, filtering)?;
        let mut stages = gpu
            .guarded("compiling the shaders", || Stages::new(gpu, contents.texels(), contents.layering()))?;
        if let Some(strategy) = MarchStrategy::from_environment()? {
            stages.march.set_strategy(strategy);
        }
        let scene = DeviceScene::new(contents, &stages.shadow_grid)?;
        Ok(Self { gpu: gpu.clone(), stages, scene, filtering })
    }

    /// How voxels are interpolated.
    pub fn filtering(&self) -> Filtering {
        match self.scene.kind().texels {
            TexelKind::Stored { .. } => Filtering::Exact,
            TexelKind::Filtered => Filtering::Hardware,
        }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Replaces the scene by `scene`, which must show the same volume.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered, a device that is lost or has no memory left.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<()> {
        // Opacity by gradient needs other shaders, and what they read.
        if blends(scene) != self.scene.kind().layers.are_blended() {
            let mut anew = Self::with_filtering(&self.gpu, scene, self.filtering)?;
            anew.scene.choose_as(&self.scene, &anew.stages.shadow_grid)?;
            *self = anew;
            return Ok(());
        }
        self.scene.set(scene, &self.stages.shadow_grid)
    }

    /// Whether rays leave empty space at once (they do unless told otherwise); pictures do not depend on it.
    pub fn set_skip_empty(&mut self, skip_empty: bool) {
        self.scene.set_skip_empty(skip_empty);
    }

    /// How threads share the work of marching where it is not tuned.
    pub fn march_strategy(&self) -> MarchStrategy {
        self.stages.march.strategy()
    }

    /// Tries every way to share the work of marching in the next frames, and keeps the quickest in `choices`, which may know it
    /// already. Software adapters are tuned only then; others with timestamps begin so, with the user's choices.
    pub fn tune_marching(&mut self, choices: Choices) {
        self.stages.march.tune(&self.gpu, choices);
    }

    /// Learns that a frame was marched in `ms` milliseconds on the device; see [`FrameBuffers::played_march`].
    pub fn learn_march_time(&self, played: PlayedMarch, ms: f64) {
        self.stages.march.learn(played, ms);
    }

    /// Shares the work of marching the next frames so; pictures do not depend on it.
    pub fn set_march_strategy(&mut self, strategy: MarchStrategy) {
        self.stages.march.set_strategy(strategy);
    }

    /// The shadows of the scene.
    pub fn shadows(&self) -> ShadowMode {
        self.scene.shading().shadows
    }

    /// Runs `march` with a shadow ray from every sample where shadows are cached; elsewhere changes nothing.
    pub fn with_exact_shadows<T>(&mut self, march: impl FnOnce(&Self) -> T) -> T {
        if self.scene.shading().shadows != ShadowMode::Cached {
            return march(self);
        }
        self.with_shadows(ShadowMode::On, march)
    }

    /// The region of a frame of `size`, seen by `camera`, that can show more than the background; see
    /// [`crate::cpu::Renderer::visible_region`].
    pub fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        self.scene.visible_region(camera, size)
    }

    /// Keeps cached shadows on the device from now on, beside those of the scene.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn keep_cached_shadows(&mut self) -> Result<()> {
        self.scene.keep_shadow_grid(&self.stages.shadow_grid)
    }

    /// Keeps cached shadows only while the scene has them.
    pub fn release_cached_shadows(&mut self) {
        self.scene.release_shadow_grid();
    }

    /// Runs `march` with cached shadows.
    ///
    /// # Errors
    /// As [`Self::keep_cached_shadows`].
    pub fn with_cached_shadows<T>(&mut self, march: impl FnOnce(&Self) -> T) -> Result<T> {
        self.keep_cached_shadows()?;
        Ok(self.with_shadows(ShadowMode::Cached, march))
    }

    /// Runs `march` without shadows.
    pub fn without_shadows<T>(&mut self, march: impl FnOnce(&Self) -> T) -> T {
        self.with_shadows(ShadowMode::Off, march)
    }

    fn with_shadows<T>(&mut self, shadows: ShadowMode, march: impl FnOnce(&Self) -> T) -> T {
        let own = self.scene.shading().shadows;
        self.scene.set_shadows_of_next_frames(shadows);
        let marched = march(self);
        self.scene.set_shadows_of_next_frames(own);
        marched
    }

    /// Room on the device for frames of `size`.
    ///
    /// # Errors
    /// A size that exceeds the device's limits or memory.
    pub fn frame_buffers(&self, size: FrameSize) -> Result<FrameBuffers> {
        FrameBuffers::new(&self.gpu, &self.stages, size)
    }

    /// Room for lists of at most `most` pixels of the frames in `buffers`, which are marched with other shadows.
    ///
    /// # Errors
    /// As [`Self::frame_buffers`].
    pub fn guide_list(&self, buffers: &FrameBuffers, most: usize) -> Result<GuideList> {
        let made = self.gpu.guarded("making room for a list", || {
            let listed = ListBuffers::new(&self.gpu, most as u64);
            let group = self.stages.march.bind(&self.gpu, &buffers.buffers, &listed, &listed.results);
            GuideList { listed, group }
        })?;
        Ok(made)
    }

    /// Room for the samples of `buffers`, which are marched once more with other shadows.
    ///
    /// # Errors
    /// As [`Self::frame_buffers`].
    pub fn guide_samples(&self, buffers: &FrameBuffers) -> Result<GuideSamples> {
        let made = self.gpu.guarded("making room for a list", || {
            let results = Shaded::of_samples(&self.gpu, buffers.size().pixels() as u64);
            let listed = &buffers.buffers.listed;
            let group = self.stages.march.bind(&self.gpu, &buffers.buffers, listed, &results);
            GuideSamples { results, group }
        })?;
        Ok(made)
    }

    /// Puts the marching of a list of at most `most` pixels with `shadows` into `encoder`, after the frame of its buffers by
    /// [`Self::encode`] and with its camera. Cached shadows need [`Self::keep_cached_shadows`] before.
    pub fn encode_guide_list(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        list: &GuideList,
        (most, shadows): (u32, ShadowMode),
    ) {
        let march = self.stages.march.guide_list(&self.gpu, &self.scene, (most, shadows));
        let mut pass = self.gpu.pass(encoder);
        march.dispatch(&mut pass, &list.group);
    }

    /// Puts the marching of the samples of `buffers` with `shadows` into `encoder`, as [`Self::encode_guide_list`] does.
    pub fn encode_guide_samples(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (samples, buffers): (&GuideSamples, &FrameBuffers),
        shadows: ShadowMode,
    ) {
        let march = self.stages.march.samples_with(&self.gpu, &self.scene, (&buffers.buffers, shadows));
        let mut pass = self.gpu.pass(encoder);
        march.dispatch(&mut pass, &samples.group);
    }

    /// Renders a frame into `buffers`. Returns when the device has been told, not when it is done.
    ///
    /// # Errors
    /// As [`Self::encode`].
    pub fn render(&self, buffers: &mut FrameBuffers, camera: &Camera, sampling: Sampling<'_>) -> Result<()> {
        self.gpu.submit("rendering a frame", |encoder| self.encode(encoder, buffers, camera, sampling))?;
        Ok(())
    }

    /// Puts the commands of a frame into `encoder`, so that whatever uses it can follow in one submission: at most one
    /// frame of the same `buffers` in each.
    ///
    /// # Errors
    /// A list for another size; a device that is lost or has no memory left.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &mut FrameBuffers,
        camera: &Camera,
        sampling: Sampling<'_>,
    ) -> Result<()> {
        if let Sampling::List(list) = sampling {
            buffers.set_list(list)?;
        }
        self.gpu.guarded("encoding a frame", || {
            buffers.set_view(&camera.rays(buffers.size()), &self.scene.segments());
            buffers.timing.begin();
            match sampling {
                Sampling::Full => self.encode_frame(encoder, buffers, None),
                Sampling::Reject(source) => self.encode_frame(encoder, buffers, Some(&source)),
                Sampling::Compact(source) => {
                    self.encode_mask(encoder, buffers, &source);
                    self.encode_compaction(encoder, buffers);
                    self.encode_list(encoder, buffers);
                }
                Sampling::Adaptive(source, importance) => {
                    self.encode_adaptive_mask(encoder, buffers, &source, importance);
                    self.encode_compaction(encoder, buffers);
                    self.encode_list(encoder, buffers);
                }
                Sampling::List(_) => {
                    clear(encoder, buffers);
                    self.encode_list(encoder, buffers);
                }
            }
            buffers.timing.end(encoder);
        })?;
        Ok(())
    }

    fn encode_mask(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &mut FrameBuffers,
        source: &MaskSource<'_>,
    ) {
        buffers.set_mask(source, &self.stages.mask);
        let mut pass = buffers.timing.pass(encoder, Stage::Mask);
        self.stages.mask.dispatch(&mut pass, &buffers.groups.mask, buffers.size());
    }

    fn encode_adaptive_mask(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &mut FrameBuffers,
        source: &MaskSource<'_>,
        importance: DeviceImportance<'_>,
    ) {
        let stage = &self.stages.adaptive_mask;
        buffers.set_mask(source, &self.stages.mask);
        let adaptive = buffers.set_importance(source, &importance);
        let group = stage.bind(&self.gpu, &buffers.buffers, &adaptive, importance.cells);
        AdaptiveMaskPass::clear(encoder, &adaptive);
        let mut pass = buffers.timing.pass(encoder, Stage::Mask);
        self.stages.mask.dispatch(&mut pass, &buffers.groups.mask, buffers.size);
        stage.dispatch(&mut pass, &group, buffers.size);
        drop(pass);
        buffers.adaptive = Some(adaptive);
    }

    /// Packs the pixels of the mask into the list, and clears the sparse frame.
    fn encode_compaction(&self, encoder: &mut wgpu::CommandEncoder, buffers: &mut FrameBuffers) {
        let mut pass = buffers.timing.pass(encoder, Stage::Compact);
        self.stages.compact.dispatch(&mut pass, &buffers.groups.compact, buffers.size());
        drop(pass);
        buffers.is_tiled = true;
    }

    /// Marches straight into the frame.
    fn encode_frame(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &mut FrameBuffers,
        mask: Option<&MaskSource<'_>>,
    ) {
        if let Some(source) = mask {
            self.encode_mask(encoder, buffers, source);
            clear(encoder, buffers);
        }
        let frame = (buffers.size(), buffers.few_shadow_rays());
        let march = self.stages.march.frame(&self.gpu, &self.scene, frame, mask.is_some());
        buffers.played = march.played;
        let mut pass = buffers.timing.pass(encoder, Stage::March);
        march.dispatch(&mut pass, &buffers.groups.march_frame);
    }

    /// Marches the list into the cleared sparse frame, by way of a list of results unless these go straight.
    fn encode_list(&self, encoder: &mut wgpu::CommandEncoder, buffers: &mut FrameBuffers) {
        let few = buffers.few_shadow_rays();
        let is_straight = buffers.is_straight;
        let march = self.stages.march.list(&self.gpu, &self.scene, (&buffers.buffers, few), is_straight);
        buffers.played = march.played;
        let length = &buffers.buffers.listed.length;
        let groups = &buffers.groups;
        let group = if is_straight { &groups.march_frame } else { &groups.march_list };
        let mut pass = buffers.timing.pass(encoder, Stage::March);
        march.dispatch(&mut pass, group);
        drop(pass);
        if is_straight {
            return;
        }
        let mut pass = buffers.timing.pass(encoder, Stage::Scatter);
        self.stages.scatter.dispatch(&mut pass, &buffers.groups.scatter, length);
    }
}

/// Clears the sparse frame.
fn clear(encoder: &mut wgpu::CommandEncoder, buffers: &FrameBuffers) {
    encoder.clear_buffer(buffers.frame(), 0, None);
    encoder.clear_buffer(buffers.inverse_depths(), 0, None);
}
