use super::frames::{DeviceFrame, DoneFrame};
use super::marcher::Marcher;
use super::sampled::{HostReconstruction, Sampled, Sampler};
use super::timings::{Timer, Timings};
use super::view::View;
use crate::reconstruct::reconstructs;
use crate::{RenderSettings, Result, Sampling, SpeedSettings};
use display::Display;
use fovol_core::{Camera, Frame, FrameSize, Pixel, SampleList, Scene, SparseFrame};
use fovol_gpu::{Gpu, Timing};
use fovol_render::cpu::{DirectSamples, compact, direct, mask_of, sparse_frame};
use fovol_render::gpu::{self, FrameBuffers, MaskSource, Renderer};
use fovol_render::scene::RayResult;
use fovol_render::{Filtering, Importance};
use part::{Part, add_stage};
use reconstruction::DeviceReconstruction;
use std::time::Duration;

mod display;
mod motion;
mod part;
mod reconstruction;

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
}

impl GpuMarcher {
    pub fn new(gpu: &Gpu, scene: &Scene, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let sampler = Sampler::new(settings);
        let filtering = speed.filtering.unwrap_or_default();
        let mut renderer = Renderer::with_filtering(gpu, scene, filtering)?;
        renderer.set_skip_empty(!speed.no_skip);
        let buffers = renderer.frame_buffers(sampler.size)?;
        let reconstruction = DeviceReconstruction::new(gpu, settings, &buffers)?;
        let parts = Timing::new(gpu, Part::COUNT);
        Ok(Self { renderer, buffers, sampler, reconstruction, parts, display: None })
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
        renderer.with_exact_shadows(|renderer| renderer.render(buffers, camera, sampling))?;
        Ok(())
    }

    /// Random positions of the frame of `view`, if the sampling draws them.
    fn drawn(&self, view: &View) -> Option<DirectSamples> {
        let Sampler { size, sampling, seed, .. } = &self.sampler;
        (*sampling == Sampling::Direct).then(|| direct(&view.fovea, *size, *seed, view.index))
    }

    /// Encodes a frame into `encoder`, at the positions `drawn` if there are any.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        drawn: Option<&DirectSamples>,
    ) -> Result<()> {
        let Sampler { sampling, noise, .. } = &self.sampler;
        let source = MaskSource { fovea: &view.fovea, noise, frame: view.index };
        let sampling = match (sampling, drawn) {
            (_, Some(drawn)) => gpu::Sampling::List(&drawn.list),
            (Sampling::Full, _) => gpu::Sampling::Full,
            (Sampling::Reject, _) => gpu::Sampling::Reject(source),
            _ => gpu::Sampling::Compact(source),
        };
        self.renderer.encode(encoder, &mut self.buffers, &view.camera, sampling)?;
        self.parts.begin();
        if let Some(reconstruction) = &mut self.reconstruction {
            reconstruction.encode(encoder, &self.buffers, view, &mut self.parts)?;
        }
        self.parts.end(encoder);
        Ok(())
    }

    /// Samples of the last list: of the positions `drawn`, or of the list that the device compacted from its mask.
    fn listed(&self, drawn: Option<DirectSamples>) -> Result<Sampled> {
        let lost = drawn.as_ref().map(|drawn| drawn.lost);
        let list = drawn.map_or_else(|| self.buffers.read_list(), |drawn| Ok(drawn.list))?;
        let marched = self.buffers.read_samples()?;
        let mask = mask_of(&list);
        Ok(Sampled { lost, ..Sampled::sparse(sparse_frame(list, &marched), mask, marched.len()) })
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

    /// Times of the last frame's stages on the device. Without timestamps the whole time `done_ms` counts as march.
    fn timings(&self, done_ms: f64) -> Result<Timings> {
        let (Some(stages), Some(parts)) = (self.buffers.read_times()?, self.parts.read(self.gpu())?) else {
            return Ok(Timings { march: done_ms, ..Timings::default() });
        };
        let mut timings = Timings::default();
        stages.iter().for_each(|time| add_stage(&mut timings, time.stage, time.ms));
        parts.iter().for_each(|time| time.stage.add(&mut timings, time.ms));
        Ok(timings)
    }
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
        if reconstructs(settings) {
            return Ok(HostReconstruction::nothing());
        }
        HostReconstruction::new(settings)
    }

    fn change(&mut self, scene: &Scene, settings: &RenderSettings, reconstructs_alike: bool) -> Result<()> {
        let size = settings.size;
        let resized = size != self.sampler.size;
        let buffers = resized.then(|| self.renderer.frame_buffers(size)).transpose()?;
        let buffers_then = buffers.as_ref().unwrap_or(&self.buffers);
        let gpu = self.renderer.gpu();
        let anew = (!reconstructs_alike).then(|| DeviceReconstruction::new(gpu, settings, buffers_then));
        let anew = anew.transpose()?;
        self.renderer.set_scene(scene)?;
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
        self.renderer.render(&mut self.buffers, camera, gpu::Sampling::List(list))?;
        Ok(self.buffers.read_samples()?)
    }

    fn march_list_exactly(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        self.render_exactly(camera, gpu::Sampling::List(list))?;
        Ok(self.buffers.read_samples()?)
    }

    /// Frames have the size of the settings.
    fn reference(&mut self, camera: &Camera, _: FrameSize) -> Result<Frame> {
        self.render_exactly(camera, gpu::Sampling::Full)?;
        Ok(self.buffers.read_frame()?)
    }

    /// Renders a frame and reads it back: the samples, and the full frame if it was reconstructed on the device.
    fn sample(&mut self, view: &View, _: Option<&Importance>) -> Result<Sampled> {
        let timer = Timer::start();
        let drawn = self.drawn(view);
        self.gpu()
            .clone()
            .submit("rendering a frame", |encoder| self.encode(encoder, view, drawn.as_ref()))?;
        self.gpu().wait()?;
        let timings = self.timings(timer.ms())?;
        let size = self.sampler.size;
        let made = self.reconstruction.as_ref().map(|made| made.read_frame(self.gpu(), size));
        let sampled = match self.sampler.sampling {
            Sampling::Full => Sampled::full(self.buffers.read_frame()?),
            Sampling::Reject => self.rejected()?,
            Sampling::Direct | Sampling::Compact => self.listed(drawn)?,
        };
        Ok(Sampled { made: made.transpose()?, timings, ..sampled })
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
        let drawn = self.drawn(view);
        let (encoded, submission) = gpu.submit("rendering a frame", |encoder| {
            self.encode(encoder, view, drawn.as_ref())?;
            let made = self.reconstruction.as_ref().map(DeviceReconstruction::frame_buffer);
            let frame = made.unwrap_or(self.buffers.frame());
            display.encode(encoder, frame, (&self.buffers, &self.parts))
        })?;
        let samples = match self.sampler.sampling {
            Sampling::Full => Some(self.sampler.size.pixels()),
            _ => drawn.map(|drawn| drawn.list.len()),
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
