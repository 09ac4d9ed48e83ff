use super::depths::DeviceFrames;
use super::guide::{GuideMarch, ImportancePass, LightRatio};
use super::motion::MotionPass;
use super::part::Part;
use crate::guide::{UpsampledGuide, headroom};
use crate::pipeline::frames::FrameGuide;
use crate::pipeline::view::View;
use crate::reconstruct::{device_precision, reconstructs, weights};
use crate::{Density, Error, Guide, Reconstruction, RenderSettings, Result};
use fovol_core::{Frame, FrameSize, Region};
use fovol_gpu::{Gpu, Timing, read};
use fovol_net::Fill;
use fovol_net::gpu::{DeviceInput, Network, PullPush, State};
use fovol_render::gpu::{DeviceImportance, FrameBuffers, Renderer};

/// Reconstruction of full frames on the device: of colours, or of light ratios with a guide.
#[derive(Debug)]
pub struct DeviceReconstruction {
    filling: Filling,
    guide: Option<Box<DeviceGuide>>,
    /// Present if densities are adaptive.
    importance: Option<ImportancePass>,
}

/// Filling of a sparse frame.
#[derive(Debug)]
enum Filling {
    PullPush(PullPush),
    Network { network: Network, state: Box<State>, motion: Option<Box<MotionPass>> },
}

/// Guide of the frames, and what divides and multiplies by it.
#[derive(Debug)]
struct DeviceGuide {
    kind: Guide,
    march: GuideMarch,
    light_ratio: LightRatio,
    /// Region of the last frame's guide.
    region: Option<Region>,
}

/// Frame whose samples are marched, before its reconstruction.
pub struct Marched<'a> {
    pub renderer: &'a Renderer,
    /// Its samples.
    pub buffers: &'a FrameBuffers,
    pub view: &'a View,
    /// Region in which the scene can be seen.
    pub region: Option<Region>,
    pub background: [f32; 3],
}

impl DeviceReconstruction {
    /// Reconstruction as `settings` ask for, of the frames of `renderer` in `buffers`; `None` if it runs on the CPU only.
    pub fn new(
        renderer: &Renderer,
        settings: &RenderSettings,
        buffers: &FrameBuffers,
    ) -> Result<Option<Self>> {
        if !reconstructs(settings) {
            return Ok(None);
        }
        let (gpu, size) = (renderer.gpu(), buffers.size());
        let kind = settings.guide_kind();
        let Some(filling) = Filling::new(gpu, settings, buffers, kind != Guide::None)? else {
            return Ok(None);
        };
        let guide = match kind {
            Guide::None => None,
            _ => {
                let march = GuideMarch::new(renderer, buffers, kind)?;
                let read = [buffers.frame(), march.guide(), filling.frame_buffer()];
                let light_ratio = LightRatio::new(gpu, size, read, headroom(kind))?;
                Some(Box::new(DeviceGuide { kind, march, light_ratio, region: None }))
            }
        };
        let importance = match settings.density_kind() {
            Density::Fixed => None,
            Density::Adaptive => {
                let guide = guide.as_ref().map(|guide| guide.march.guide());
                Some(ImportancePass::new(gpu, size, filling.frame_buffer(), guide)?)
            }
        };
        Ok(Some(Self { filling, guide, importance }))
    }

    /// Forgets all earlier frames.
    pub fn reset(&mut self) {
        self.filling.reset();
        if let Some(importance) = &mut self.importance {
            importance.reset();
        }
    }

    /// Importance of samples for the next frame, which shows the scene in `region`; `None` if nothing is known.
    pub fn importance(&self, region: Option<Region>) -> Option<DeviceImportance<'_>> {
        self.importance.as_ref()?.known(region)
    }

    /// Encodes the reconstruction of the frame `marched` into `encoder`; `timing` times its parts.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        marched: &Marched<'_>,
        timing: &mut Timing<Part>,
    ) -> Result<()> {
        let Marched { view, buffers, region, .. } = *marched;
        let Self { filling, guide, importance } = self;
        if let Some(guide) = guide {
            timing.span(encoder, Part::Guide, |encoder| {
                guide.encode(encoder, marched);
                Ok::<_, Error>(())
            })?;
        }
        let guide = guide.as_deref();
        let sparse = guide.map_or(buffers.frame(), |guide| guide.light_ratio.ratios());
        filling.encode_motion(encoder, view, buffers, timing)?;
        timing.span(encoder, Part::Filling, |encoder| {
            filling.encode(encoder, sparse)?;
            if let Some(importance) = importance {
                importance.encode(encoder, region);
            }
            if let Some(guide) = guide {
                guide.light_ratio.encode_frame(encoder);
            }
            Ok::<_, Error>(())
        })
    }

    /// Buffer of the last full frame: RGBA as f32, row 0 on top.
    pub fn frame_buffer(&self) -> &wgpu::Buffer {
        self.guide.as_ref().map_or(self.filling.frame_buffer(), |guide| guide.light_ratio.frame())
    }

    /// Reads the last full frame back to the host.
    pub fn read_frame(&self, gpu: &Gpu, size: FrameSize) -> Result<Frame> {
        Ok(Frame::from_pixels(size, read(gpu, self.frame_buffer(), size.pixels())?)?)
    }

    /// Reads back how many pixels were marched for the guide of the last frame.
    pub fn read_guide_samples(&self) -> Result<usize> {
        let march = self.guide.as_ref().filter(|guide| guide.region.is_some());
        march.map_or(Ok(0), |guide| guide.march.read_marched())
    }

    /// Whether frames have a guide.
    pub fn has_guide(&self) -> bool {
        self.guide.is_some()
    }

    /// Reads the guide and the light ratio of the last frame back to the host, if there are any.
    pub fn read_guide(&self, gpu: &Gpu, size: FrameSize) -> Result<Option<FrameGuide>> {
        let Some((guide, region)) = self.guide.as_ref().and_then(|guide| Some((guide, guide.region?))) else {
            return Ok(None);
        };
        let pixels = read(gpu, guide.march.guide(), region.pixels())?;
        let ratio = read(gpu, self.filling.frame_buffer(), size.pixels())?;
        Ok(Some(FrameGuide {
            guide: UpsampledGuide::new(region, pixels, headroom(guide.kind)),
            ratio: Frame::from_pixels(size, ratio)?,
        }))
    }
}

impl DeviceGuide {
    /// Encodes the guide of the frame `marched`, and the light ratios of its samples.
    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, marched: &Marched<'_>) {
        let Marched { renderer, buffers, view, region, background } = *marched;
        let grid = region.and_then(|region| self.kind.grid(view.index, region, view.size));
        self.region = region.filter(|_| grid.is_some());
        if let Some(grid) = grid {
            self.march.encode(encoder, renderer, buffers, grid);
        }
        self.light_ratio.encode_ratios(encoder, self.region, background);
    }
}

impl Filling {
    /// Filling as `settings` ask for; `None` if it runs on the CPU only. With a guide motion is known from its distances.
    fn new(
        gpu: &Gpu,
        settings: &RenderSettings,
        buffers: &FrameBuffers,
        has_guide: bool,
    ) -> Result<Option<Self>> {
        let size = buffers.size();
        match settings.reconstruction {
            Reconstruction::None | Reconstruction::Fill(Fill::Linear) => Ok(None),
            Reconstruction::Fill(Fill::PullPush) => Ok(Some(Self::PullPush(PullPush::new(gpu, size)?))),
            Reconstruction::WNet | Reconstruction::DeepFovea => {
                let Some(precision) = device_precision(settings) else { return Ok(None) };
                let weights = weights(settings)?;
                let plan = weights.config.plan().map_err(Error::Setting)?;
                let network = Network::new(gpu, plan, &weights, precision)?;
                let state = Box::new(network.state(size)?);
                let moves = network.plan().inputs().motion.is_some();
                let frames = device_frames(buffers, &state);
                let motion = moves.then(|| MotionPass::new(gpu, size, frames, has_guide).map(Box::new));
                Ok(Some(Self::Network { network, state, motion: motion.transpose()? }))
            }
        }
    }

    fn reset(&mut self) {
        if let Self::Network { state, motion, .. } = self {
            state.reset();
            if let Some(motion) = motion {
                motion.reset();
            }
        }
    }

    /// Encodes the motion of the frame of `view`, if a network uses it.
    fn encode_motion(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        buffers: &FrameBuffers,
        timing: &mut Timing<Part>,
    ) -> Result<()> {
        let Self::Network { state, motion: Some(motion), .. } = self else { return Ok(()) };
        let frames = device_frames(buffers, state);
        timing.span(encoder, Part::Motion, |encoder| {
            motion.encode(encoder, &view.camera, frames);
            Ok(())
        })
    }

    /// Encodes the filling of `sparse`, after the motion of its frame.
    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, sparse: &wgpu::Buffer) -> Result<()> {
        match self {
            Self::PullPush(fill) => fill.encode(encoder, sparse)?,
            Self::Network { network, state, motion } => {
                let motion = motion.as_ref().and_then(|motion| motion.found());
                network.encode(encoder, DeviceInput { sparse, motion }, state)?;
            }
        }
        Ok(())
    }

    /// Buffer of the last filled frame: RGBA as f32, row 0 on top.
    fn frame_buffer(&self) -> &wgpu::Buffer {
        match self {
            Self::PullPush(fill) => fill.frame_buffer(),
            Self::Network { state, .. } => state.frame_buffer(),
        }
    }
}

/// Inputs of motion estimation: the samples in `buffers`, and the last full frame, which `state` keeps until the next
/// one.
fn device_frames<'a>(buffers: &'a FrameBuffers, state: &'a State) -> DeviceFrames<'a> {
    DeviceFrames {
        inverse_depths: buffers.inverse_depths(),
        sparse: buffers.frame(),
        last: state.frame_buffer(),
    }
}
