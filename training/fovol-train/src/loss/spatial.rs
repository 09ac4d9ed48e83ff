//! L_s: how each frame differs from its reference.

use super::{Perceptual, mean, picture_shape, zero_like};
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

/// How one frame differs from its reference: means over its pixels, scalars.
#[derive(Debug)]
pub struct FrameDifference {
    /// By the perceptual measure.
    pub perceptual: Tensor,
    /// Mean absolute difference.
    pub l1: Tensor,
    /// Mean squared difference.
    pub squares: Tensor,
}

/// How `output` \[N, 3, H, W\] differs from `reference`.
///
/// Measures of little use to the caller can be left out, and are 0 then: `wanted` are the weights of all three.
///
/// # Errors
/// Pictures that `measure` cannot compare.
pub fn frame_difference(
    measure: &dyn Perceptual,
    wanted: [f64; 3],
    output: &Tensor,
    reference: &Tensor,
) -> Result<FrameDifference> {
    picture_shape(output, reference)?;
    let perceptual = if wanted[0] == 0.0 {
        zero_like(output)
    } else {
        early(output, |output| measure.distance(output, reference))?
    };
    let l1 = if wanted[1] == 0.0 { zero_like(output) } else { mean(&(output - reference).abs()) };
    let squares = if wanted[2] == 0.0 { zero_like(output) } else { mean(&(output - reference).square()) };
    Ok(FrameDifference { perceptual, l1, squares })
}

/// `distance` of `output`, differentiated at once.
///
/// What comes back has the value and the gradient of `distance(output)`, but holds on to nothing except the
/// gradient: what a deep network computed of one frame is gone before the next frame's turn.
fn early(output: &Tensor, distance: impl Fn(&Tensor) -> Result<Tensor>) -> Result<Tensor> {
    if !output.requires_grad() {
        return distance(output);
    }
    let leaf = output.detach().set_requires_grad(true);
    let value = distance(&leaf)?;
    if !value.requires_grad() {
        // Inside `no_grad`.
        return Ok(value);
    }
    let gradients = Tensor::f_run_backward(&[&value], &[&leaf], false, false)?;
    let linear = (output * &gradients[0]).sum(None);
    Ok(&linear - linear.detach() + value.detach())
}
