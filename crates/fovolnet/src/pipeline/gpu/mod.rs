use super::frames::{DeviceFrame, DoneFrame};
use super::marcher::Marcher;
use super::sampled::{HostReconstruction, Made, Sampled, Sampler, Wanted, in_raster_order};
use super::timings::{Timer, Timings};
use super::view::View;
use crate::guide::{GuidePixel, MarchedGuide, guide_pixel};
use crate::motion::Depths;
use crate::reconstruct::{Seen, reconstructs};
use crate::{Guide, RenderSettings, Result, Sampling, SpeedSettings};
use display::Display;
use fovol_core::{Camera, Frame, FrameSize, Pixel, Region, SampleList, Scene, ShadowMode, SparseFrame};
use fovol_gpu::{Gpu, Timing};
use fovol_render::cpu::march::SampleCount;
use fovol_render::cpu::{DirectSamples, adaptive_mask, compact, direct, mask_of, sparse_frame};
use fovol_render::gpu::{self, FrameBuffers, MaskSource, Renderer};
use fovol_render::scene::RayResult;
use fovol_render::{Filtering, Importance};
use part::{Part, add_stage};
use reconstruction::{DeviceReconstruction, Marched};
use std::time::Duration;

mod depths;
mod display;
mod guide;
mod motion;
mod part;
mod reconstruction;
mod reprojection;

/// Ray marcher of the pipeline on the GPU, with the reconstruction if it runs there too. Frames do not go through the
/// host between the stages.
#[derive(Debug)]
pub struct GpuMarcher {
    renderer: Renderer,
    buffers: FrameBuffers,
    sampler: Sampler,
    reconstruction: Option<DeviceReconstruction>,
    /// Timestamps of the parts of reconstruction.
    parts: Timing<Part>,
    /// Display of frames on the device; created at the first use.
    display: Option<Display>,
    background: [f32; 3],
    /// Step along rays, in voxels.
    step: f64,
    /// Buffers of lists of pixels in frames of the planner's sizes, the last used ones last.
    probe_buffers: Vec<FrameBuffers>,
}

/// Sizes of frames whose buffers for lists of pixels are kept.
const MOST_PROBE_BUFFERS: usize = 6;

/// Pixels of a frame that the CPU lists.
struct Listed {
    list: SampleList,
    /// Number of repeated positions, if positions were drawn at random.
    lost: Option<usize>,
}

impl GpuMarcher {
    pub fn new(gpu: &Gpu, scene: &Scene, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let settings = &settings.on_gpu();
        let sampler = Sampler::new(settings);
        let filtering = speed.filtering.unwrap_or_default();
        let mut renderer = Renderer::with_filtering(gpu, scene, filtering)?;
        renderer.set_skip_empty(!speed.no_skip);
        if settings.guide_kind() == Guide::Cached {
            renderer.keep_cached_shadows()?;
        }
        let buffers = renderer.frame_buffers(sampler.size)?;
        let reconstruction = DeviceReconstruction::new(&renderer, settings, &buffers)?;
        let parts = Timing::new(gpu, Part::COUNT);
        let background = background_of(scene);
        Ok(Self {
            renderer,
            buffers,
            sampler,
            reconstruction,
            parts,
            display: None,
            background,
            step: scene.step,
            probe_buffers: Vec::new(),
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        self.renderer.gpu()
    }

    /// Interpolation of voxels.
    pub fn filtering(&self) -> Filtering {
        self.renderer.filtering()
    }

    fn render_exactly(&mut self, camera: &Camera, sampling: gpu::Sampling<'_>) -> Result<()> {
        let Self { renderer, buffers, .. } = self;
        buffers.set_few_shadow_rays(None);
        renderer.with_exact_shadows(|renderer| renderer.render(buffers, camera, sampling))?;
        Ok(())
    }

    /// Pixels of the frame of `view`, if the CPU lists them: at random, or by their `importance`.
    fn listing(&self, view: &View, importance: Option<&Importance>) -> Option<Listed> {
        let Sampler { size, sampling, seed, noise, .. } = &self.sampler;
        let important = importance.zip(self.region(view));
        match (sampling, important) {
            (Sampling::Direct, _) => {
                let DirectSamples { list, lost, .. } = direct(&view.fovea, *size, *seed, view.index);
                Some(Listed { list, lost: Some(lost) })
            }
            (Sampling::Compact, Some(important)) => {
                let mask = adaptive_mask(&view.fovea, *size, noise, view.index, important);
                Some(Listed { list: compact(&mask), lost: None })
            }
            _ => None,
        }
    }

    /// Region of the frame of `view` in which the volume can be seen.
    fn region(&self, view: &View) -> Option<Region> {
        self.renderer.visible_region(&view.camera, view.size)
    }

    /// Guide of the frame of `view`, whose samples are `sparse`, if there is to be one that the CPU uses.
    fn guide(
        &mut self,
        view: &View,
        sparse: &SparseFrame,
        of_samples: &[GuidePixel],
    ) -> Result<Option<MarchedGuide>> {
        let grid =
            self.region(view).and_then(|region| self.sampler.guide.grid(view.index, region, view.size));
        let Some(grid) = grid.filter(|_| self.reconstruction.is_none()) else { return Ok(None) };
        let (renderer, buffers) = (&mut self.renderer, &mut self.buffers);
        let is_cached = self.sampler.guide == Guide::Cached;
        let march = |list: &SampleList| -> Result<Vec<RayResult>> {
            let listed = gpu::Sampling::List(list);
            let march = |renderer: &Renderer| renderer.render(buffers, &view.camera, listed);
            match is_cached {
                true => renderer.with_cached_shadows(march)??,
                false => renderer.without_shadows(march)?,
            }
            Ok(buffers.read_samples()?)
        };
        if is_cached {
            return MarchedGuide::with_cached_shadows(grid, sparse, march).map(Some);
        }
        MarchedGuide::new(grid, sparse, of_samples, march).map(Some)
    }

    /// Encodes a frame into `encoder`, with the pixels of `listed` if the CPU has listed them.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        listed: Option<&Listed>,
    ) -> Result<()> {
        let Sampler { sampling, noise, .. } = &self.sampler;
        let source = MaskSource { fovea: &view.fovea, noise, frame: view.index };
        let region = self.region(view);
        let important = self.reconstruction.as_ref().and_then(|made| made.importance(region));
        let sampling = match (sampling, listed) {
            (_, Some(listed)) => gpu::Sampling::List(&listed.list),
            (Sampling::Full, _) => gpu::Sampling::Full,
            (Sampling::Reject, _) => gpu::Sampling::Reject(source),
            _ => match important {
                Some(important) => gpu::Sampling::Adaptive(source, important),
                None => gpu::Sampling::Compact(source),
            },
        };
        let Self { renderer, buffers, background, .. } = self;
        buffers.set_few_shadow_rays(self.sampler.few_shadow_rays(view.index).as_ref());
        renderer.encode(encoder, buffers, &view.camera, sampling)?;
        self.parts.begin();
        if let Some(reconstruction) = &mut self.reconstruction {
            let marched = Marched { renderer, buffers, view, region, background: *background };
            reconstruction.encode(encoder, &marched, &mut self.parts)?;
        }
        self.parts.end(encoder);
        Ok(())
    }

    /// Samples of the last list, of the frame of `view`: the CPU's, or the one that the device compacted from its mask.
    fn listed(&mut self, view: &View, listed: Option<Listed>) -> Result<Sampled> {
        let lost = listed.as_ref().and_then(|listed| listed.lost);
        let list = listed.map_or_else(|| self.buffers.read_list(), |listed| Ok(listed.list))?;
        let marched = self.buffers.read_samples()?;
        let (mask, samples) = (mask_of(&list), marched.len());
        let (list, marched) = in_raster_order(list, marched, &mask);
        let sparse = sparse_frame(list, &marched);
        let timer = Timer::start();
        let of_samples: Vec<GuidePixel> = marched.iter().map(guide_pixel).collect();
        let guide = self.guide(view, &sparse, &of_samples)?;
        let timings = Timings { guide: timer.ms(), ..Timings::default() };
        let seen = Seen { region: self.region(view), background: self.background };
        Ok(Sampled { lost, timings, seen, guide, ..Sampled::sparse(sparse, mask, samples) })
    }

    /// Samples of the last mask, marched without a list.
    fn rejected(&self) -> Result<Sampled> {
        let (frame, mask) = (self.buffers.read_frame()?, self.buffers.read_mask()?);
        let inverse = self.buffers.read_inverse_depths()?;
        let list = compact(&mask);
        let result = |pixel: &Pixel| {
            let at = pixel.index(mask.size().width);
            let [r, g, b, _] = frame.pixels()[at];
            ([r, g, b], 1.0 / inverse[at])
        };
        let (colours, depths) = list.pixels().iter().map(result).unzip();
        let samples = list.len();
        Ok(Sampled::sparse(SparseFrame::new(list, colours, depths), mask, samples))
    }

    /// Full frame that the device has reconstructed, with what is `wanted`.
    fn made(&self, wanted: Wanted<'_>) -> Result<Option<Made>> {
        let Some(made) = &self.reconstruction else { return Ok(None) };
        let (gpu, size) = (self.gpu(), self.sampler.size);
        let depths =
            (wanted.motion && made.has_guide()).then(|| self.buffers.read_inverse_depths()).transpose()?;
        Ok(Some(Made {
            frame: made.read_frame(gpu, size)?,
            guide_samples: made.read_guide_samples()?,
            guide: if wanted.guide { made.read_guide(gpu, size)? } else { None },
            depths: depths.map(|inverse| Depths::of_frame(size, &inverse)),
        }))
    }

    /// Times of the last frame's stages on the device. Without timestamps the whole time `done_ms` counts as march.
    fn timings(&self, done_ms: f64) -> Result<Timings> {
        let (Some(stages), Some(parts)) = (self.buffers.read_times()?, self.parts.read(self.gpu())?) else {
            return Ok(Timings { march: done_ms, ..Timings::default() });
        };
        let march = stages.iter().find(|time| time.stage == gpu::Stage::March);
        if let Some((played, march)) = self.buffers.played_march().zip(march) {
            self.renderer.learn_march_time(played, march.ms);
        }
        let mut timings = Timings::default();
        stages.iter().for_each(|time| add_stage(&mut timings, time.stage, time.ms));
        parts.iter().for_each(|time| time.stage.add(&mut timings, time.ms));
        Ok(timings)
    }
}

/// Background of `scene`: red, green and blue.
fn background_of(scene: &Scene) -> [f32; 3] {
    scene.background.map(|channel| channel as f32)
}

impl Marcher for GpuMarcher {
    fn gpu_name(&self) -> Option<String> {
        Some(self.gpu().info().name)
    }

    /// The device makes the grid.
    fn shadow_grid_time(&self) -> Duration {
        Duration::ZERO
    }

    fn host_reconstruction(&self, settings: &RenderSettings) -> Result<HostReconstruction> {
        let settings = &settings.on_gpu();
        if reconstructs(settings) {
            return Ok(HostReconstruction::nothing());
        }
        HostReconstruction::new(settings)
    }

    fn change(&mut self, scene: &Scene, settings: &RenderSettings, reconstructs_alike: bool) -> Result<()> {
        let settings = &settings.on_gpu();
        let size = settings.size;
        let resized = size != self.sampler.size;
        let buffers = resized.then(|| self.renderer.frame_buffers(size)).transpose()?;
        let buffers_then = buffers.as_ref().unwrap_or(&self.buffers);
        let renderer = &self.renderer;
        let anew = (!reconstructs_alike).then(|| DeviceReconstruction::new(renderer, settings, buffers_then));
        let anew = anew.transpose()?;
        match settings.guide_kind() {
            Guide::Cached => self.renderer.keep_cached_shadows()?,
            _ => self.renderer.release_cached_shadows(),
        }
        self.renderer.set_scene(scene)?;
        (self.background, self.step) = (background_of(scene), scene.step);
        self.sampler.change(settings);
        // Frames in progress were encoded for the old settings.
        self.display = None;
        if let Some(buffers) = buffers {
            self.buffers = buffers;
        }
        if let Some(anew) = anew {
            self.reconstruction = anew;
        }
        Ok(())
    }

    fn march_list(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        self.buffers.set_few_shadow_rays(None);
        self.renderer.render(&mut self.buffers, camera, gpu::Sampling::List(list))?;
        Ok(self.buffers.read_samples()?)
    }

    fn march_list_exactly(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        self.render_exactly(camera, gpu::Sampling::List(list))?;
        Ok(self.buffers.read_samples()?)
    }

    /// The device has tables for one step.
    fn march_as(
        &mut self,
        (shadows, step): (ShadowMode, f64),
        camera: &Camera,
        list: &SampleList,
    ) -> Result<Option<(Vec<RayResult>, Option<SampleCount>)>> {
        let own = self.renderer.shadows();
        // Lists have room for as many pixels as their frame has.
        let is_too_long = list.len() > list.size().pixels();
        if is_too_long || step != self.step {
            return Ok(None);
        }
        let known = self.probe_buffers.iter().position(|buffers| buffers.size() == list.size());
        let mut buffers = match known {
            Some(at) => self.probe_buffers.remove(at),
            None => self.renderer.frame_buffers(list.size())?,
        };
        let (renderer, sampling) = (&mut self.renderer, gpu::Sampling::List(list));
        let mut march = |renderer: &Renderer| renderer.render(&mut buffers, camera, sampling);
        match shadows {
            ShadowMode::Off => renderer.without_shadows(march)?,
            ShadowMode::On if own == ShadowMode::Cached => renderer.with_exact_shadows(march)?,
            ShadowMode::On if own == ShadowMode::Off => return Ok(None),
            ShadowMode::Cached => renderer.with_cached_shadows(march)??,
            ShadowMode::On => march(renderer)?,
        }
        let rays = buffers.read_samples()?;
        self.probe_buffers.push(buffers);
        if self.probe_buffers.len() > MOST_PROBE_BUFFERS {
            self.probe_buffers.remove(0);
        }
        Ok(Some((rays, None)))
    }

    fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        self.renderer.visible_region(camera, size)
    }

    /// Frames have the size of the settings.
    fn reference(&mut self, camera: &Camera, _: FrameSize) -> Result<Frame> {
        self.render_exactly(camera, gpu::Sampling::Full)?;
        Ok(self.buffers.read_frame()?)
    }

    /// Renders a frame and reads it back: the samples, and the full frame if it was reconstructed on the device.
    fn sample(&mut self, view: &View, wanted: Wanted<'_>) -> Result<Sampled> {
        let timer = Timer::start();
        let listed = self.listing(view, wanted.importance);
        let listing_ms = timer.ms();
        self.gpu()
            .clone()
            .submit("rendering a frame", |encoder| self.encode(encoder, view, listed.as_ref()))?;
        self.gpu().wait()?;
        let timings = self.timings(timer.ms() - listing_ms)?;
        let timings = Timings { mask: timings.mask + listing_ms, ..timings };
        let made = self.made(wanted)?;
        let sampled = match self.sampler.sampling {
            Sampling::Full => Sampled::full(self.buffers.read_frame()?),
            Sampling::Reject => self.rejected()?,
            Sampling::Direct | Sampling::Compact => self.listed(view, listed)?,
        };
        let timings = Timings { guide: timings.guide + sampled.timings.guide, ..timings };
        Ok(Sampled { made, timings, ..sampled })
    }

    /// Renders a frame that stays on the device. Returns once the work is submitted and at most one other frame is in
    /// progress. `None` for sampling `reject`, which does not list its pixels on the device.
    fn display(&mut self, view: &View) -> Result<Option<DeviceFrame>> {
        // Sampling `reject` has no list, so the device does not count its samples.
        if self.sampler.sampling == Sampling::Reject {
            return Ok(None);
        }
        let gpu = self.gpu().clone();
        let mut display = match self.display.take() {
            Some(display) => display,
            None => Display::new(&gpu, self.sampler.size)?,
        };
        let done = display.make_way()?;
        display.take_played().for_each(|(played, ms)| self.renderer.learn_march_time(played, ms));
        let listed = self.listing(view, None);
        // A guide reads the list of results, and nothing else does that stays on the device.
        self.buffers.set_straight(self.sampler.guide == Guide::None);
        let submitted = gpu.submit("rendering a frame", |encoder| {
            self.encode(encoder, view, listed.as_ref())?;
            let made = self.reconstruction.as_ref().map(DeviceReconstruction::frame_buffer);
            let frame = made.unwrap_or(self.buffers.frame());
            display.encode(encoder, frame, (&self.buffers, &self.parts))
        });
        self.buffers.set_straight(false);
        let (encoded, submission) = submitted?;
        let samples = match self.sampler.sampling {
            Sampling::Full => Some(self.sampler.size.pixels()),
            _ => listed.map(|listed| listed.list.len()),
        };
        let picture = display.take_off(view.index, samples, encoded, submission)?;
        self.display = Some(display);
        Ok(Some(DeviceFrame { index: view.index, picture, done }))
    }

    fn finish_display(&mut self) -> Result<Vec<DoneFrame>> {
        let mut all = Vec::new();
        while let Some(done) = self.display.as_mut().map_or(Ok(None), Display::land)? {
            all.push(done);
        }
        Ok(all)
    }

    fn reset(&mut self) {
        if let Some(reconstruction) = &mut self.reconstruction {
            reconstruction.reset();
        }
    }
}
