use super::frames::RenderedFrame;
use super::timings::{Timer, Timings};
use super::view::View;
use crate::motion::MotionFinder;
use crate::reconstruct::Seen;
use crate::{Reconstructor, RenderSettings, Result, Sampling};
use fovol_core::{Frame, FrameSize, SampleMask, SparseFrame};
use fovol_render::noise::Noise;

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

/// Samples of one frame, before reconstruction on the host.
pub struct Sampled {
    pub marched: Marched,
    pub mask: SampleMask,
    /// Number of marched pixels, repeated ones included.
    pub samples: usize,
    /// Number of repeated positions, if positions were drawn at random.
    pub lost: Option<usize>,
    /// Region in which the scene can be seen.
    pub seen: Seen,
    /// Full frame, if the device has reconstructed it already.
    pub made: Option<Frame>,
    /// Times so far; the total is not known yet.
    pub timings: Timings,
}

/// Pixels that rays were marched through.
pub enum Marched {
    /// Every pixel.
    Every(Frame),
    Some(SparseFrame),
}

impl Sampled {
    /// Samples of a frame with every pixel marched.
    pub fn full(frame: Frame) -> Self {
        let size = frame.size();
        Self::new(Marched::Every(frame), SampleMask::full(size), size.pixels())
    }

    /// Samples of the pixels of `mask`. `samples` counts repeated ones, too.
    pub fn sparse(sparse: SparseFrame, mask: SampleMask, samples: usize) -> Self {
        Self::new(Marched::Some(sparse), mask, samples)
    }

    fn new(marched: Marched, mask: SampleMask, samples: usize) -> Self {
        let seen = Seen::everything(mask.size());
        Self { marched, mask, samples, seen, lost: None, made: None, timings: Timings::default() }
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
        let Sampled { marched, mask, samples, lost, seen, made, mut timings } = sampled;
        let (sparse, frame, motion) = match marched {
            Marched::Every(frame) => {
                self.last = None;
                (None, made.unwrap_or(frame), None)
            }
            Marched::Some(sparse) => {
                let (frame, motion) = self.fill(view, &sparse, &seen, made, &mut timings)?;
                (Some(sparse), frame, motion)
            }
        };
        timings.total = started.ms();
        Ok(RenderedFrame { index: view.index, sparse, samples, mask, frame, motion, lost, timings })
    }

    /// Full frame of `sparse`, unless it was `made` already, and the motion of its pixels, if anything needs it.
    fn fill(
        &mut self,
        view: &View,
        sparse: &SparseFrame,
        seen: &Seen,
        made: Option<Frame>,
        timings: &mut Timings,
    ) -> Result<(Frame, Option<Vec<[f32; 2]>>)> {
        let timer = Timer::start();
        let reconstructs = self.reconstructor.is_active();
        let moves = self.finds_motion || (reconstructs && self.reconstructor.uses_motion());
        let motion = if moves { self.motion(view, sparse, seen) } else { None };
        let motion_ms = if moves { timer.ms() } else { 0.0 };
        let is_full = reconstructs || made.is_some();
        let frame = match made {
            Some(frame) => frame,
            None if reconstructs => {
                let frame = self.reconstructor.reconstruct_seen(sparse, motion.as_deref(), seen)?;
                (timings.motion, timings.reconstruct) = (motion_ms, timer.ms());
                frame
            }
            None => sparse.to_frame(),
        };
        self.remember(&frame, moves && is_full);
        Ok((frame, motion))
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

    /// Motion of every pixel of the frame `sparse` to the last frame.
    fn motion(&mut self, view: &View, sparse: &SparseFrame, seen: &Seen) -> Option<Vec<[f32; 2]>> {
        let motion = self.motion.find_in(seen.moving(view.size), sparse, &view.camera, self.last.as_ref());
        self.motion.remember(&view.camera, sparse);
        motion
    }
}
