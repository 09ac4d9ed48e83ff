use crate::cpu::conv::prediction::Prediction;
use crate::plan::{Normalisation, Taps};
use fovol_simd::Simd;

/// A predicted kernel with its weights. All arithmetic is f32: kernels make pictures, for which the eight bits of
/// bf16 are too few, and their cost is small.
#[derive(Debug, Clone)]
pub struct PreparedFilter {
    /// Predicts the weights of kernels, and the addition.
    pub prediction: Prediction,
    /// Number of outputs of the prediction that are weights.
    pub weights: usize,
    pub has_addition: bool,
    pub expand: usize,
    pub taps: Vec<Taps>,
    pub normalisation: Normalisation,
    pub simd: Simd,
}
