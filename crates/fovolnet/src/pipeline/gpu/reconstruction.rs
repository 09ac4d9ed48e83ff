use super::motion::{DeviceFrames, MotionPass};
use super::part::Part;
use crate::pipeline::view::View;
use crate::reconstruct::{device_precision, reconstructs, weights};
use crate::{Error, Reconstruction, RenderSettings, Result};
use fovol_core::{Frame, FrameSize};
use fovol_gpu::{Gpu, Timing, read};
use fovol_net::Fill;
use fovol_net::gpu::{DeviceInput, Network, PullPush, State};
use fovol_render::gpu::FrameBuffers;

/// Reconstruction of full frames on the device.
#[derive(Debug)]
pub enum DeviceReconstruction {
    PullPush(PullPush),
    Network { network: Network, state: Box<State>, motion: Option<Box<MotionPass>> },
}

impl DeviceReconstruction {
    /// Reconstruction as `settings` ask for, of the frames in `buffers`; `None` if it runs on the CPU only.
    pub fn new(gpu: &Gpu, settings: &RenderSettings, buffers: &FrameBuffers) -> Result<Option<Self>> {
        if !reconstructs(settings) {
            return Ok(None);
        }
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
                let motion = moves.then(|| MotionPass::new(gpu, size, frames).map(Box::new)).transpose()?;
                Ok(Some(Self::Network { network, state, motion }))
            }
        }
    }

    /// Forgets all earlier frames.
    pub fn reset(&mut self) {
        if let Self::Network { state, motion, .. } = self {
            state.reset();
            if let Some(motion) = motion {
                motion.reset();
            }
        }
    }

    /// Encodes the reconstruction of the frame in `buffers` into `encoder`; `timing` times its parts.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &FrameBuffers,
        view: &View,
        timing: &mut Timing<Part>,
    ) -> Result<()> {
        let sparse = buffers.frame();
        match self {
            Self::PullPush(fill) => {
                timing.span(encoder, Part::Filling, |encoder| fill.encode(encoder, sparse))?;
            }
            Self::Network { network, state, motion } => {
                let frames = device_frames(buffers, state);
                let motion = match motion {
                    Some(motion) => timing.span(encoder, Part::Motion, |encoder| {
                        motion.encode(encoder, &view.camera, frames)
                    })?,
                    None => None,
                };
                let input = DeviceInput { sparse, motion };
                timing.span(encoder, Part::Filling, |encoder| network.encode(encoder, input, state))?;
            }
        }
        Ok(())
    }

    /// Buffer of the last full frame: RGBA as f32, row 0 on top.
    pub fn frame_buffer(&self) -> &wgpu::Buffer {
        match self {
            Self::PullPush(fill) => fill.frame_buffer(),
            Self::Network { state, .. } => state.frame_buffer(),
        }
    }

    /// Reads the last full frame back to the host.
    pub fn read_frame(&self, gpu: &Gpu, size: FrameSize) -> Result<Frame> {
        Ok(Frame::from_pixels(size, read(gpu, self.frame_buffer(), size.pixels())?)?)
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
