use super::weights::weights;
use super::window::{Seen, Windowed};
use crate::{Error, Reconstruction, RenderSettings, Result};
use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_net::Fill;
use fovol_net::cpu::{FrameInput, Network, Precision, Simd};
use std::sync::Arc;

/// Reconstructs the sparse frames of one clip.
///
/// Networks remember earlier frames, so a reconstructor belongs to one clip. [`Self::another`] makes a second one with
/// the same weights, for another eye or another clip.
#[derive(Debug, Clone)]
pub struct Reconstructor(Method);

#[derive(Debug, Clone)]
enum Method {
    Nothing,
    Fill(Fill),
    Network(Arc<Network>, Box<Windowed>),
}

impl Reconstructor {
    /// Reconstruction as `settings` ask for, of frames of `size`.
    ///
    /// # Errors
    /// Weights that are missing, unreadable or of another kind of network.
    pub fn new(settings: &RenderSettings, size: FrameSize) -> Result<Self> {
        Ok(Self(match settings.reconstruction {
            Reconstruction::None => Method::Nothing,
            Reconstruction::Fill(fill) => Method::Fill(fill),
            Reconstruction::WNet | Reconstruction::DeepFovea => {
                let weights = weights(settings)?;
                let plan = weights.config.plan().map_err(Error::Setting)?;
                let network = Network::new(plan, &weights, Simd::best(), settings.precision)?;
                let clip = Windowed::new(size);
                Method::Network(Arc::new(network), Box::new(clip))
            }
        }))
    }

    /// Reconstructor that returns the samples alone: alpha 1 there, transparent black elsewhere.
    #[must_use]
    pub fn nothing() -> Self {
        Self(Method::Nothing)
    }

    /// Reconstructs `sparse`, the next frame of the clip. Returns a picture of its samples if there is no reconstruction.
    ///
    /// `motion` is the motion of each pixel to its position in the last frame, see [`crate::MotionFinder`]. Without it,
    /// networks that use motion treat the scene as still.
    ///
    /// # Errors
    /// A frame or motion of another size than the clip's.
    pub fn reconstruct(&mut self, sparse: &SparseFrame, motion: Option<&[[f32; 2]]>) -> Result<Frame> {
        self.reconstruct_seen(sparse, motion, &Seen::everything(sparse.size()))
    }

    /// Reconstructs `sparse` as [`Self::reconstruct`] does, but only the region that is `seen`. The rest of the frame
    /// becomes background.
    ///
    /// # Errors
    /// Errors of [`Self::reconstruct`].
    pub fn reconstruct_seen(
        &mut self,
        sparse: &SparseFrame,
        motion: Option<&[[f32; 2]]>,
        seen: &Seen,
    ) -> Result<Frame> {
        Ok(match &mut self.0 {
            Method::Nothing => sparse.to_frame(),
            Method::Fill(fill) => fill.reconstruct(sparse),
            Method::Network(network, clip) => {
                clip.reconstruct(network, &FrameInput { sparse, motion }, seen)?
            }
        })
    }

    /// Forgets all earlier frames, as after a cut.
    pub fn reset(&mut self) {
        if let Method::Network(_, clip) = &mut self.0 {
            clip.reset();
        }
    }

    /// Reconstructor of the same kind and weights for another clip, with frames of `size`.
    #[must_use]
    pub fn another(&self, size: FrameSize) -> Self {
        Self(match &self.0 {
            Method::Network(network, _) => {
                Method::Network(Arc::clone(network), Box::new(Windowed::new(size)))
            }
            other => other.clone(),
        })
    }

    /// Precision of the network on this CPU, if there is a network.
    pub fn precision(&self) -> Option<Precision> {
        match &self.0 {
            Method::Network(network, _) => Some(network.precision()),
            _ => None,
        }
    }

    /// Whether it changes frames at all.
    pub fn is_active(&self) -> bool {
        !matches!(self.0, Method::Nothing)
    }

    /// Whether the reconstruction uses motion.
    pub fn uses_motion(&self) -> bool {
        matches!(&self.0, Method::Network(network, _) if network.plan().inputs().motion.is_some())
    }
}
