//! Chooses the arithmetic of each layer and the storage type of each tensor.

pub use crate::cpu::conv::Arithmetic;

use crate::cpu::conv::kernels;
use crate::plan::{Activation, Conv, Layer, Plan, Scale, SpaceToDepth, TensorId};
use crate::weights::Weights;
use crate::{Error, Result};
use fovol_simd::Simd;
use std::fmt;
use std::str::FromStr;

/// Precision of a network's arithmetic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// bf16 where this processor multiplies it faster, else f32.
    #[default]
    Auto,
    /// f32 throughout.
    F32,
    /// Products of bf16, sums in f32. Wide tensors are stored as bf16.
    Bf16,
    /// Products of f16, on GPUs that support them. The CPU engine uses f32 instead.
    F16,
    /// int8 in the 3×3 convolutions of non-negative inputs; all other layers as [`Self::Bf16`].
    ///
    /// Exceptions stay at [`Self::Bf16`]: a convolution that makes a state of full resolution, and, where bf16 is
    /// fast too, one that reads folded pictures. Needs the ranges of activations; see [`calibrate`](crate::cpu::calibrate).
    Int8,
    /// int8 in the layers that the weights name, or in all but the finest level; all other layers as
    /// [`Self::Bf16`].
    Mixed,
}

impl Precision {
    /// All precisions.
    pub const ALL: [Self; 6] = [Self::Auto, Self::F32, Self::Bf16, Self::F16, Self::Int8, Self::Mixed];

    /// Name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::F32 => "f32",
            Self::Bf16 => "bf16",
            Self::F16 => "f16",
            Self::Int8 => "int8",
            Self::Mixed => "mixed",
        }
    }

    /// Precision in use on `simd`: where a processor gains nothing, the next more exact one that it has.
    #[must_use]
    pub fn on(self, simd: Simd) -> Self {
        let bf16 = if simd.gains_from_bf16() { Self::Bf16 } else { Self::F32 };
        match self {
            Self::F32 | Self::F16 => Self::F32,
            Self::Auto | Self::Bf16 => bf16,
            Self::Int8 | Self::Mixed => {
                if simd.has_int8() {
                    self
                } else {
                    bf16
                }
            }
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Precision {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let found = Self::ALL.into_iter().find(|precision| precision.name() == text);
        found.ok_or_else(|| format!("`{text}` is no precision; use {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// Choices for one network on one processor.
pub struct Choice<'a> {
    plan: &'a Plan,
    weights: &'a Weights,
    precision: Precision,
    simd: Simd,
    /// Whether each tensor is non-negative.
    positive: Vec<bool>,
}

/// Fewest channels of a wide tensor. Tensors with fewer are pictures and stay f32.
const WIDE: usize = 16;

impl<'a> Choice<'a> {
    /// Makes the choices for `plan` with `weights`. `simd` must have `precision`.
    ///
    /// # Errors
    /// An int8 precision without the ranges of activations.
    pub fn new(plan: &'a Plan, weights: &'a Weights, precision: Precision, simd: Simd) -> Result<Self> {
        if matches!(precision, Precision::Int8 | Precision::Mixed) && weights.ranges.is_empty() {
            return Err(Error::Weights(format!(
                "{precision} needs the ranges of activations, which they do not say; calibrate them first, or use \
                 --precision bf16 or f32"
            )));
        }
        Ok(Self { plan, weights, precision, simd, positive: positive(plan) })
    }

    /// Whether tensor `id` is stored as bf16.
    pub fn is_halved(&self, id: TensorId) -> bool {
        self.precision != Precision::F32 && self.plan.tensor(id).channels >= WIDE
    }

    /// Arithmetic of layers other than 3×3 convolutions.
    pub fn narrow(&self) -> Arithmetic {
        let halves = self.precision != Precision::F32 && self.simd.gains_from_bf16();
        if halves { Arithmetic::Bf16 } else { Arithmetic::F32 }
    }

    /// Arithmetic of layers that make pictures, for which the eight bits of bf16 are too few: f32, or split bf16
    /// where AMX makes twice as many products still faster.
    pub fn exact(&self, mut inputs: impl Iterator<Item = TensorId>) -> Arithmetic {
        let pays = kernels::multiplies_tiles(self.simd, &Arithmetic::SplitBf16);
        if pays && inputs.all(|id| self.is_halved(id)) { Arithmetic::SplitBf16 } else { Arithmetic::F32 }
    }

    /// Arithmetic of `conv`.
    pub fn of(&self, conv: &Conv) -> Arithmetic {
        if conv.size == 1 {
            return self.exact(conv.inputs.iter().map(|read| read.tensor));
        }
        let is_positive = conv.inputs.iter().all(|read| self.positive[read.tensor.index()]);
        match self.steps(conv) {
            Some(steps) if is_positive && self.wants_bytes(conv) => {
                let reach = self.weights.ranges.get(&transformed(&conv.name)).cloned();
                Arithmetic::Int8 { steps, reach }
            }
            _ => self.narrow(),
        }
    }

    fn wants_bytes(&self, conv: &Conv) -> bool {
        match self.precision {
            Precision::Int8 => {
                let stays_bf16 = self.simd.gains_from_bf16() && self.reads_folded(conv);
                !stays_bf16 && !self.makes_finest_state(conv)
            }
            Precision::Mixed => match self.weights.facts.get(BYTES) {
                Some(prefixes) => prefixes.split(',').any(|prefix| conv.name.starts_with(prefix.trim())),
                None => !["encoder.0.", "decoder.0."].iter().any(|finest| conv.name.starts_with(finest)),
            },
            _ => false,
        }
    }

    /// Whether `conv` writes a state of full resolution, whose errors are visible at once and in all later frames.
    fn makes_finest_state(&self, conv: &Conv) -> bool {
        let is_state = self.plan.states().iter().any(|state| state.next == conv.output);
        is_state && self.plan.tensor(conv.output).level == 0
    }

    /// Whether `conv` reads folded pictures. Quantising their few channels takes longer than it saves, and loses
    /// the most precision.
    fn reads_folded(&self, conv: &Conv) -> bool {
        let folds = |layer: &Layer| match layer {
            Layer::SpaceToDepth(SpaceToDepth { output, .. }) => {
                conv.inputs.iter().any(|read| read.tensor == *output)
            }
            _ => false,
        };
        self.plan.layers().iter().any(folds)
    }

    /// Step of each input channel of `conv`; `None` where a range is unknown.
    fn steps(&self, conv: &Conv) -> Option<Vec<f32>> {
        let mut steps = Vec::new();
        for read in &conv.inputs {
            let tensor = self.plan.tensor(read.tensor);
            let mut ranges = channel_ranges(self.weights.ranges.get(&tensor.name)?);
            if ranges.len() != tensor.channels {
                let most = ranges.iter().fold(1e-6f32, |most, range| most.max(*range));
                ranges = vec![most; tensor.channels];
            }
            steps.extend(ranges.iter().map(|range| range / 255.0));
        }
        Some(steps)
    }
}

/// Ranges of channels, given their largest observed values. Channels with tiny values get a part of the largest
/// range, since they may reach more in other frames.
pub fn channel_ranges(most: &[f32]) -> Vec<f32> {
    let least = most.iter().fold(1e-6f32, |all, most| all.max(*most)) / 16.0;
    most.iter().map(|most| most.max(least)).collect()
}

/// Key under which weights store the ranges of transformed inputs of the convolution `name` ([`Arithmetic::Int8`]).
pub fn transformed(name: &str) -> String {
    format!("{name}.transformed")
}

/// Metadata key for the int8 layers of [`Precision::Mixed`]: prefixes of names, separated by commas.
const BYTES: &str = "int8-layers";

/// Finds the tensors of `plan` that are never negative.
fn positive(plan: &Plan) -> Vec<bool> {
    let mut positive = vec![true; plan.tensors().len()];
    // A state equals its next value, which is known only after a pass. States begin as non-negative, and passes
    // repeat.
    for _ in 0..=plan.states().len() {
        for layer in plan.layers() {
            let all = layer.inputs().iter().all(|id| positive[id.index()]);
            positive[layer.output().index()] = match layer {
                Layer::Conv(conv) => conv.activation == Activation::Relu,
                Layer::Norm(norm) => norm.activation == Activation::Relu,
                Layer::Filter(filter) => filter.images.iter().all(|(read, _)| positive[read.tensor.index()]),
                Layer::Scale(Scale { factor, offset, .. }) => all && *factor >= 0.0 && *offset >= 0.0,
                Layer::Clamp(_) => true,
                // Corrections may fall slightly below 0. Int8 clamps these values, which has no visible effect.
                Layer::Pool(_)
                | Layer::SpaceToDepth(_)
                | Layer::DepthToSpace(_)
                | Layer::Join(_)
                | Layer::Spread(_)
                | Layer::Smooth(_)
                | Layer::Blend(_)
                | Layer::HistoryConfidence(_)
                | Layer::Accumulate(_)
                | Layer::Part(_)
                | Layer::Add(_)
                | Layer::Bypass(_)
                | Layer::Reproject(_)
                | Layer::Splat(_)
                | Layer::Warp(_) => all,
            };
        }
        plan.states()
            .iter()
            .for_each(|state| positive[state.previous.index()] = positive[state.next.index()]);
    }
    positive
}
