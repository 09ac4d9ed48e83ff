//! Prepares the layers of a plan, and runs those that are no convolutions.

use super::accumulate::{Expected, Fading, accumulate, history_confidence};
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
use super::spread::{blend, smooth, spread};
use super::tensor::{AnyTensor, Tensor, with_tensor};
use super::warp::warp;
use crate::Result;
use crate::plan::{Accumulate, Activation, Conv, Layer, Plan, TensorId, TensorSpec};
use crate::schedule::{Derived, Schedule};
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

    fn fading(&self, layer: &Accumulate) -> Fading<'a> {
        let share = layer.share.map(|id| self.picture(id));
        Fading { known: self.known(layer.known), share, fade: layer.fade }
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
    let (Layer::Reproject(moving), Layer::Accumulate(fading)) = (moving, fading) else {
        unreachable!("points are moved, then fade")
    };
    let (input, motion) = (given.picture(moving.input), given.picture(moving.motion));
    points::reproject(input, motion, Some(given.fading(fading)), out.picture_mut());
}

/// Runs `layer` alone and writes its output, the tensor `to`, to `out`. Convolutions, predicted kernels and pointwise
/// layers run with others, or with prepared weights.
pub fn run(
    layer: &Layer,
    step: &Step,
    given: Given<'_>,
    (to, pyramid): (&TensorSpec, &mut Pyramid),
    out: &mut AnyTensor,
) {
    let picture = |id: TensorId| given.picture(id);
    match layer {
        Layer::Conv(_) | Layer::Filter(_) => unreachable!("the engine runs prepared weights itself"),
        Layer::Scale(_) | Layer::Clamp(_) | Layer::Add(_) | Layer::Bypass(_) => {
            unreachable!("pointwise layers change a picture in place")
        }
        Layer::Norm(layer) => normalised(given.map(layer.input), step, out),
        Layer::Pool(layer) => match (given.map(layer.input), out) {
            (AnyTensor::F32(input), AnyTensor::F32(out)) => reshape::pool(input, out),
            (AnyTensor::Bf16(input), AnyTensor::Bf16(out)) => reshape::pool(input, out),
            _ => unreachable!("{SAME}"),
        },
        Layer::SpaceToDepth(layer) => reshape::space_to_depth(picture(layer.input), out.picture_mut()),
        Layer::DepthToSpace(layer) => reshape::depth_to_space(picture(layer.input), out.picture_mut()),
        Layer::Join(layer) => {
            reshape::join(picture(layer.colour), picture(layer.weight), out.picture_mut());
        }
        Layer::Spread(layer) => {
            let base = layer.base.map(picture);
            spread(given.known(layer.known), base, layer.levels, pyramid, out.picture_mut());
        }
        Layer::Smooth(layer) => smooth(picture(layer.input), out.picture_mut()),
        Layer::Blend(layer) => blend(given.known(layer.known), picture(layer.base), out.picture_mut()),
        Layer::HistoryConfidence(layer) => {
            let expected = Expected { prior: picture(layer.prior), fresh: picture(layer.fresh) };
            let levels = [layer.levels, to.level];
            history_confidence(given.known(layer.known), &expected, levels, pyramid, out.picture_mut());
        }
        // `out` already holds the earlier samples.
        Layer::Accumulate(layer) => accumulate(given.fading(layer), out.picture_mut()),
        Layer::Part(layer) => {
            reshape::part(picture(layer.input), layer.first, layer.channels, out.picture_mut());
        }
        Layer::Reproject(layer) => {
            points::reproject(picture(layer.input), picture(layer.motion), None, out.picture_mut());
        }
        Layer::Splat(layer) => points::splat(picture(layer.input), out.picture_mut()),
        Layer::Warp(layer) => match (given.map(layer.input), out) {
            (AnyTensor::F32(input), AnyTensor::F32(out)) => warp(input, picture(layer.motion), out),
            (AnyTensor::Bf16(input), AnyTensor::Bf16(out)) => warp(input, picture(layer.motion), out),
            _ => unreachable!("{SAME}"),
        },
    }
}

/// Normalises `input` with the weights in `step`.
fn normalised(input: &AnyTensor, step: &Step, out: &mut AnyTensor) {
    let Step::Norm { weight, bias, activation } = step else { unreachable!("normalisations are prepared") };
    let mut map = input.to_f32();
    normalise(&mut map, weight, bias, *activation);
    with_tensor!(out, out => {
        out.resize([map.height, map.width, map.channels]);
        out.data.iter_mut().zip(&map.data).for_each(|(to, &v)| *to = Element::from_f32(v));
    });
}

/// Message of panics where tensors of equal shapes differ in storage.
pub const SAME: &str = "tensors of as many channels are stored alike";
