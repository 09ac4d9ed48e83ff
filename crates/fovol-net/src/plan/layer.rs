//! The kinds of layers.

use super::{Parameter, Tensor, TensorId};
use serde::{Deserialize, Serialize};

/// What follows a convolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    None,
    /// max(x, 0).
    Relu,
    /// x for x > 0, else eˣ − 1.
    Elu,
}

/// What lies beyond the border of a tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// Zeros.
    Zero,
    /// The nearest value; for a border of one this is also TensorFlow's symmetric padding.
    Replicate,
}

/// Changes of resolution that happen while a tensor is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resize {
    /// None.
    Same,
    /// Twice as many pixels along each axis, interpolated bilinearly between pixel centres
    /// (`align_corners=false`), replicated at the border.
    Bilinear,
    /// Twice as many pixels along each axis, each the nearest.
    Nearest,
}

/// A tensor as a layer reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Read {
    /// Which.
    pub tensor: TensorId,
    /// At which resolution.
    pub resize: Resize,
}

impl Read {
    /// As it is.
    pub fn same(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Same }
    }

    /// Bilinearly at twice the resolution.
    pub fn bilinear(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Bilinear }
    }

    /// The nearest at twice the resolution.
    pub fn nearest(tensor: TensorId) -> Self {
        Self { tensor, resize: Resize::Nearest }
    }
}

/// activation(convolution(concatenated inputs) + bias).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conv {
    /// Its parameters are `name.weight` \[out, in, size, size\] and `name.bias` \[out\].
    pub name: String,
    /// What it reads, concatenated along the channels.
    pub inputs: Vec<Read>,
    /// What it writes.
    pub output: TensorId,
    /// 1 or 3.
    pub size: usize,
    /// 1 or 2.
    pub stride: usize,
    /// What a window of size 3 finds beyond the border.
    pub padding: Padding,
    /// What follows.
    pub activation: Activation,
}

/// Group normalisation with one group: over all channels and pixels of the frame, then an affine map of each
/// channel and an activation; ε = 1e-5 (ALGORITHMS §2).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Norm {
    /// Its parameters are `name.weight` and `name.bias`, a number per channel each.
    pub name: String,
    /// What it reads.
    pub input: TensorId,
    /// What it writes.
    pub output: TensorId,
    /// What follows.
    pub activation: Activation,
}

/// Which pixels of an image a predicted kernel weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Taps {
    /// The 3×3 around each pixel, row by row; zeros beyond the border.
    Around,
    /// The pixel itself.
    Centre,
}

impl Taps {
    /// How many there are.
    pub fn count(self) -> usize {
        match self {
            Self::Around => 9,
            Self::Centre => 1,
        }
    }
}

/// How the weights of a predicted kernel come to a sum of 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Normalisation {
    /// (w² + ε) / (Σw² + nε) with ε = 1e-6: the authors' squares, safe in half precision.
    Squared,
    /// eʷ / Σeʷ.
    Softmax,
}

/// The ε of [`Normalisation::Squared`].
pub const SQUARED_EPSILON: f32 = 1e-6;

/// What is added to the square by which samples differ from what is around them in [`Layer::Doubt`]: a difference of a
/// quarter of an 8-bit step.
pub const DOUBT_EPSILON: f32 = 1e-6;
/// Which part of the square by which they differ from what is around them is no reason for doubt in what was known before.
pub const DOUBT_ALLOWED: f32 = 0.25;
/// How much what is more than that counts: somewhat less than one, as what is compared with the samples is smoother than
/// what they are filled with in the end.
pub const DOUBT_SHARE: f32 = 0.5;

/// Numbers of a point: the four of a [known](Layer::Join) pixel, and how far it lies right of and below the centre of its
/// pixel, −0.5 to below 0.5 pixels each.
pub const POINT: usize = 6;

/// A kernel for each pixel, predicted by a 1×1 convolution of `features`, normalised, and applied to images:
/// the same kernel for all channels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Filter {
    /// Its parameters are `name.weight` \[expand²·taps, in, 1, 1\] and `name.bias`. With `expand` = 2 each
    /// feature serves four pixels; the channel of tap k of pixel (x, y) of the four is 4k + 2y + x.
    pub name: String,
    /// What kernels are predicted from.
    pub features: TensorId,
    /// The edge of the square of pixels that one feature serves: 1 or 2.
    pub expand: usize,
    /// What is filtered, in the order of the kernel's weights.
    pub images: Vec<(Read, Taps)>,
    /// What it writes.
    pub output: TensorId,
    /// How the weights come to a sum of 1.
    pub normalisation: Normalisation,
}

impl Filter {
    /// Weights of a kernel.
    pub fn taps(&self) -> usize {
        self.images.iter().map(|(_, taps)| taps.count()).sum()
    }
}

/// A step of a network.
#[derive(Debug, Clone, PartialEq)]
pub enum Layer {
    /// A convolution.
    Conv(Conv),
    /// A normalisation over the frame.
    Norm(Norm),
    /// A predicted kernel.
    Filter(Filter),
    /// The mean of 2×2 pixels.
    Pool {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// 2×2 pixels become four times as many channels: channel c of pixel (x, y) of the four becomes 4c + 2y + x.
    SpaceToDepth {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// The inverse of [`Self::SpaceToDepth`].
    DepthToSpace {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// factor · x + offset.
    Scale {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
        /// What values are multiplied by.
        factor: f32,
        /// What is added.
        offset: f32,
    },
    /// The nearest number in 0…1.
    Clamp {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// Colours times their weights, and the weights as a fourth channel: known pixels, as the next layers take them.
    Join {
        /// Colours times their weights.
        colour: TensorId,
        /// The weights, 0…1.
        weight: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// Known pixels spread over the frame at half the resolution: means of ever larger squares where there are few. With a
    /// `base`, what they differ from that is spread, and added to it.
    Spread {
        /// [Known](Self::Join) pixels.
        known: TensorId,
        /// The picture at half the resolution that is to be corrected.
        base: Option<TensorId>,
        /// How often the resolution is halved.
        levels: u32,
        /// What it writes.
        output: TensorId,
    },
    /// Means of 3×3 pixels by (1, 2, 1)/4 along both axes, replicated at the border.
    Smooth {
        /// What it reads.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// Known pixels, and `base`, bilinearly at twice its resolution, as far as they are not known: c + (1 − w)·b.
    Blend {
        /// [Known](Self::Join) pixels.
        known: TensorId,
        /// A picture at half the resolution.
        base: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// How far what earlier frames tell is believed, 0…1: v / (v + [`DOUBT_SHARE`] max(e − [`DOUBT_ALLOWED`] v, 0)) with e
    /// and v ([`DOUBT_EPSILON`] more) the mean squares by which this frame's samples differ from `prior` and from `fresh`,
    /// spread over the frame. Wholly where it tells what the samples are much better than their neighbours do, so that
    /// still pictures keep all they know; else about by the inverse of both variances.
    Doubt {
        /// [Known](Self::Join) pixels of this frame.
        known: TensorId,
        /// The last picture, where it is now.
        prior: TensorId,
        /// What the samples of this frame give, at half the resolution and so smooth that each says little about itself.
        fresh: TensorId,
        /// How often the resolution is halved.
        levels: u32,
        /// What it writes; the lowest of the levels.
        output: TensorId,
    },
    /// Known pixels of this frame, and as far as these are not known, those of earlier ones: k + (1 − w)·fade·share·before.
    /// Where those are [points](POINT) these become some too, at the centres of their pixels.
    Accumulate {
        /// [Known](Self::Join) pixels of this frame.
        known: TensorId,
        /// Those of earlier ones, or points.
        before: TensorId,
        /// How far these are believed, at some lower resolution; bilinear. Without it they are.
        share: Option<TensorId>,
        /// What they are multiplied by.
        fade: f32,
        /// What it writes.
        output: TensorId,
    },
    /// Channels from number `first` on, as many as `output` has.
    Part {
        /// What it reads.
        input: TensorId,
        /// The first channel.
        first: usize,
        /// What it writes.
        output: TensorId,
    },
    /// input + more.
    Add {
        /// A picture.
        input: TensorId,
        /// Another one.
        more: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// mask · colour + (1 − mask) · input.
    Bypass {
        /// What was sampled.
        colour: TensorId,
        /// 1 where it was.
        mask: TensorId,
        /// What stands elsewhere.
        input: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// [Points](POINT) where they are now. A pixel takes those that were in the square of its size around where its centre
    /// was in the last frame: several become their mean, with the largest of their weights.
    Reproject {
        /// Points of the last frame.
        input: TensorId,
        /// Pixels to the previous position.
        motion: TensorId,
        /// What it writes.
        output: TensorId,
    },
    /// What [points](POINT) tell of the centres of pixels: each is known to the four around it as far as it is near, bilinear.
    /// Divided by the sum of these shares where that is more than one.
    Splat {
        /// Points.
        input: TensorId,
        /// [Known](Self::Join) pixels.
        output: TensorId,
    },
    /// The value where each pixel was in the last frame, bilinear, zero outside. Motion is averaged and scaled
    /// to the resolution of `input`.
    Warp {
        /// What it reads.
        input: TensorId,
        /// Pixels to the previous position; level 0.
        motion: TensorId,
        /// What it writes.
        output: TensorId,
    },
}

impl Layer {
    /// What it writes.
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

    /// The picture of which it changes the numbers one by one, if it does no more than that.
    pub fn changed(&self) -> Option<TensorId> {
        match self {
            Self::Scale { input, .. }
            | Self::Clamp { input, .. }
            | Self::Add { input, .. }
            | Self::Bypass { input, .. } => Some(*input),
            _ => None,
        }
    }

    /// What its output begins as, if it only writes over some numbers of that.
    pub fn begins_as(&self) -> Option<TensorId> {
        match self {
            Self::Accumulate { before, .. } => Some(*before),
            _ => None,
        }
    }

    /// What it reads.
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

    /// What it is called: the name of its parameters, or its kind.
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

    /// Its learned arrays.
    pub fn parameters(&self, tensors: &[Tensor]) -> Vec<Parameter> {
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

    /// Multiplications and additions for a pixel of the frame, counted as pairs; only those of learned weights
    /// and predicted kernels.
    pub fn macs_per_pixel(&self, tensors: &[Tensor]) -> f64 {
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
