//! L_s: differences of frames from their references.

use super::Perceptual;
use super::pictures::{means, picture_shape, zeros};
use crate::Result;
use serde::{Deserialize, Serialize};
use tch::Tensor;

/// Weights of the first frames of a clip in DeepFovea's own graph; later frames count 1.
pub const FRAME_WEIGHTS: [f64; 10] = [1e-5, 5e-5, 1e-4, 5e-4, 1e-3, 5e-3, 0.01, 0.05, 0.1, 0.5];

/// Weights of the frames of a clip. The first frames have little history and may count less.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WarmUp {
    /// 1 for every frame.
    None,
    /// 1 − e^(−rate·i) for frame i, which is 0 for the first.
    Exponential(f64),
    /// DeepFovea's table [`FRAME_WEIGHTS`].
    Deepfovea,
}

impl WarmUp {
    /// Weight of frame `i`, counted from 0.
    pub fn weight(self, i: usize) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Exponential(rate) => 1.0 - (-rate * i as f64).exp(),
            Self::Deepfovea => FRAME_WEIGHTS.get(i).copied().unwrap_or(1.0),
        }
    }
}

/// Difference of one frame of each clip from its reference: means over its pixels, \[N\].
#[derive(Debug)]
pub struct FrameDifference {
    /// Distance by the perceptual measure.
    pub perceptual: Tensor,
    /// Mean absolute difference.
    pub l1: Tensor,
    /// Mean squared difference.
    pub squares: Tensor,
    /// Mean squared difference of block averages for each of [`COARSE`], times the pixels of a block.
    pub coarse: [Tensor; 2],
}

/// Sides of the blocks whose averages are compared, in pixels. On common screens the eye is most sensitive to these
/// scales.
pub const COARSE: [i64; 2] = [4, 16];

/// Measures how `output` \[N, 3, H, W\] differs from `reference`.
///
/// `wanted` are the weights of the four measures; measures of weight 0 are skipped and return 0.
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

/// Mean squared block average of `difference` \[N, 3, H, W\] over blocks of `edge`² pixels, times the pixels of a
/// block. White noise counts as much as in the mean squared difference of pixels; smooth errors count more.
fn coarse_squares(difference: &Tensor, edge: i64) -> Tensor {
    let (height, width) = (difference.size()[2], difference.size()[3]);
    let edges = [edge.min(height), edge.min(width)];
    let averages = difference.avg_pool2d(edges, edges, [0, 0], false, true, None::<i64>);
    means(&averages.square()) * (edges[0] * edges[1]) as f64
}

/// `distances` \[N\] of `output`, differentiated immediately.
///
/// The result has the values and gradients of `distances(output)`, provided that each distance depends on its own
/// picture alone. Only the gradient is kept: activations of a deep network are freed before the next frame.
fn early(output: &Tensor, distances: impl Fn(&Tensor) -> Result<Tensor>) -> Result<Tensor> {
    if !output.requires_grad() {
        return distances(output);
    }
    let leaf = output.detach().set_requires_grad(true);
    let values = distances(&leaf)?;
    if !values.requires_grad() {
        // No gradients are recorded inside `no_grad`.
        return Ok(values);
    }
    let gradients = Tensor::f_run_backward(&[&values.sum(None)], &[&leaf], false, false)?;
    let linear = (output * &gradients[0]).sum_dim_intlist([1i64, 2, 3].as_slice(), false, None);
    Ok(&linear - linear.detach() + values.detach())
}
