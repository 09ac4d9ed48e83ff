use super::frames::RenderedFrame;
use super::timings::{Timer, Timings};
use super::view::View;
use crate::motion::{Depths, MotionFinder, Sparse};
use crate::reconstruct::Seen;
use crate::{Reconstructor, RenderSettings, Result, Sampling};
use fovol_core::{Frame, FrameSize, SampleList, SampleMask};
use fovol_render::noise::Noise;
use fovol_render::scene::RayResult;

/// Choice of the pixels to march, for frames of one size.
#[derive(Debug)]
pub struct Sampler {
    pub size: FrameSize,
    pub sampling: Sampling,
    pub noise: Noise,
    pub seed: u64,
}

impl Sampler {
    pub fn new(settings: &RenderSettings) -> Self {
        let RenderSettings { size, sampling, noise, seed, .. } = *settings;
        Self { size, sampling, noise: Noise::new(noise, seed), seed }
    }

    /// Takes over `settings`; noise tables that stay the same are kept, since they take time to make.
    pub fn change(&mut self, settings: &RenderSettings) {
        let anew = Self::new(settings);
        let is_same = (anew.noise.kind(), anew.seed) == (self.noise.kind(), self.seed);
        let noise = if is_same { self.noise.clone() } else { anew.noise };
        *self = Self { noise, ..anew };
    }
}

/// Marched pixels with their depths.
pub struct Listed {
    pub list: SampleList,
    /// Distance of each pixel from the eye, in units of the marched box; see [`RayResult::depth`].
    pub depths: Vec<f32>,
}

impl Listed {
    /// Pixels of `list` with the depths of their ray results `marched`.
    pub fn new(list: SampleList, marched: &[RayResult]) -> Self {
        Self { list, depths: marched.iter().map(|sample| sample.depth).collect() }
    }
}

/// Samples of one frame, before reconstruction on the host.
pub struct Sampled {
    pub sparse: Frame,
    pub mask: SampleMask,
    /// Marched pixels; `None` if every pixel was marched.
    pub listed: Option<Listed>,
    /// Number of repeated positions, if positions were drawn at random.
    pub lost: Option<usize>,
    /// Region in which the scene can be seen.
    pub seen: Seen,
    /// Full frame, if the device has reconstructed it already.
    pub made: Option<Frame>,
    /// Times so far; the total is not known yet.
    pub timings: Timings,
}

impl Sampled {
    /// Samples from a sparse frame and its mask.
    pub fn new(sparse: Frame, mask: SampleMask) -> Self {
        let seen = Seen::everything(sparse.size());
        let timings = Timings::default();
        Self { sparse, mask, seen, listed: None, lost: None, made: None, timings }
    }

    /// Samples of a frame with every pixel marched.
    pub fn full(frame: Frame) -> Self {
        let mask = SampleMask::full(frame.size());
        Self::new(frame, mask)
    }
}

/// Reconstruction on the CPU, with the motion that it needs.
#[derive(Debug)]
pub struct HostReconstruction {
    reconstructor: Reconstructor,
    /// Whether to find motion even if the reconstruction does not use it.
    pub finds_motion: bool,
    motion: MotionFinder,
    /// Last full frame, kept only while motion is found.
    last: Option<Frame>,
}

impl HostReconstruction {
    /// Reconstruction as `settings` ask for.
    pub fn new(settings: &RenderSettings) -> Result<Self> {
        let reconstructor = Reconstructor::new(settings, settings.size)?;
        Ok(Self::with(reconstructor))
    }

    /// Reconstruction that returns frames unchanged.
    #[cfg(feature = "gpu")]
    pub fn nothing() -> Self {
        Self::with(Reconstructor::nothing())
    }

    fn with(reconstructor: Reconstructor) -> Self {
        Self { reconstructor, finds_motion: false, motion: MotionFinder::default(), last: None }
    }

    /// Whether frames of `settings` need this reconstruction.
    #[cfg(feature = "gpu")]
    pub fn is_needed(&self, settings: &RenderSettings) -> bool {
        self.finds_motion || (settings.sampling != Sampling::Full && self.reconstructor.is_active())
    }

    pub fn reset(&mut self) {
        self.reconstructor.reset();
        self.motion.reset();
        self.last = None;
    }

    /// Reconstructs the frame of `sampled`. The timer `started` began with the frame.
    pub fn finish(&mut self, view: &View, sampled: Sampled, started: &Timer) -> Result<RenderedFrame> {
        let timer = Timer::start();
        let mut timings = sampled.timings;
        // Without a list every pixel was marched, and nothing is missing.
        let reconstructs = sampled.listed.is_some() && self.reconstructor.is_active();
        let moves = self.finds_motion || (reconstructs && self.reconstructor.uses_motion());
        let motion = if moves { self.motion(view, &sampled) } else { None };
        let motion_ms = if moves { timer.ms() } else { 0.0 };
        let is_full = reconstructs || sampled.made.is_some();
        let frame = match sampled.made {
            Some(frame) => frame,
            None if reconstructs => {
                let frame =
                    self.reconstructor.reconstruct_seen(&sampled.sparse, motion.as_deref(), &sampled.seen)?;
                (timings.motion, timings.reconstruct) = (motion_ms, timer.ms());
                frame
            }
            None => sampled.sparse.clone(),
        };
        self.remember(&frame, moves && is_full);
        timings.total = started.ms();
        Ok(RenderedFrame {
            index: view.index,
            sparse: sampled.sparse,
            samples: sampled.listed.map_or(view.size.pixels(), |listed| listed.list.len()),
            mask: sampled.mask,
            frame,
            motion,
            lost: sampled.lost,
            timings,
        })
    }

    /// Copies `frame` to the last frame if `needed`, into its old memory: allocating takes longer than copying.
    fn remember(&mut self, frame: &Frame, needed: bool) {
        match &mut self.last {
            Some(last) if needed && last.size() == frame.size() => {
                last.pixels_mut().copy_from_slice(frame.pixels());
            }
            last => *last = needed.then(|| frame.clone()),
        }
    }

    /// Motion of every pixel of the frame `sampled` to the last frame.
    fn motion(&mut self, view: &View, sampled: &Sampled) -> Option<Vec<[f32; 2]>> {
        let listed = sampled.listed.as_ref()?;
        let depths = Depths::new(&listed.list, &listed.depths);
        let now = Sparse { frame: &sampled.sparse, depths: &depths };
        let motion =
            self.motion.find_in(sampled.seen.moving(view.size), now, &view.camera, self.last.as_ref());
        self.motion.remember(&view.camera, depths);
        motion
    }
}
