use super::frames::{FrameGuide, RenderedFrame};
use super::timings::{Timer, Timings};
use super::view::View;
use crate::guide::{MarchedGuide, compose, importance_of_colours, importance_of_ratios, light_ratios};
use crate::motion::{Depths, MotionFinder};
use crate::reconstruct::Seen;
use crate::{Density, Guide, Reconstructor, RenderSettings, Result, Sampling};
use fovol_core::{Frame, FrameSize, SampleList, SampleMask, SparseFrame};
use fovol_render::Importance;
use fovol_render::cpu::{FewShadowRays, compact};
use fovol_render::noise::Noise;
use fovol_render::scene::RayResult;

/// Pixels of a sparse frame for each ray, about.
const SPARSE: usize = 12;

/// Choice of the pixels to march, for frames of one size.
#[derive(Debug)]
pub struct Sampler {
    pub size: FrameSize,
    pub sampling: Sampling,
    pub noise: Noise,
    pub seed: u64,
    pub guide: Guide,
    /// Shadow rays of each pixel, unless every sample has one.
    few: Option<u32>,
}

impl Sampler {
    pub fn new(settings: &RenderSettings) -> Self {
        let RenderSettings { size, sampling, noise, seed, shadow_rays, .. } = *settings;
        let noise = Noise::new(noise, seed);
        Self { size, sampling, noise, seed, guide: settings.guide_kind(), few: shadow_rays.few() }
    }

    /// Shadow rays of the pixels of frame number `index`, unless every sample has one.
    pub fn few_shadow_rays(&self, index: u32) -> Option<FewShadowRays<'_>> {
        self.few.map(|per_pixel| FewShadowRays { per_pixel, noise: self.noise.frame(index) })
    }

    /// About how many rays a frame has.
    pub fn expected_rays(&self) -> usize {
        let pixels = self.size.pixels();
        if self.sampling == Sampling::Full { pixels } else { pixels / SPARSE }
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
    /// Guide of the light ratio, if there is one.
    pub guide: Option<MarchedGuide>,
    /// Full frame, if the device has reconstructed it already.
    pub made: Option<Made>,
    /// Times so far; the total is not known yet.
    pub timings: Timings,
}

/// Full frame that a device has reconstructed.
pub struct Made {
    pub frame: Frame,
    /// Number of pixels that were marched for the guide alone.
    pub guide_samples: usize,
    /// Guide and light ratio, if they were asked for.
    pub guide: Option<FrameGuide>,
    /// Distances of every pixel that was marched, if they were asked for and there is a guide.
    pub depths: Option<Depths>,
}

/// Extras that the reconstruction on the host asks of a frame's samples. A processor has guide and motion at hand, a GPU
/// has to read them back.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "only a GPU reads guide and motion back"))]
pub struct Wanted<'a> {
    /// Importance of samples, if it is known.
    pub importance: Option<&'a Importance>,
    /// Whether to keep guide and light ratio.
    pub guide: bool,
    /// Whether to find motion.
    pub motion: bool,
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
        Self {
            marched,
            mask,
            samples,
            seen,
            guide: None,
            lost: None,
            made: None,
            timings: Timings::default(),
        }
    }
}

/// The pixels of `list`, which are those of `mask`, and their ray results `marched` in raster order, without repeated pixels.
pub fn in_raster_order(
    list: SampleList,
    marched: Vec<RayResult>,
    mask: &SampleMask,
) -> (SampleList, Vec<RayResult>) {
    match list.raster_order() {
        Some(order) => (compact(mask), order.iter().map(|at| marched[*at]).collect()),
        None => (list, marched),
    }
}

/// Full frame with what was found on the way.
struct Filled {
    frame: Frame,
    motion: Option<Vec<[f32; 2]>>,
    guide: Option<FrameGuide>,
}

/// Reconstruction on the CPU, with the motion that it needs.
#[derive(Debug)]
pub struct HostReconstruction {
    reconstructor: Reconstructor,
    /// Whether to find motion even if the reconstruction does not use it.
    pub finds_motion: bool,
    /// Whether frames keep their guide and light ratio.
    pub keeps_guide: bool,
    motion: MotionFinder,
    /// Last full frame, kept only while motion is found.
    last: Option<Frame>,
    density: Density,
    /// Importance of samples for the next frame, if densities are adaptive.
    importance: Option<Importance>,
}

impl HostReconstruction {
    /// Reconstruction as `settings` ask for.
    pub fn new(settings: &RenderSettings) -> Result<Self> {
        let reconstructor = Reconstructor::new(settings, settings.size)?;
        Ok(Self { density: settings.density_kind(), ..Self::with(reconstructor) })
    }

    /// Reconstruction that returns frames unchanged.
    #[cfg(feature = "gpu")]
    pub fn nothing() -> Self {
        Self::with(Reconstructor::nothing())
    }

    fn with(reconstructor: Reconstructor) -> Self {
        Self {
            reconstructor,
            finds_motion: false,
            keeps_guide: false,
            motion: MotionFinder::default(),
            last: None,
            density: Density::Fixed,
            importance: None,
        }
    }

    /// Whether frames of `settings` need this reconstruction.
    #[cfg(feature = "gpu")]
    pub fn is_needed(&self, settings: &RenderSettings) -> bool {
        self.finds_motion || (settings.sampling != Sampling::Full && self.reconstructor.is_active())
    }

    /// Keeps and finds whatever `other` does.
    pub fn keep_as(&mut self, other: &Self) {
        (self.finds_motion, self.keeps_guide) = (other.finds_motion, other.keeps_guide);
    }

    /// Extras that the samples of the next frame should come with.
    pub fn wanted(&self) -> Wanted<'_> {
        Wanted { importance: self.importance.as_ref(), guide: self.keeps_guide, motion: self.finds_motion }
    }

    pub fn reset(&mut self) {
        self.reconstructor.reset();
        self.motion.reset();
        self.last = None;
        self.importance = None;
    }

    /// Reconstructs the frame of `sampled`. The timer `started` began with the frame.
    pub fn finish(&mut self, view: &View, sampled: Sampled, started: &Timer) -> Result<RenderedFrame> {
        let Sampled { marched, mask, samples, lost, seen, guide, made, mut timings } = sampled;
        let guide_samples = match (&guide, &made) {
            (Some(guide), _) => guide.marched(),
            (None, made) => made.as_ref().map_or(0, |made| made.guide_samples),
        };
        let (sparse, filled) = match marched {
            Marched::Every(frame) => {
                self.last = None;
                (None, Filled { frame: made.map_or(frame, |made| made.frame), motion: None, guide: None })
            }
            Marched::Some(sparse) => {
                let filled = self.fill(view, &sparse, &seen, (guide, made), &mut timings)?;
                (Some(sparse), filled)
            }
        };
        let Filled { frame, motion, guide } = filled;
        timings.total = started.ms();
        let index = view.index;
        Ok(RenderedFrame { index, sparse, samples, mask, frame, motion, guide_samples, guide, lost, timings })
    }

    /// Fills `sparse`, unless the frame was `made` already, and finds the motion of its pixels, if anything needs it.
    fn fill(
        &mut self,
        view: &View,
        sparse: &SparseFrame,
        seen: &Seen,
        (guide, made): (Option<MarchedGuide>, Option<Made>),
        timings: &mut Timings,
    ) -> Result<Filled> {
        let timer = Timer::start();
        let reconstructs = self.reconstructor.is_active();
        let moves = self.finds_motion || (reconstructs && self.reconstructor.uses_motion());
        let depths = match (&guide, &made) {
            (Some(guide), _) if moves => Some(Depths::new(sparse).with(guide.distances())),
            (None, Some(made)) => made.depths.clone(),
            _ => None,
        };
        let motion = if moves { self.motion(view, sparse, seen, depths.as_ref()) } else { None };
        let motion_ms = if moves { timer.ms() } else { 0.0 };
        // Motion by the guide does not look at the last frame.
        let is_full = (reconstructs || made.is_some()) && depths.is_none() && guide.is_none();
        let (frame, guide) = match (made, guide) {
            (Some(made), _) => (made.frame, made.guide),
            (None, _) if !reconstructs => (sparse.to_frame(), None),
            (None, None) => {
                let frame = self.reconstructor.reconstruct_seen(sparse, motion.as_deref(), seen)?;
                let region = seen.region.filter(|_| self.density == Density::Adaptive);
                self.importance = region.map(|region| importance_of_colours(&frame, region));
                (frame, None)
            }
            (None, Some(guide)) => self.fill_light_ratio(sparse, motion.as_deref(), seen, guide)?,
        };
        if reconstructs {
            (timings.motion, timings.reconstruct) = (motion_ms, timer.ms());
        }
        self.remember(&frame, moves && is_full);
        Ok(Filled { frame, motion, guide })
    }

    /// Fills the light ratios of `sparse` and multiplies them with the guide.
    fn fill_light_ratio(
        &mut self,
        sparse: &SparseFrame,
        motion: Option<&[[f32; 2]]>,
        seen: &Seen,
        marched: MarchedGuide,
    ) -> Result<(Frame, Option<FrameGuide>)> {
        let guide = marched.into_upsampled();
        let ratios = light_ratios(sparse, &guide, seen.background);
        // Beyond the visible region there is no light to lose.
        let beyond = Seen { background: [1.0; 3], ..*seen };
        let mut frame = self.reconstructor.reconstruct_seen(&ratios, motion, &beyond)?;
        self.importance = (self.density == Density::Adaptive).then(|| importance_of_ratios(&frame, &guide));
        let ratio = self.keeps_guide.then(|| frame.clone());
        compose(&mut frame, &guide, sparse, seen.background);
        Ok((frame, ratio.map(|ratio| FrameGuide { guide, ratio })))
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

    /// Motion of every pixel of the frame `sparse` to the last frame: by `depths`, if they are known at many pixels.
    fn motion(
        &mut self,
        view: &View,
        sparse: &SparseFrame,
        seen: &Seen,
        depths: Option<&Depths>,
    ) -> Option<Vec<[f32; 2]>> {
        let region = seen.moving(view.size);
        let motion = match depths {
            Some(depths) => self.motion.find_by_depths(region, depths, &view.camera),
            None => self.motion.find_in(region, sparse, &view.camera, self.last.as_ref()),
        };
        self.motion.remember(&view.camera, sparse);
        motion
    }
}
