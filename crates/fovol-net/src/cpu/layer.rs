//! Prepares the layers of a plan, and runs those that are no convolutions.

use super::accumulate::{Expected, Fading, accumulate, doubt};
use super::conv::{Arithmetic, ConvShape, PreparedConv};
use super::element::Element;
use super::filter::PreparedFilter;
use super::norm::normalise;
use super::patch::unfolded;
use super::points;
use super::precision::Choice;
use super::pyramid::Pyramid;
use super::reshape;
use super::samples::{KnownPixels, Samples};
use super::schedule::{Derived, Schedule};
use super::spread::{blend, smooth, spread};
use super::tensor::{AnyTensor, Tensor, with_tensor};
use super::warp::warp;
use crate::Result;
use crate::plan::{Activation, Conv, Layer, Plan, TensorId, TensorSpec};
use crate::weights::Weights;
use fovol_simd::Simd;

/// A layer with its prepared weights.
#[derive(Debug)]
pub enum Step {
    Conv(Box<PreparedConv>),
    Filter(Box<PreparedFilter>),
    Norm {
        weight: Vec<f32>,
        bias: Vec<f32>,
        activation: Activation,
    },
    /// A layer without weights.
    Plain,
}

impl Step {
    /// Prepares layer `number` of `plan`. `choice` gives the arithmetic, and `schedule` the fusion.
    ///
    /// # Errors
    /// Weights that are missing.
    pub fn new(
        (plan, number): (&Plan, usize),
        weights: &Weights,
        simd: Simd,
        (choice, schedule): (&Choice<'_>, &Schedule),
    ) -> Result<Self> {
        let pair = |name: &str| -> Result<(&[f32], &[f32])> {
            Ok((weights.values(&format!("{name}.weight"))?, weights.values(&format!("{name}.bias"))?))
        };
        let channels = |id: TensorId| plan.tensor(id).channels;
        Ok(match &plan.layers()[number] {
            Layer::Conv(conv) => {
                let (weight, bias) = pair(&conv.name)?;
                let shape = ConvShape {
                    inputs: conv.inputs.iter().map(|read| channels(read.tensor)).sum(),
                    outputs: channels(conv.output),
                    size: conv.size,
                    stride: conv.stride,
                    padding: conv.padding,
                    activation: conv.activation,
                };
                let inputs = inputs(plan, conv, schedule);
                let arithmetic = match choice.of(conv) {
                    Arithmetic::Int8 { steps, reach } => {
                        let count = inputs.len();
                        let ordered = |of: &[f32]| inputs.iter().map(|&at| of[at]).collect::<Vec<f32>>();
                        let is_known = |reach: &Vec<f32>| reach.len().is_multiple_of(count);
                        let reach = reach.filter(is_known);
                        let reach = reach.map(|reach| reach.chunks_exact(count).flat_map(ordered).collect());
                        Arithmetic::Int8 { steps: ordered(&steps), reach }
                    }
                    other => other,
                };
                let weight = reordered(weight, &inputs, conv.size * conv.size);
                Self::Conv(Box::new(PreparedConv::new(&shape, &weight, bias, simd, arithmetic)))
            }
            Layer::Filter(filter) => {
                let predicted = schedule.additions[number].map(|addition| &plan.layers()[addition.predicted]);
                let addition = predicted.map(|layer| pair(layer.name())).transpose()?;
                let parameters = pair(&filter.name)?;
                let prepared = PreparedFilter::new(filter, parameters, addition, simd);
                Self::Filter(Box::new(prepared))
            }
            Layer::Norm(norm) => {
                let (weight, bias) = pair(&norm.name)?;
                Self::Norm { weight: weight.to_vec(), bias: bias.to_vec(), activation: norm.activation }
            }
            _ => Self::Plain,
        })
    }
}

/// For each channel that `conv` reads, in reading order, its number in the plan.
fn inputs(plan: &Plan, conv: &Conv, schedule: &Schedule) -> Vec<usize> {
    let mut order = Vec::new();
    for read in &conv.inputs {
        let first = order.len();
        let channels = plan.tensor(read.tensor).channels;
        match schedule.derived[read.tensor.index()] {
            Some((_, Derived::Folded | Derived::FoldedChannel(_))) => {
                order.extend(unfolded(channels / 4).map(|at| first + at));
            }
            _ => order.extend(first..first + channels),
        }
    }
    order
}

/// Reorders the inputs of `weights` \[out, in, `taps`\].
fn reordered(weights: &[f32], inputs: &[usize], taps: usize) -> Vec<f32> {
    let of_output = |weights: &[f32]| {
        inputs.iter().flat_map(|at| weights[at * taps..(at + 1) * taps].to_vec()).collect::<Vec<_>>()
    };
    weights.chunks_exact(inputs.len() * taps).flat_map(of_output).collect()
}

/// Inputs of layers.
#[derive(Clone, Copy)]
pub struct Given<'a> {
    pub tensors: &'a [AnyTensor],
    /// Samples of the frame, and the tensor that they replace, if layers read samples as a list.
    pub samples: Option<(TensorId, &'a Samples)>,
}

impl<'a> Given<'a> {
    fn map(&self, id: TensorId) -> &'a AnyTensor {
        &self.tensors[id.index()]
    }

    /// Returns a tensor that is stored as f32.
    pub fn picture(&self, id: TensorId) -> &'a Tensor {
        self.map(id).picture()
    }

    fn fading(&self, known: TensorId, share: Option<TensorId>, fade: f32) -> Fading<'a> {
        Fading { known: self.known(known), share: share.map(|id| self.picture(id)), fade }
    }

    fn known(&self, id: TensorId) -> KnownPixels<'a> {
        match self.samples {
            Some((known, samples)) if known == id => KnownPixels::Samples(samples),
            _ => KnownPixels::All(self.picture(id)),
        }
    }
}

/// Runs the layers `moving` (reprojection of points) and `fading` (their accumulation) together, and writes to
/// `out`.
pub fn run_points(moving: &Layer, fading: &Layer, given: Given<'_>, out: &mut AnyTensor) {
    let (Layer::Reproject { input, motion, .. }, &Layer::Accumulate { known, share, fade, .. }) =
        (moving, fading)
    else {
        unreachable!("points are moved, then fade")
    };
    let fading = given.fading(known, share, fade);
    points::reproject(given.picture(*input), given.picture(*motion), Some(fading), out.picture_mut());
}

/// Runs `layer` alone and writes its output, the tensor `to`, to `out`.
pub fn run(
    layer: &Layer,
    step: &Step,
    given: Given<'_>,
    (to, pyramid): (&TensorSpec, &mut Pyramid),
    out: &mut AnyTensor,
) {
    match (layer, step, out) {
        (Layer::Norm(norm), Step::Norm { weight, bias, activation }, out) => {
            let mut map = given.map(norm.input).to_f32();
            normalise(&mut map, weight, bias, *activation);
            with_tensor!(out, out => {
                out.resize([map.height, map.width, map.channels]);
                out.data.iter_mut().zip(&map.data).for_each(|(to, &v)| *to = Element::from_f32(v));
            });
        }
        (layer, _, out) => run_plain(layer, given, (to, pyramid), out),
    }
}

fn run_plain(
    layer: &Layer,
    given: Given<'_>,
    (&TensorSpec { channels, level, .. }, pyramid): (&TensorSpec, &mut Pyramid),
    out: &mut AnyTensor,
) {
    let map = |id: &TensorId| given.map(*id);
    let picture = |id: &TensorId| given.picture(*id);
    match (layer, out) {
        (Layer::Pool { input, .. }, out) => match (map(input), out) {
            (AnyTensor::F32(input), AnyTensor::F32(out)) => reshape::pool(input, out),
            (AnyTensor::Bf16(input), AnyTensor::Bf16(out)) => reshape::pool(input, out),
            _ => unreachable!("{SAME}"),
        },
        (Layer::Warp { input, motion, .. }, out) => match (map(input), out) {
            (AnyTensor::F32(input), AnyTensor::F32(out)) => warp(input, picture(motion), out),
            (AnyTensor::Bf16(input), AnyTensor::Bf16(out)) => warp(input, picture(motion), out),
            _ => unreachable!("{SAME}"),
        },
        (Layer::SpaceToDepth { input, .. }, AnyTensor::F32(out)) => {
            reshape::space_to_depth(picture(input), out);
        }
        (Layer::DepthToSpace { input, .. }, AnyTensor::F32(out)) => {
            reshape::depth_to_space(picture(input), out);
        }
        (Layer::Join { colour, weight, .. }, AnyTensor::F32(out)) => {
            reshape::join(picture(colour), picture(weight), out);
        }
        (Layer::Part { input, first, .. }, AnyTensor::F32(out)) => {
            reshape::part(picture(input), *first, channels, out);
        }
        (Layer::Spread { known, base, levels, .. }, AnyTensor::F32(out)) => {
            spread(given.known(*known), base.as_ref().map(picture), *levels, pyramid, out);
        }
        (Layer::Smooth { input, .. }, AnyTensor::F32(out)) => smooth(picture(input), out),
        (Layer::Blend { known, base, .. }, AnyTensor::F32(out)) => {
            blend(given.known(*known), picture(base), out);
        }
        (Layer::Doubt { known, prior, fresh, levels, .. }, AnyTensor::F32(out)) => {
            let expected = Expected { prior: picture(prior), fresh: picture(fresh) };
            doubt(given.known(*known), &expected, [*levels, level], pyramid, out);
        }
        // `out` already holds the earlier samples.
        (Layer::Accumulate { known, share, fade, .. }, AnyTensor::F32(out)) => {
            accumulate(given.fading(*known, *share, *fade), out);
        }
        (Layer::Reproject { input, motion, .. }, AnyTensor::F32(out)) => {
            points::reproject(picture(input), picture(motion), None, out);
        }
        (Layer::Splat { input, .. }, AnyTensor::F32(out)) => points::splat(picture(input), out),
        _ => unreachable!("pictures are stored as f32, and layers with weights are prepared"),
    }
}

/// Message of panics where tensors of equal shapes differ in storage.
pub const SAME: &str = "tensors of as many channels are stored alike";
