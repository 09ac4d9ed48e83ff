//! Layers of networks: one file for each kind, and the list of all kinds.

mod accumulate;
mod activation;
mod add;
mod blend;
mod bypass;
mod clamp;
mod conv;
mod depth_to_space;
mod descriptor;
mod filter;
mod history_confidence;
mod join;
mod norm;
mod part;
mod pool;
mod read;
mod reproject;
mod samples;
mod scale;
mod smooth;
mod space_to_depth;
mod splat;
mod spread;
mod warp;

pub use accumulate::Accumulate;
pub use activation::Activation;
pub use add::Add;
pub use blend::Blend;
pub use bypass::Bypass;
pub use clamp::Clamp;
pub use conv::{Conv, Padding};
pub use depth_to_space::DepthToSpace;
pub use descriptor::Descriptor;
pub use filter::{Filter, Normalisation, SQUARED_EPSILON, Taps};
pub use history_confidence::{CONFIDENCE_ALLOWED, CONFIDENCE_EPSILON, CONFIDENCE_SHARE, HistoryConfidence};
pub use join::Join;
pub use norm::Norm;
pub use part::Part;
pub use pool::Pool;
pub use read::{Read, Resize};
pub use reproject::Reproject;
pub use samples::POINT;
pub use scale::Scale;
pub use smooth::Smooth;
pub use space_to_depth::SpaceToDepth;
pub use splat::Splat;
pub use spread::Spread;
pub use warp::Warp;

use super::tensor::{Parameter, TensorId, TensorSpec};

/// Defines [`Layer`] with these kinds, each of which has a descriptor of its name.
macro_rules! layers {
    ($($(#[$doc:meta])* $kind:ident,)*) => {
        /// A layer of a network.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Layer {
            $($(#[$doc])* $kind($kind),)*
        }

        $(impl From<$kind> for Layer {
            fn from(layer: $kind) -> Self {
                Self::$kind(layer)
            }
        })*

        impl Layer {
            /// Description of the layer.
            pub fn descriptor(&self) -> &dyn Descriptor {
                match self {
                    $(Self::$kind(layer) => layer,)*
                }
            }

            /// Description of the layer, to be changed.
            pub(super) fn descriptor_mut(&mut self) -> &mut dyn Descriptor {
                match self {
                    $(Self::$kind(layer) => layer,)*
                }
            }
        }
    };
}

layers! {
    /// Convolution.
    Conv,
    /// Normalisation over the frame.
    Norm,
    /// Predicted kernel.
    Filter,
    /// Average of 2×2 pixels.
    Pool,
    /// Fold of 2×2 pixels into channels.
    SpaceToDepth,
    /// Unfolding of channels into 2×2 pixels.
    DepthToSpace,
    /// Product with a number, plus a number.
    Scale,
    /// Clamp to 0…1.
    Clamp,
    /// Weighted pixels from colours and weights.
    Join,
    /// Weighted pixels, spread over the frame.
    Spread,
    /// Smoothing.
    Smooth,
    /// Weighted pixels, filled from a picture.
    Blend,
    /// Confidence in earlier frames.
    HistoryConfidence,
    /// Sum of earlier samples and those of this frame.
    Accumulate,
    /// Some of the channels.
    Part,
    /// Sum of two tensors.
    Add,
    /// Choice between two pictures by the sample mask.
    Bypass,
    /// Motion of points.
    Reproject,
    /// Points, resampled at pixel centres.
    Splat,
    /// Motion of a picture.
    Warp,
}

impl Layer {
    /// Name of the parameters, or the kind of a layer without parameters.
    pub fn name(&self) -> &str {
        self.descriptor().name()
    }

    /// Input tensors.
    pub fn inputs(&self) -> Vec<TensorId> {
        self.descriptor().inputs()
    }

    /// Output tensor.
    pub fn output(&self) -> TensorId {
        self.descriptor().output()
    }

    /// Learned arrays of the layer.
    pub fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        self.descriptor().parameters(tensors)
    }

    /// Multiply-adds for one pixel of the frame. Only those with learned weights and predicted kernels count.
    pub fn macs_per_pixel(&self, tensors: &[TensorSpec]) -> f64 {
        self.descriptor().macs_per_pixel(tensors)
    }

    /// Returns the input picture of a layer that works on each value by itself, if the layer does no more than
    /// that.
    pub fn changed(&self) -> Option<TensorId> {
        self.descriptor().changed()
    }

    /// Returns the input whose values the layer keeps in part, if its output can be written over that input.
    pub fn begins_as(&self) -> Option<TensorId> {
        self.descriptor().begins_as()
    }
}
