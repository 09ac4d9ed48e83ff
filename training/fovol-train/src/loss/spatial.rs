//! L_s: how each frame differs from its reference.

use super::{Perceptual, means, picture_shape, zeros};
use crate::Result;
use serde::{Deserialize, Serialize};
use tch::Tensor;

/// The weights of the frames of a clip: the first ones know little of what came before them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarmUp {
    /// 1 for every frame.
    None,
    /// 1 − e^(−rate·i) for frame i: 0 for the first.
    Exponential(f64),
    /// The table of DeepFovea: [`super::deepfovea::FRAME_WEIGHTS`].
    Deepfovea,
}

impl WarmUp {
    /// The weight of frame `i`, counted from 0.
    pub fn weight(self, i: usize) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Exponential(rate) => 1.0 - (-rate * i as f64).exp(),
            Self::Deepfovea => super::deepfovea::FRAME_WEIGHTS.get(i).copied().unwrap_or(1.0),
        }
    }
}

/// How one frame of each clip differs from its reference: means over its pixels, \[N\].
#[derive(Debug)]
pub struct FrameDifference {
    /// By the perceptual measure.
    pub perceptual: Tensor,
    /// Mean absolute difference.
    pub l1: Tensor,
    /// Mean squared difference.
    pub squares: Tensor,
    /// Of means over squares of pixels, for each of [`COARSE`], times the pixels of a square.
    pub coarse: [Tensor; 2],
}

/// Edges of the squares of pixels whose means are compared, in pixels. On a usual screen these are what eyes see best.
pub const COARSE: [i64; 2] = [4, 16];

/// How `output` \[N, 3, H, W\] differs from `reference`.
///
/// Measures of little use to the caller can be left out, and are 0 then: `wanted` are the weights of all four.
///
/// # Errors
/// Pictures that `measure` cannot compare.
pub fn frame_difference(
    measure: &dyn Perceptual,
    wanted: [f64; 4],
    output: &Tensor,
    reference: &Tensor,
) -> Result<FrameDifference> {
    picture_shape(output, reference)?;
    let perceptual = if wanted[0] == 0.0 {
        zeros(output)
    } else {
        early(output, |output| measure.distances(output, reference))?
    };
    let l1 = if wanted[1] == 0.0 { zeros(output) } else { means(&(output - reference).abs()) };
    let squares = if wanted[2] == 0.0 { zeros(output) } else { means(&(output - reference).square()) };
    let coarse = COARSE.map(|edge| match wanted[3] {
        0.0 => zeros(output),
        _ => coarse_squares(&(output - reference), edge),
    });
    Ok(FrameDifference { perceptual, l1, squares, coarse })
}

/// The mean square of the means of `difference` \[N, 3, H, W\] over squares of `edge` by `edge` pixels, times the pixels of a
/// square: what has no pattern counts as much as in the mean square of all pixels, what is smooth counts more.
fn coarse_squares(difference: &Tensor, edge: i64) -> Tensor {
    let (height, width) = (difference.size()[2], difference.size()[3]);
    let edges = [edge.min(height), edge.min(width)];
    let averages = difference.avg_pool2d(edges, edges, [0, 0], false, true, None::<i64>);
    means(&averages.square()) * (edges[0] * edges[1]) as f64
}

/// `distances` \[N\] of `output`, differentiated at once.
///
/// What comes back has the values and the gradients of `distances(output)`, each of its own picture alone, but holds on to nothing except the
/// gradient: what a deep network computed of one frame is gone before the next frame's turn.
fn early(output: &Tensor, distances: impl Fn(&Tensor) -> Result<Tensor>) -> Result<Tensor> {
    if !output.requires_grad() {
        return distances(output);
    }
    let leaf = output.detach().set_requires_grad(true);
    let values = distances(&leaf)?;
    if !values.requires_grad() {
        // Inside `no_grad`.
        return Ok(values);
    }
    let gradients = Tensor::f_run_backward(&[&values.sum(None)], &[&leaf], false, false)?;
    let linear = (output * &gradients[0]).sum_dim_intlist([1i64, 2, 3].as_slice(), false, None);
    Ok(&linear - linear.detach() + values.detach())
}
