//! Shapes and number types of convolutions.

use super::patch::Source;
use crate::plan::{Activation, Padding};

/// Type of the factors of products. Sums are f32, or 32-bit integers for int8.
#[derive(Debug, Clone, PartialEq)]
pub enum Arithmetic {
    /// f32 × f32.
    F32,
    /// bf16 × bf16, in pairs.
    Bf16,
    /// bf16 × sum of two bf16, which has nearly the precision of f32. For inputs that are stored as bf16.
    SplitBf16,
    /// Unsigned × signed bytes, in quadruples, with a step for each input channel.
    Int8 {
        /// Step of each input channel: values are byte · step.
        steps: Vec<f32>,
        /// Ranges of transformed inputs for Winograd's tiles, \[place\]\[channel\]; `None` where they are unknown.
        reach: Option<Vec<f32>>,
    },
}

impl Arithmetic {
    /// Number of elements in a 32-bit word.
    pub fn count(&self) -> usize {
        match self {
            Self::F32 => 1,
            Self::Bf16 | Self::SplitBf16 => 2,
            Self::Int8 { .. } => 4,
        }
    }
}

/// Shape of a convolution.
#[derive(Debug, Clone, Copy)]
pub struct ConvShape {
    /// Number of input channels.
    pub inputs: usize,
    /// Number of output channels.
    pub outputs: usize,
    /// Edge of the window in pixels: 1 or 3.
    pub size: usize,
    /// Step between windows in pixels: 1 or 2.
    pub stride: usize,
    /// Values beyond the border.
    pub padding: Padding,
    /// Activation function.
    pub activation: Activation,
}

/// Output rows of one patch.
pub const ROWS: usize = 8;
/// Checks the number of channels.
///
/// # Panics
/// When the sources have not as many channels as the weights.
pub fn check(shape: &ConvShape, sources: &[Source<'_>]) {
    let inputs: usize = sources.iter().map(|source| source.channels()).sum();
    assert_eq!(shape.inputs, inputs, "a convolution reads what its weights are for");
}
