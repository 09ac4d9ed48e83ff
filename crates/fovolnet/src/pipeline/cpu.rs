#[cfg(feature = "gpu")]
use super::frames::{DeviceFrame, DoneFrame};
use super::marcher::Marcher;
use super::sampled::{HostReconstruction, Marched, Sampled, Sampler, Wanted, in_raster_order};
use super::timings::{Timer, Timings};
use super::view::View;
use crate::guide::{GuidePixel, MarchedGuide, guide_pixel};
use crate::reconstruct::Seen;
use crate::{Guide, RenderSettings, Result, Sampling};
use fovol_core::{Camera, Frame, FrameSize, Region, SampleList, SampleMask, Scene, ShadowMode, SparseFrame};
use fovol_render::Importance;
use fovol_render::cpu::march::SampleCount;
use fovol_render::cpu::{self, RenderOptions, Renderer, compact, direct, mask_of, sparse_frame};
use fovol_render::scene::RayResult;
use std::time::Duration;

/// Ray marcher of the pipeline on the CPU.
#[derive(Debug)]
pub struct CpuMarcher {
    renderer: Renderer,
    sampler: Sampler,
}

impl CpuMarcher {
    pub fn new(scene: &Scene, options: RenderOptions, sampler: Sampler) -> Result<Self> {
        Ok(Self { renderer: Renderer::new(scene, options)?, sampler })
    }

    /// Samples of the frame of `view`, and their guide pixels.
    fn marched(&self, view: &View, important: Option<(&Importance, Region)>) -> (Sampled, Vec<GuidePixel>) {
        let size = self.sampler.size;
        let few = self.sampler.few_shadow_rays(view.index);
        match self.sampler.sampling {
            Sampling::Full => {
                let timer = Timer::start();
                let (frame, _) = self.renderer.march_full_with(&view.camera, size, few.as_ref());
                let timings = Timings { march: timer.ms(), ..Timings::default() };
                (Sampled { timings, ..Sampled::full(frame) }, Vec::new())
            }
            Sampling::Reject => {
                let timer = Timer::start();
                let mask = self.mask(view);
                let timings = Timings { mask: timer.ms(), ..Timings::default() };
                let timer = Timer::start();
                let (list, marched, _) = self.renderer.march_rejecting(&view.camera, &mask, few.as_ref());
                sampled(list, marched, Some(mask), (timer, timings))
            }
            Sampling::Direct => {
                let timer = Timer::start();
                let drawn = direct(&view.fovea, size, self.sampler.seed, view.index);
                let timings = Timings { mask: timer.ms(), ..Timings::default() };
                let (sampled, guides) = self.listed(view, drawn.list, None, timings);
                (Sampled { lost: Some(drawn.lost), ..sampled }, guides)
            }
            Sampling::Compact => {
                let timer = Timer::start();
                let mask = match important {
                    Some(important) => self.adaptive_mask(view, important),
                    None => self.mask(view),
                };
                let mask_ms = timer.ms();
                let list = compact(&mask);
                let both_ms = timer.ms();
                let timings = Timings { mask: both_ms, compact: both_ms - mask_ms, ..Timings::default() };
                self.listed(view, list, Some(mask), timings)
            }
        }
    }

    /// Guide of the frame of `view` with the samples `sparse`, if there is to be one.
    fn guide(
        &mut self,
        view: &View,
        sparse: &SparseFrame,
        region: Region,
        of_samples: &[GuidePixel],
    ) -> Result<Option<MarchedGuide>> {
        let Some(grid) = self.sampler.guide.grid(view.index, region, view.size) else { return Ok(None) };
        let (renderer, camera) = (&mut self.renderer, &view.camera);
        if self.sampler.guide == Guide::Cached {
            let march = |list: &SampleList| {
                let marched = renderer.march_list_with_cached_shadows(camera, list);
                Ok(marched.map_err(fovol_core::Error::from)?.0)
            };
            return MarchedGuide::with_cached_shadows(grid, sparse, march).map(Some);
        }
        let march = |list: &SampleList| Ok(renderer.march_list_without_shadows(camera, list).0);
        MarchedGuide::new(grid, sparse, of_samples, march).map(Some)
    }

    fn adaptive_mask(&self, view: &View, important: (&Importance, Region)) -> SampleMask {
        cpu::adaptive_mask(&view.fovea, self.sampler.size, &self.sampler.noise, view.index, important)
    }

    fn mask(&self, view: &View) -> SampleMask {
        cpu::mask(&view.fovea, self.sampler.size, &self.sampler.noise, view.index)
    }

    /// Marches `list`. `timings` has the times of making the list.
    fn listed(
        &self,
        view: &View,
        list: SampleList,
        mask: Option<SampleMask>,
        timings: Timings,
    ) -> (Sampled, Vec<GuidePixel>) {
        let timer = Timer::start();
        let few = self.sampler.few_shadow_rays(view.index);
        let (marched, _) = self.renderer.march_list_with(&view.camera, &list, few.as_ref());
        sampled(list, marched, mask, (timer, timings))
    }
}

impl Marcher for CpuMarcher {
    fn gpu_name(&self) -> Option<String> {
        None
    }

    fn shadow_grid_time(&self) -> Duration {
        self.renderer.shadow_grid_time()
    }

    fn cached_shadows_time(&self) -> Option<Duration> {
        self.renderer.cached_shadows_time()
    }

    fn host_reconstruction(&self, settings: &RenderSettings) -> Result<HostReconstruction> {
        HostReconstruction::new(settings)
    }

    fn change(&mut self, scene: &Scene, settings: &RenderSettings, _: bool) -> Result<()> {
        self.renderer.change_scene(scene)?;
        self.sampler.change(settings);
        Ok(())
    }

    fn march_list(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        Ok(self.renderer.march_list(camera, list).0)
    }

    fn march_list_exactly(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        Ok(self.renderer.with_exact_shadows(|renderer| renderer.march_list(camera, list).0))
    }

    fn march_as(
        &mut self,
        how: (ShadowMode, f64),
        camera: &Camera,
        list: &SampleList,
    ) -> Result<Option<(Vec<RayResult>, Option<SampleCount>)>> {
        let marched = self.renderer.march_list_as(how, camera, list);
        let (rays, samples) = marched.map_err(fovol_core::Error::from)?;
        Ok(Some((rays, Some(samples))))
    }

    fn visible_region(&self, camera: &Camera, size: FrameSize) -> Option<Region> {
        self.renderer.visible_region(camera, size)
    }

    fn reference(&mut self, camera: &Camera, size: FrameSize) -> Result<Frame> {
        Ok(self.renderer.with_exact_shadows(|renderer| renderer.march_full(camera, size).0))
    }

    fn sample(&mut self, view: &View, wanted: Wanted<'_>) -> Result<Sampled> {
        let region = self.renderer.visible_region(&view.camera, view.size);
        let seen = Seen { region, background: self.renderer.background() };
        let important = wanted.importance.zip(seen.region);
        self.renderer.expect_rays(self.sampler.expected_rays());
        let (mut sampled, of_samples) = self.marched(view, important);
        sampled.seen = seen;
        if let (Marched::Some(sparse), Some(region)) = (&sampled.marched, seen.region) {
            let timer = Timer::start();
            sampled.guide = self.guide(view, sparse, region, &of_samples)?;
            sampled.timings.guide = timer.ms();
        }
        Ok(sampled)
    }

    /// Frames on the CPU go through the host.
    #[cfg(feature = "gpu")]
    fn display(&mut self, _: &View) -> Result<Option<DeviceFrame>> {
        Ok(None)
    }

    #[cfg(feature = "gpu")]
    fn finish_display(&mut self) -> Result<Vec<DoneFrame>> {
        Ok(Vec::new())
    }

    /// Nothing to forget: the samples of a frame do not depend on earlier ones.
    fn reset(&mut self) {}
}

/// Samples of `list` with its ray results `marched`, and the guide pixels of the samples. The timer was started before
/// marching.
fn sampled(
    list: SampleList,
    marched: Vec<RayResult>,
    mask: Option<SampleMask>,
    (timer, timings): (Timer, Timings),
) -> (Sampled, Vec<GuidePixel>) {
    let march_ms = timer.ms();
    let (mask, samples) = (mask.unwrap_or_else(|| mask_of(&list)), marched.len());
    let (list, marched) = in_raster_order(list, marched, &mask);
    let of_samples = marched.iter().map(guide_pixel).collect();
    let sparse = sparse_frame(list, &marched);
    let both_ms = timer.ms();
    let timings = Timings { march: both_ms, scatter: both_ms - march_ms, ..timings };
    (Sampled { timings, ..Sampled::sparse(sparse, mask, samples) }, of_samples)
}
