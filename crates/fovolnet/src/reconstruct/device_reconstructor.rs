use super::on_device::{device_precision, reconstructs};
use super::weights::weights;
use crate::{Error, Reconstruction, RenderSettings, Result};
use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_gpu::Gpu;
use fovol_net::Fill;
use fovol_net::cpu::FrameInput;
use fovol_net::gpu::{Network, PullPush, State};

/// GPU twin of [`crate::Reconstructor`], for sparse frames of other renderers. Frames are uploaded, reconstructed and
/// read back. Frames of [`crate::Pipeline`] stay on the device instead.
#[derive(Debug)]
pub struct DeviceReconstructor(Method);

#[derive(Debug)]
enum Method {
    PullPush(Box<PullPush>),
    Network(Box<Network>, Box<State>),
}

impl DeviceReconstructor {
    /// Reconstruction as `settings` ask for, of frames of `size`; `None` if it runs on the CPU only.
    ///
    /// # Errors
    /// Weights that are missing, unreadable or of another kind of network; a size that the device does not support.
    pub fn new(gpu: &Gpu, settings: &RenderSettings, size: FrameSize) -> Result<Option<Self>> {
        let (true, Some(precision)) = (reconstructs(settings), device_precision(settings)) else {
            return Ok(None);
        };
        if settings.reconstruction == Reconstruction::Fill(Fill::PullPush) {
            return Ok(Some(Self(Method::PullPush(Box::new(PullPush::new(gpu, size)?)))));
        }
        let weights = weights(settings)?;
        let plan = weights.config.plan().map_err(Error::Setting)?;
        let network = Network::new(gpu, plan, &weights, precision)?;
        let state = network.state(size)?;
        Ok(Some(Self(Method::Network(Box::new(network), Box::new(state)))))
    }

    /// Reconstructs `sparse`, the next frame of the clip. `motion` as for [`crate::Reconstructor::reconstruct`].
    ///
    /// # Errors
    /// A frame or motion of another size than the clip's, a lost device.
    pub fn reconstruct(&mut self, sparse: &SparseFrame, motion: Option<&[[f32; 2]]>) -> Result<Frame> {
        Ok(match &mut self.0 {
            Method::PullPush(fill) => fill.reconstruct(sparse)?,
            Method::Network(network, state) => network.reconstruct(&FrameInput { sparse, motion }, state)?,
        })
    }

    /// Whether the reconstruction uses motion.
    pub fn uses_motion(&self) -> bool {
        matches!(&self.0, Method::Network(network, _) if network.plan().inputs().motion.is_some())
    }
}
