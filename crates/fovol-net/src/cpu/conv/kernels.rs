//! Convolution kernels of each instruction set, and their sizes.

use super::call::Kernel;
use super::portable;
use super::shape::Arithmetic;
#[cfg(target_arch = "x86_64")]
use super::{amx, avx2, avx512};
use fovol_simd::Simd;
use std::ops::Range;

/// Whether `simd` multiplies `arithmetic` in AMX tiles.
pub fn multiplies_tiles(simd: Simd, arithmetic: &Arithmetic) -> bool {
    matches!(simd, Simd::Amx { .. }) && *arithmetic != Arithmetic::F32
}

/// Number of pixels that a convolution kernel computes at once.
pub fn group(simd: Simd, arithmetic: &Arithmetic) -> usize {
    match simd {
        #[cfg(target_arch = "x86_64")]
        Simd::Amx { .. } if multiplies_tiles(simd, arithmetic) => amx::GROUP,
        #[cfg(target_arch = "x86_64")]
        Simd::Avx512 { .. } | Simd::Amx { .. } => avx512::GROUP,
        #[cfg(target_arch = "x86_64")]
        Simd::Avx2 { .. } => avx2::GROUP,
        _ => portable::GROUP,
    }
}

/// Number of words of a window's row that a convolution kernel multiplies at once.
pub fn run(simd: Simd, arithmetic: &Arithmetic) -> usize {
    match simd {
        #[cfg(target_arch = "x86_64")]
        Simd::Amx { .. } if multiplies_tiles(simd, arithmetic) => amx::RUN,
        _ => 1,
    }
}

/// Output channels that one kernel computes together.
pub struct OutputBlock {
    /// First channel.
    pub first: usize,
    /// Number of channels, including padding after the last one.
    pub width: usize,
    /// Channels without padding.
    pub channels: Range<usize>,
    /// Bias of each channel; 0 for padding.
    pub bias: Vec<f32>,
    pub kernel: Kernel,
}

/// Divides output channels, one for each `bias`, into the blocks of the kernels of `simd`.
pub fn output_blocks(simd: Simd, arithmetic: &Arithmetic, bias: &[f32]) -> Vec<OutputBlock> {
    let (outputs, mut first, mut blocks) = (bias.len(), 0, Vec::new());
    while first < outputs {
        let (width, kernel) = block(simd, outputs - first, arithmetic);
        let channels = first..(first + width).min(outputs);
        let mut padded = bias[channels.clone()].to_vec();
        padded.resize(width, 0.0);
        blocks.push(OutputBlock { first, width, channels, bias: padded, kernel });
        first += width;
    }
    blocks
}

/// Chooses a convolution kernel for the next channels, of which `left` remain. Returns the number of channels
/// that it computes and the kernel; plain code where `simd` has none.
fn block(simd: Simd, left: usize, arithmetic: &Arithmetic) -> (usize, Kernel) {
    #[cfg(target_arch = "x86_64")]
    if matches!(simd, Simd::Avx512 { .. } | Simd::Amx { .. }) {
        let [wide, narrow]: [Kernel; 2] = match (arithmetic, matches!(simd, Simd::Amx { .. })) {
            (Arithmetic::F32, _) => [avx512::f32::thirty_two, avx512::f32::sixteen],
            (Arithmetic::Bf16 | Arithmetic::SplitBf16, true) => [amx::bf16::thirty_two, amx::bf16::sixteen],
            (Arithmetic::Bf16 | Arithmetic::SplitBf16, false) => {
                [avx512::bf16::thirty_two, avx512::bf16::sixteen]
            }
            (Arithmetic::Int8 { .. }, true) => [amx::int8::thirty_two, amx::int8::sixteen],
            (Arithmetic::Int8 { .. }, false) => [avx512::int8::thirty_two, avx512::int8::sixteen],
        };
        return if left > 16 { (32, wide) } else { (16, narrow) };
    }
    #[cfg(target_arch = "x86_64")]
    if matches!(simd, Simd::Avx2 { .. }) {
        let kernel: Kernel = match arithmetic {
            Arithmetic::Int8 { .. } => avx2::int8,
            _ => avx2::f32,
        };
        return (16, kernel);
    }
    let kernel: Kernel = match arithmetic {
        Arithmetic::F32 => portable::f32,
        Arithmetic::Bf16 | Arithmetic::SplitBf16 => portable::bf16,
        Arithmetic::Int8 { .. } => portable::int8,
    };
    (portable::WIDTH, kernel)
}
