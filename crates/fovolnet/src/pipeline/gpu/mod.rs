use super::Timer;
use super::sampled::{Listed, Sampled, Sampler};
use super::view::View;
use crate::{Result, Sampling};
use fovol_core::{Camera, Frame, Pixel, SampleList, Scene};
use fovol_gpu::Gpu;
use fovol_render::cpu::{compact, direct, mask_of, scatter};
use fovol_render::gpu::{self, FrameBuffers, MaskSource, Renderer, Stage};

/// Rays on a graphics processor.
#[derive(Debug)]
pub struct GpuMarcher {
    renderer: Renderer,
    buffers: FrameBuffers,
    sampler: Sampler,
}

impl GpuMarcher {
    pub fn new(gpu: &Gpu, scene: &Scene, skip_empty: bool, sampler: Sampler) -> Result<Self> {
        let mut renderer = Renderer::new(gpu, scene)?;
        renderer.set_skip_empty(skip_empty);
        let buffers = renderer.frame_buffers(sampler.size)?;
        Ok(Self { renderer, buffers, sampler })
    }

    /// What it runs on.
    pub fn gpu(&self) -> &Gpu {
        self.renderer.gpu()
    }

    /// The frame with every pixel marched.
    pub fn march_full(&mut self, camera: &Camera) -> Result<Frame> {
        self.renderer.render(&mut self.buffers, camera, gpu::Sampling::Full)?;
        Ok(self.buffers.read_frame()?)
    }

    /// Only what was sampled comes back from the device, but where it was not packed there.
    pub fn sample(&mut self, view: &View) -> Result<Sampled> {
        let timer = Timer::start();
        let Sampler { size, sampling, noise, seed } = &self.sampler;
        let source = MaskSource { fovea: &view.fovea, noise, frame: view.index };
        match sampling {
            Sampling::Full => {
                let frame = self.march_full(&view.camera)?;
                let (_, march_ms) = self.times(&timer)?;
                Ok(Sampled::full(frame, march_ms))
            }
            Sampling::Reject => {
                self.renderer.render(&mut self.buffers, &view.camera, gpu::Sampling::Reject(source))?;
                self.rejected(&timer)
            }
            Sampling::Compact => {
                self.renderer.render(&mut self.buffers, &view.camera, gpu::Sampling::Compact(source))?;
                self.listed(self.buffers.read_list()?, &timer)
            }
            Sampling::Direct => {
                let drawn = direct(&view.fovea, *size, *seed, view.index);
                self.renderer.render(&mut self.buffers, &view.camera, gpu::Sampling::List(&drawn.list))?;
                Ok(self.listed(drawn.list, &timer)?.losing(drawn.lost))
            }
        }
    }

    /// The samples of `list`, the last that was marched.
    fn listed(&self, list: SampleList, timer: &Timer) -> Result<Sampled> {
        let marched = self.buffers.read_samples()?;
        let (mask_ms, march_ms) = self.times(timer)?;
        let (sparse, mask) = (scatter(&list, &marched), mask_of(&list));
        let listed = Some(Listed::new(list, &marched));
        Ok(Sampled { sparse, mask, listed, lost: None, mask_ms, march_ms })
    }

    /// The samples of the last mask, which were marched where they lie.
    fn rejected(&self, timer: &Timer) -> Result<Sampled> {
        let (sparse, mask) = (self.buffers.read_frame()?, self.buffers.read_mask()?);
        let inverse = self.buffers.read_inverse_depths()?;
        let (mask_ms, march_ms) = self.times(timer)?;
        let list = compact(&mask);
        let depth = |pixel: &Pixel| 1.0 / inverse[pixel.index(mask.size().width)];
        let depths = list.pixels().iter().map(depth).collect();
        let listed = Some(Listed { list, depths });
        Ok(Sampled { sparse, mask, listed, lost: None, mask_ms, march_ms })
    }

    /// Milliseconds of mask and march: on the device where it tells, else all that passed since `timer` started as march.
    fn times(&self, timer: &Timer) -> Result<(f64, f64)> {
        let Some(times) = self.buffers.read_times()? else { return Ok((0.0, timer.ms())) };
        let of = |wanted: [Stage; 2]| {
            times.iter().filter(|time| wanted.contains(&time.stage)).map(|time| time.ms).sum::<f64>()
        };
        Ok((of([Stage::Mask, Stage::Compact]), of([Stage::March, Stage::Scatter])))
    }
}
