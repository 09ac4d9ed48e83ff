//! Kinds of layers.

use super::{Parameter, TensorId, TensorSpec};
use serde::{Deserialize, Serialize};

/// Activation function after a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Identity.
    None,
    /// max(x, 0).
    Relu,
    /// x for x > 0, else eˣ − 1.
    Elu,
}

/// Values beyond the border of a tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// Zeros.
    Zero,
    /// Values of the nearest pixel. For a border of one this equals TensorFlow's symmetric padding.
    Replicate,
}

/// Change of resolution while a tensor is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resize {
    /// Unchanged.
    Same,
    /// Doubled along each axis: bilinear between pixel centres (`align_corners=false`), replicated at the border.
    Bilinear,
    /// Doubled along each axis: nearest neighbour.
    Nearest,
}

/// A tensor as an input of a layer, with its change of resolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Read {
    /// The tensor.
    pub tensor: TensorId,
    /// Its change of resolution.
    pub resize: Resize,
}

impl Read {
    /// Reads `tensor` at its own resolution.
    pub fn same(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Same }
    }

    /// Reads `tensor` at twice its resolution, bilinearly.
    pub fn bilinear(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Bilinear }
    }

    /// Reads `tensor` at twice its resolution, by nearest neighbour.
    pub fn nearest(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Nearest }
    }
}

/// Convolution: activation(convolution(concatenated inputs) + bias).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conv {
    /// Name of the parameters `name.weight` \[out, in, size, size\] and `name.bias` \[out\].
    pub name: String,
    /// Input tensors, concatenated along the channels.
    pub inputs: Vec<Read>,
    /// Output tensor.
    pub output: TensorId,
    /// Edge of the window in pixels: 1 or 3.
    pub size: usize,
    /// Step between windows in pixels: 1 or 2.
    pub stride: usize,
    /// Values beyond the border, for windows of size 3.
    pub padding: Padding,
    /// Activation function.
    pub activation: Activation,
}

/// Group normalisation with one group, over all channels and pixels of the frame. An affine map of each channel and
/// an activation follow. ε = 1e-5; docs/guide/src/internals/algorithm.md, section 6.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Norm {
    /// Name of the parameters `name.weight` and `name.bias`, both of one number per channel.
    pub name: String,
    /// Input tensor.
    pub input: TensorId,
    /// Output tensor.
    pub output: TensorId,
    /// Activation function.
    pub activation: Activation,
}

/// Pixels of an image that a predicted kernel weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Taps {
    /// The 3×3 pixels around each pixel, row by row, with zeros beyond the border.
    Around,
    /// The pixel itself.
    Centre,
}

impl Taps {
    /// Number of pixels.
    pub fn count(self) -> usize {
        match self {
            Self::Around => 9,
            Self::Centre => 1,
        }
    }
}

/// Normalisation that brings the weights of a predicted kernel to a sum of 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Normalisation {
    /// (w² + ε) / (Σw² + nε) with ε = 1e-6: the authors' squares, made safe for f16.
    Squared,
    /// Softmax: eʷ / Σeʷ.
    Softmax,
}

/// The ε of [`Normalisation::Squared`].
pub const SQUARED_EPSILON: f32 = 1e-6;

/// Term that [`Layer::Doubt`] adds to the variance of the samples: the square of a quarter of an 8-bit step.
pub const DOUBT_EPSILON: f32 = 1e-6;
/// Part of the samples' variance up to which an error of the history is no reason for doubt: ¼ in
/// docs/guide/src/internals/algorithm.md, section 5.
pub const DOUBT_ALLOWED: f32 = 0.25;
/// Factor of the error beyond the allowed part: ½ in docs/guide/src/internals/algorithm.md, section 5. It is less
/// than 1 because the fill in this comparison is smoother than the final one.
pub const DOUBT_SHARE: f32 = 0.5;

/// Channels of a point: premultiplied RGB and weight as of [`Layer::Join`], then the offset of the point from the
/// centre of its pixel, x right and y down, −0.5 to below 0.5 pixels.
pub const POINT: usize = 6;

/// Predicted kernel: a 1×1 convolution of `features` gives each pixel's weights, which are normalised and applied
/// to images. All channels share one kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Filter {
    /// Name of the parameters `name.weight` \[expand²·taps, in, 1, 1\] and `name.bias`. With `expand` = 2 each
    /// feature serves four pixels, and tap k of pixel (x, y) of the four is channel 4k + 2y + x.
    pub name: String,
    /// TensorSpec from which kernels are predicted.
    pub features: TensorId,
    /// Edge of the square of pixels that one feature serves: 1 or 2.
    pub expand: usize,
    /// Images to filter and their taps, in the order of the kernel's weights.
    pub images: Vec<(Read, Taps)>,
    /// Output tensor.
    pub output: TensorId,
    /// Normalisation of the weights.
    pub normalisation: Normalisation,
}

impl Filter {
    /// Number of weights of a kernel.
    pub fn taps(&self) -> usize {
        self.images.iter().map(|(_, taps)| taps.count()).sum()
    }
}

/// A layer of a network.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// Convolution.
    Conv(Conv),
    /// Normalisation over the frame.
    Norm(Norm),
    /// Predicted kernel.
    Filter(Filter),
    /// Average of 2×2 pixels.
    Pool {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Folds 2×2 pixels into four times as many channels: channel c of pixel (x, y) of the four becomes 4c + 2y +
    /// x.
    SpaceToDepth {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Inverse of [`Self::SpaceToDepth`].
    DepthToSpace {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Computes factor · x + offset.
    Scale {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
        /// Factor of each value.
        factor: f32,
        /// Number that is added to each product.
        offset: f32,
    },
    /// Clamps values to 0…1.
    Clamp {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Multiplies colours by weights and appends the weights as a fourth channel: weighted pixels, the input of the
    /// filling layers.
    Join {
        /// Colours, three channels.
        colour: TensorId,
        /// Weights, 0…1.
        weight: TensorId,
        /// Output tensor, four channels.
        output: TensorId,
    },
    /// Spreads weighted pixels over the frame at half the resolution: where samples are few, by means of larger
    /// squares. With a `base` it spreads the residuals of `base` at the samples and adds them to `base`.
    Spread {
        /// [Weighted](Self::Join) pixels.
        known: TensorId,
        /// Picture at half the resolution that is to be corrected.
        base: Option<TensorId>,
        /// Number of times that the resolution is halved.
        levels: u32,
        /// Output tensor, at half the resolution.
        output: TensorId,
    },
    /// Smooths by (1, 2, 1)/4 along both axes, replicated at the border.
    Smooth {
        /// Input tensor.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Fills weighted pixels from `base`, read bilinearly at twice its resolution: c + (1 − w)·b.
    Blend {
        /// [Weighted](Self::Join) pixels.
        known: TensorId,
        /// Picture at half the resolution.
        base: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Confidence in the history, 0…1: v / (v + [`DOUBT_SHARE`] · max(e − [`DOUBT_ALLOWED`] · v, 0)).
    ///
    /// e and v are mean squared differences between this frame's samples and `prior` or `fresh`, spread over the
    /// frame; [`DOUBT_EPSILON`] is added to v. The confidence is 1 where `prior` predicts the samples much better
    /// than their neighbours do, so that still pictures keep all earlier samples. Elsewhere history and samples
    /// weigh about as the inverses of their variances. See docs/guide/src/internals/algorithm.md, section 5.
    Doubt {
        /// [Weighted](Self::Join) pixels of this frame.
        known: TensorId,
        /// Last output, reprojected.
        prior: TensorId,
        /// Fill of this frame's samples at half the resolution, so smooth that a sample has little influence on its
        /// own value.
        fresh: TensorId,
        /// Number of times that the resolution is halved.
        levels: u32,
        /// Output tensor, of one channel; its level is the lowest of the levels that are computed.
        output: TensorId,
    },
    /// Adds earlier samples to those of this frame where these leave a gap: k + (1 − w) · fade · share · before. If
    /// earlier samples are [points](POINT), new samples become points at the centres of their pixels.
    Accumulate {
        /// [Weighted](Self::Join) pixels of this frame.
        known: TensorId,
        /// Weighted pixels of earlier frames, or points.
        before: TensorId,
        /// Confidence in earlier samples at some lower resolution, read bilinearly; 1 without it.
        share: Option<TensorId>,
        /// Factor of the weights of earlier samples.
        fade: f32,
        /// Output tensor.
        output: TensorId,
    },
    /// Copies channels from number `first` on, as many as `output` has.
    Part {
        /// Input tensor.
        input: TensorId,
        /// First channel.
        first: usize,
        /// Output tensor.
        output: TensorId,
    },
    /// Computes input + more.
    Add {
        /// First summand.
        input: TensorId,
        /// Second summand.
        more: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Computes mask · colour + (1 − mask) · input.
    Bypass {
        /// Sampled colours.
        colour: TensorId,
        /// Sample mask: 1 where sampled.
        mask: TensorId,
        /// Picture for unsampled pixels.
        input: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Moves [points](POINT) along the motion. A pixel gathers the points within the square of its size around the
    /// place of its centre in the last frame. Several points become their mean, with the largest of their weights.
    Reproject {
        /// Points of the last frame.
        input: TensorId,
        /// Motion: pixels to the previous position.
        motion: TensorId,
        /// Output tensor.
        output: TensorId,
    },
    /// Resamples [points](POINT) at pixel centres. Each point contributes to the four centres around it with
    /// bilinear weights. Sums are divided by the total weight where it exceeds 1.
    Splat {
        /// Points.
        input: TensorId,
        /// [Weighted](Self::Join) pixels.
        output: TensorId,
    },
    /// Samples `input` where each pixel was in the last frame: bilinear, zero outside. Motion is averaged and
    /// scaled to the resolution of `input`.
    Warp {
        /// Input tensor.
        input: TensorId,
        /// Motion at level 0: pixels to the previous position.
        motion: TensorId,
        /// Output tensor.
        output: TensorId,
    },
}

impl Layer {
    /// Output tensor.
    pub fn output(&self) -> TensorId {
        match self {
            Self::Conv(conv) => conv.output,
            Self::Norm(norm) => norm.output,
            Self::Filter(filter) => filter.output,
            Self::Pool { output, .. }
            | Self::SpaceToDepth { output, .. }
            | Self::DepthToSpace { output, .. }
            | Self::Scale { output, .. }
            | Self::Clamp { output, .. }
            | Self::Join { output, .. }
            | Self::Spread { output, .. }
            | Self::Smooth { output, .. }
            | Self::Blend { output, .. }
            | Self::Doubt { output, .. }
            | Self::Accumulate { output, .. }
            | Self::Part { output, .. }
            | Self::Add { output, .. }
            | Self::Bypass { output, .. }
            | Self::Reproject { output, .. }
            | Self::Splat { output, .. }
            | Self::Warp { output, .. } => *output,
        }
    }

    /// Returns the input picture of a layer that works on each value by itself, if the layer does no more than
    /// that.
    pub fn changed(&self) -> Option<TensorId> {
        match self {
            Self::Scale { input, .. }
            | Self::Clamp { input, .. }
            | Self::Add { input, .. }
            | Self::Bypass { input, .. } => Some(*input),
            _ => None,
        }
    }

    /// Returns the input whose values the layer keeps in part, if its output can be written over that input.
    pub fn begins_as(&self) -> Option<TensorId> {
        match self {
            Self::Accumulate { before, .. } => Some(*before),
            _ => None,
        }
    }

    /// Input tensors.
    pub fn inputs(&self) -> Vec<TensorId> {
        match self {
            Self::Conv(conv) => conv.inputs.iter().map(|read| read.tensor).collect(),
            Self::Norm(norm) => vec![norm.input],
            Self::Filter(filter) => {
                let images = filter.images.iter().map(|(read, _)| read.tensor);
                std::iter::once(filter.features).chain(images).collect()
            }
            Self::Pool { input, .. }
            | Self::SpaceToDepth { input, .. }
            | Self::DepthToSpace { input, .. }
            | Self::Scale { input, .. }
            | Self::Clamp { input, .. }
            | Self::Smooth { input, .. }
            | Self::Part { input, .. }
            | Self::Splat { input, .. } => vec![*input],
            Self::Join { colour, weight, .. } => vec![*colour, *weight],
            Self::Spread { known, base, .. } => [Some(*known), *base].into_iter().flatten().collect(),
            Self::Blend { known, base, .. } => vec![*known, *base],
            Self::Doubt { known, prior, fresh, .. } => vec![*known, *prior, *fresh],
            Self::Accumulate { known, before, share, .. } => {
                [Some(*known), Some(*before), *share].into_iter().flatten().collect()
            }
            Self::Add { input, more, .. } => vec![*input, *more],
            Self::Bypass { colour, mask, input, .. } => vec![*colour, *mask, *input],
            Self::Reproject { input, motion, .. } | Self::Warp { input, motion, .. } => vec![*input, *motion],
        }
    }

    /// Name of the parameters, or the kind of a layer without parameters.
    pub fn name(&self) -> &str {
        match self {
            Self::Conv(conv) => &conv.name,
            Self::Norm(norm) => &norm.name,
            Self::Filter(filter) => &filter.name,
            Self::Pool { .. } => "pool",
            Self::SpaceToDepth { .. } => "space-to-depth",
            Self::DepthToSpace { .. } => "depth-to-space",
            Self::Scale { .. } => "scale",
            Self::Clamp { .. } => "clamp",
            Self::Join { .. } => "join",
            Self::Spread { .. } => "spread",
            Self::Smooth { .. } => "smooth",
            Self::Blend { .. } => "blend",
            Self::Doubt { .. } => "doubt",
            Self::Accumulate { .. } => "accumulate",
            Self::Part { .. } => "part",
            Self::Add { .. } => "add",
            Self::Bypass { .. } => "bypass",
            Self::Reproject { .. } => "reproject",
            Self::Splat { .. } => "splat",
            Self::Warp { .. } => "warp",
        }
    }

    /// Learned arrays of the layer.
    pub fn parameters(&self, tensors: &[TensorSpec]) -> Vec<Parameter> {
        let channels = |id: TensorId| tensors[id.0].channels;
        let pair = |name: &str, weight: Vec<usize>| {
            let bias = vec![weight[0]];
            vec![
                Parameter { name: format!("{name}.weight"), shape: weight },
                Parameter { name: format!("{name}.bias"), shape: bias },
            ]
        };
        match self {
            Self::Conv(conv) => {
                let inputs = conv.inputs.iter().map(|read| channels(read.tensor)).sum();
                pair(&conv.name, vec![channels(conv.output), inputs, conv.size, conv.size])
            }
            Self::Filter(filter) => {
                let outputs = filter.expand * filter.expand * filter.taps();
                pair(&filter.name, vec![outputs, channels(filter.features), 1, 1])
            }
            Self::Norm(norm) => pair(&norm.name, vec![channels(norm.input)]),
            _ => Vec::new(),
        }
    }

    /// Multiply-adds for one pixel of the frame. Only those with learned weights and predicted kernels count.
    pub fn macs_per_pixel(&self, tensors: &[TensorSpec]) -> f64 {
        let per_square = |id: TensorId, macs: usize| macs as f64 / f64::from(4u32.pow(tensors[id.0].level));
        let weights = |layer: &Self| layer.parameters(tensors).first().map_or(0, Parameter::len);
        match self {
            Self::Conv(conv) => per_square(conv.output, weights(self)),
            Self::Filter(filter) => {
                let applied = filter.taps() * tensors[filter.output.0].channels;
                per_square(filter.features, weights(self)) + per_square(filter.output, applied)
            }
            _ => 0.0,
        }
    }
}
