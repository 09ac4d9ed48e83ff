//! Timed marching alone, without read-back and without a pipeline around it.

use super::repeat::Lap;
use crate::thread_pool::thread_pool;
use anyhow::Result;
use fovolnet::core::memory::{Estimate, SMALLER_BOTH};
use fovolnet::core::{Camera, Fovea, Frame, FrameSize, Pixel, Scene};
use fovolnet::render::cpu::march::SampleCount;
use fovolnet::render::cpu::{
    RenderOptions, Renderer, Simd, available_simd, best_simd, compact, direct, mask, sparse_frame,
};
use fovolnet::render::noise::Noise;
use fovolnet::{Machine, OpenDevice, SpeedSettings};
use std::time::Instant;

/// Parameters that choose the sampled pixels.
pub struct Sampled<'a> {
    pub fovea: &'a Fovea,
    pub noise: &'a Noise,
    /// Frame number.
    pub frame: u32,
}

/// Ray marcher to measure. Each call returns the time of its frame once it is finished.
pub trait Marching {
    /// Machine as the marcher uses it.
    fn machine(&self) -> Machine;
    /// Names of the compared ways of marching: instruction sets, or the device alone.
    fn ways(&self) -> Vec<String>;
    /// Selects the way with index `way`, and whether empty space is skipped.
    fn choose(&mut self, way: usize, skip_empty: bool);
    /// Marches every pixel to a picture.
    fn picture(&mut self, camera: &Camera) -> Result<Frame>;
    /// Marches every pixel. Also returns the number of samples, if known.
    fn full(&mut self, camera: &Camera) -> Result<(Lap, Option<SampleCount>)>;
    /// Makes a mask, compacts it, marches the list and sparse_frames the results.
    fn compact(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap>;
    /// Makes a mask and marches the full grid, where rays of unsampled pixels end at once.
    fn reject(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap>;
    /// Marches positions drawn from the density. Also returns the fraction that repeats others.
    fn direct(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<(Lap, f64)>;
}

/// Prepares `scene` on the device that `speed` asks for.
pub fn marching(scene: &Scene, speed: &SpeedSettings, size: FrameSize) -> Result<Box<dyn Marching>> {
    match speed.device().open()? {
        OpenDevice::Cpu => Ok(Box::new(CpuMarching::new(scene, speed, size)?)),
        #[cfg(feature = "gpu")]
        OpenDevice::Gpu(gpu) => Ok(Box::new(on_gpu::GpuMarching::new(&gpu, scene, speed, size)?)),
    }
}

struct CpuMarching {
    renderer: Renderer,
    size: FrameSize,
    simds: Vec<Simd>,
    pool: rayon::ThreadPool,
}

impl CpuMarching {
    fn new(scene: &Scene, speed: &SpeedSettings, size: FrameSize) -> Result<Self> {
        let needed = Renderer::estimate(scene, Estimate::new(format!("marching frames of {size}")));
        let frame = size.pixels() * (size_of::<[f32; 4]>() + size_of::<Pixel>() + size_of::<[f32; 3]>());
        needed.with("frames", frame as u64).check(SMALLER_BOTH)?;
        let pool = thread_pool(speed.threads.unwrap_or(0))?;
        let simds = Simd::chosen().map_or_else(fast_ones, |_| vec![speed.simd()]);
        let options = RenderOptions { simd: speed.simd(), skip_empty: true };
        Ok(Self { renderer: pool.install(|| Renderer::new(scene, options))?, size, simds, pool })
    }
}

/// Every instruction set except plain scalar code, which takes minutes.
fn fast_ones() -> Vec<Simd> {
    available_simd().into_iter().filter(|&simd| simd != Simd::Scalar).collect()
}

impl Marching for CpuMarching {
    fn machine(&self) -> Machine {
        Machine::this(self.pool.current_num_threads(), self.renderer.options().simd)
    }

    fn ways(&self) -> Vec<String> {
        self.simds.iter().map(ToString::to_string).collect()
    }

    fn choose(&mut self, way: usize, skip_empty: bool) {
        self.renderer.set_options(RenderOptions { simd: self.simds[way], skip_empty });
    }

    fn picture(&mut self, camera: &Camera) -> Result<Frame> {
        Ok(self.pool.install(|| self.renderer.march_full(camera, self.size)).0)
    }

    fn full(&mut self, camera: &Camera) -> Result<(Lap, Option<SampleCount>)> {
        let started = Instant::now();
        let (_, count) = self.pool.install(|| self.renderer.march_full(camera, self.size));
        Ok((Lap::since(started), Some(count)))
    }

    fn compact(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap> {
        let started = Instant::now();
        self.pool.install(|| {
            let list = compact(&mask(sampled.fovea, self.size, sampled.noise, sampled.frame));
            let (marched, _) = self.renderer.march_list(camera, &list);
            drop(sparse_frame(list, &marched));
        });
        Ok(Lap::since(started))
    }

    fn reject(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap> {
        let started = Instant::now();
        self.pool.install(|| {
            let mask = mask(sampled.fovea, self.size, sampled.noise, sampled.frame);
            drop(self.renderer.march_rejecting(camera, &mask, None));
        });
        Ok(Lap::since(started))
    }

    fn direct(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<(Lap, f64)> {
        let started = Instant::now();
        let lost = self.pool.install(|| {
            let drawn = direct(sampled.fovea, self.size, 0, sampled.frame);
            let (marched, _) = self.renderer.march_list(camera, &drawn.list);
            drop(sparse_frame(drawn.list, &marched));
            drawn.lost as f64 / marched.len().max(1) as f64
        });
        Ok((Lap::since(started), lost))
    }
}

#[cfg(feature = "gpu")]
mod on_gpu {
    use super::*;
    use fovolnet::gpu::Gpu;
    use fovolnet::render::gpu::{FrameBuffers, MaskSource, Renderer, Sampling};

    pub struct GpuMarching {
        gpu: Gpu,
        renderer: Renderer,
        buffers: FrameBuffers,
    }

    impl GpuMarching {
        pub fn new(gpu: &Gpu, scene: &Scene, speed: &SpeedSettings, size: FrameSize) -> Result<Self> {
            let filtering = speed.filtering.unwrap_or_default();
            let renderer = Renderer::with_filtering(gpu, scene, filtering)?;
            let buffers = renderer.frame_buffers(size)?;
            Ok(Self { gpu: gpu.clone(), renderer, buffers })
        }

        fn render(&mut self, camera: &Camera, sampling: Sampling<'_>) -> Result<Lap> {
            let started = Instant::now();
            self.renderer.render(&mut self.buffers, camera, sampling)?;
            self.gpu.wait()?;
            let lap = Lap::since(started);
            let times = self.buffers.read_times()?;
            Ok(Lap { device_ms: times.map(|times| times.iter().map(|time| time.ms).sum()), ..lap })
        }
    }

    impl<'a> From<&Sampled<'a>> for MaskSource<'a> {
        fn from(sampled: &Sampled<'a>) -> Self {
            Self { fovea: sampled.fovea, noise: sampled.noise, frame: sampled.frame }
        }
    }

    impl Marching for GpuMarching {
        fn machine(&self) -> Machine {
            let machine = Machine::this(rayon::current_num_threads(), best_simd());
            Machine { gpu: Some(self.gpu.info().name), ..machine }
        }

        fn ways(&self) -> Vec<String> {
            vec!["gpu".into()]
        }

        fn choose(&mut self, _: usize, skip_empty: bool) {
            self.renderer.set_skip_empty(skip_empty);
        }

        fn picture(&mut self, camera: &Camera) -> Result<Frame> {
            self.render(camera, Sampling::Full)?;
            Ok(self.buffers.read_frame()?)
        }

        fn full(&mut self, camera: &Camera) -> Result<(Lap, Option<SampleCount>)> {
            Ok((self.render(camera, Sampling::Full)?, None))
        }

        fn compact(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap> {
            self.render(camera, Sampling::Compact(sampled.into()))
        }

        fn reject(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<Lap> {
            self.render(camera, Sampling::Reject(sampled.into()))
        }

        fn direct(&mut self, camera: &Camera, sampled: &Sampled<'_>) -> Result<(Lap, f64)> {
            let drawn = direct(sampled.fovea, self.buffers.size(), 0, sampled.frame);
            let lap = self.render(camera, Sampling::List(&drawn.list))?;
            Ok((lap, drawn.lost as f64 / drawn.list.len().max(1) as f64))
        }
    }
}
