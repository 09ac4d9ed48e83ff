use crate::pipeline::{device_precision, reconstructs};
use crate::reconstructor::weights;
use crate::{Error, Reconstruction, RenderSettings, Result};
use fovol_core::{Frame, FrameSize};
use fovol_gpu::Gpu;
use fovol_net::Fill;
use fovol_net::cpu::FrameInput;
use fovol_net::gpu::{Network, PullPush, State};

/// Makes full frames of the sparse frames of one clip on a graphics processor, to which they are brought and from which they come
/// back: the twin of [`crate::Reconstructor`] for frames of others. What [`crate::Pipeline`] samples there stays there.
#[derive(Debug)]
pub struct DeviceReconstructor(Method);

#[derive(Debug)]
enum Method {
    PullPush(Box<PullPush>),
    Network(Box<Network>, Box<State>),
}

impl DeviceReconstructor {
    /// What `settings` say, for frames of `size`; `None` where that runs on the processor only.
    ///
    /// # Errors
    /// Weights that are missing, cannot be read, or are of another kind of network; a size that the device does not take.
    pub fn new(gpu: &Gpu, settings: &RenderSettings, size: FrameSize) -> Result<Option<Self>> {
        let how = settings.reconstruction();
        let (true, Some(precision)) = (reconstructs(settings), device_precision(settings)) else {
            return Ok(None);
        };
        if how == Reconstruction::Fill(Fill::PullPush) {
            return Ok(Some(Self(Method::PullPush(Box::new(PullPush::new(gpu, size)?)))));
        }
        let weights = weights(settings, how)?;
        let plan = weights.config.plan().map_err(Error::Setting)?;
        let network = Network::new(gpu, plan, &weights, precision)?;
        let state = network.state(size)?;
        Ok(Some(Self(Method::Network(Box::new(network), Box::new(state)))))
    }

    /// The full frame of `sparse`, the next of the clip; `motion` as for [`crate::Reconstructor::reconstruct`].
    ///
    /// # Errors
    /// A frame of another size than the clip's, motion of another size, a device that is lost.
    pub fn reconstruct(&mut self, sparse: &Frame, motion: Option<&[[f32; 2]]>) -> Result<Frame> {
        Ok(match &mut self.0 {
            Method::PullPush(fill) => fill.reconstruct(sparse)?,
            Method::Network(network, state) => network.reconstruct(&FrameInput { sparse, motion }, state)?,
        })
    }

    /// Whether it makes use of motion.
    pub fn uses_motion(&self) -> bool {
        matches!(&self.0, Method::Network(network, _) if network.plan().inputs().motion.is_some())
    }
}
