use super::view::View;
use super::{RenderedFrame, Timer, Timings};
use crate::motion::{Depths, MotionFinder, Sparse};
use crate::window::Seen;
use crate::{Reconstructor, RenderSettings, Result, Sampling};
use fovol_core::{Frame, FrameSize, SampleList, SampleMask};
use fovol_render::noise::Noise;
use fovol_render::scene::RayResult;

/// Which pixels of the frames of one size are marched.
#[derive(Debug)]
pub struct Sampler {
    pub size: FrameSize,
    pub sampling: Sampling,
    pub noise: Noise,
    pub seed: u64,
}

impl Sampler {
    pub fn new(settings: &RenderSettings) -> Self {
        let seed = settings.seed.unwrap_or(0);
        Self {
            size: settings.frame_size(),
            sampling: settings.sampling(),
            noise: Noise::new(settings.noise.unwrap_or_default(), seed),
            seed,
        }
    }

    /// Goes on as `settings` say; noise that takes time to make stays where it is the same.
    pub fn change(&mut self, settings: &RenderSettings) {
        let anew = Self::new(settings);
        let is_same = (anew.noise.kind(), anew.seed) == (self.noise.kind(), self.seed);
        let noise = if is_same { self.noise.clone() } else { anew.noise };
        *self = Self { noise, ..anew };
    }
}

/// Pixels that were marched.
pub struct Listed {
    pub list: SampleList,
    /// How far away what their rays met is, see [`RayResult`].
    pub depths: Vec<f32>,
}

impl Listed {
    /// Those of `list` with what their rays brought back.
    pub fn new(list: SampleList, marched: &[RayResult]) -> Self {
        Self { list, depths: marched.iter().map(|sample| sample.depth).collect() }
    }
}

/// What was marched of a frame.
pub struct Sampled {
    pub sparse: Frame,
    pub mask: SampleMask,
    /// The pixels that were marched; `None` where all were marched.
    pub listed: Option<Listed>,
    /// How many positions repeat others, where they were drawn.
    pub lost: Option<usize>,
    /// What can be seen of the scene.
    pub seen: Seen,
    /// What was made of it already.
    pub made: Option<Frame>,
    /// What all that took; the total is not known yet.
    pub timings: Timings,
}

impl Sampled {
    /// A sparse frame, and where it was sampled.
    pub fn new(sparse: Frame, mask: SampleMask) -> Self {
        let seen = Seen::everything(sparse.size());
        let timings = Timings::default();
        Self { sparse, mask, seen, listed: None, lost: None, made: None, timings }
    }

    /// A whole frame.
    pub fn full(frame: Frame) -> Self {
        let mask = SampleMask::full(frame.size());
        Self::new(frame, mask)
    }
}

/// What makes frames of samples on the processor.
#[derive(Debug)]
pub struct HostReconstruction {
    reconstructor: Reconstructor,
    /// Whether motion is found where nothing uses it.
    pub finds_motion: bool,
    motion: MotionFinder,
    /// The last full frame, where motion is found.
    last: Option<Frame>,
}

impl HostReconstruction {
    /// What `settings` say.
    pub fn new(settings: &RenderSettings) -> Result<Self> {
        let reconstructor = Reconstructor::new(settings, settings.frame_size())?;
        Ok(Self::with(reconstructor))
    }

    /// What leaves frames as they are.
    #[cfg(feature = "gpu")]
    pub fn nothing() -> Self {
        Self::with(Reconstructor::nothing())
    }

    fn with(reconstructor: Reconstructor) -> Self {
        Self { reconstructor, finds_motion: false, motion: MotionFinder::default(), last: None }
    }

    /// Whether frames made as `settings` say need it.
    #[cfg(feature = "gpu")]
    pub fn is_needed(&self, settings: &RenderSettings) -> bool {
        self.finds_motion || (settings.sampling() != Sampling::Full && self.reconstructor.is_active())
    }

    pub fn reset(&mut self) {
        self.reconstructor.reset();
        self.motion.reset();
        self.last = None;
    }

    /// The frame of `sampled`, whose making began with `started`.
    pub fn finish(&mut self, view: &View, sampled: Sampled, started: &Timer) -> Result<RenderedFrame> {
        let timer = Timer::start();
        let mut timings = sampled.timings;
        // Every pixel is there already where all were marched.
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

    /// Keeps a copy of `frame` if it is `needed`, in the memory of the one before: new memory takes longer than copying.
    fn remember(&mut self, frame: &Frame, needed: bool) {
        match &mut self.last {
            Some(last) if needed && last.size() == frame.size() => {
                last.pixels_mut().copy_from_slice(frame.pixels());
            }
            last => *last = needed.then(|| frame.clone()),
        }
    }

    /// Where every pixel of what was `sampled` was in the last frame.
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
