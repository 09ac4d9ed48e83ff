//! Convolution kernels for AVX2: 6 pixels × 16 channels in its 16 registers.

use super::call::Call;
use std::arch::x86_64::*;

/// Number of pixels of a group.
pub const GROUP: usize = 6;

/// Defines a kernel of 16 channels for one type of arithmetic.
macro_rules! kernel {
    ($name:ident, $features:literal, $doc:literal, $start:expr, $step:expr) => {
        #[doc = $doc]
        ///
        /// # Safety
        /// The instructions must be available, the call's patch and weights readable, `out` writable for a whole block.
        #[target_feature(enable = $features)]
        pub unsafe fn $name(call: &Call, out: *mut f32) {
            // SAFETY: required of the caller.
            unsafe {
                let start = [$start(call.bias), $start(call.bias.add(8))];
                let mut sums = [start; GROUP];
                for row in 0..call.rows {
                    let patch = call.patch.add(row * call.row);
                    let mut weights = call.weights.add(row * call.run * 16);
                    for k in 0..call.run {
                        let w =
                            [_mm256_loadu_si256(weights.cast()), _mm256_loadu_si256(weights.add(8).cast())];
                        weights = weights.add(16);
                        for p in 0..GROUP {
                            let value = _mm256_set1_epi32(*patch.add(p * call.pixel + k) as i32);
                            sums[p] = [$step(sums[p][0], value, w[0]), $step(sums[p][1], value, w[1])];
                        }
                    }
                }
                for p in 0..GROUP {
                    _mm256_storeu_si256(out.add(p * 16).cast(), sums[p][0]);
                    _mm256_storeu_si256(out.add(p * 16 + 8).cast(), sums[p][1]);
                }
            }
        }
    };
}

kernel!(
    f32,
    "avx2,fma",
    "Kernel for f32: each word holds one number.",
    |bias: *const f32| _mm256_castps_si256(_mm256_loadu_ps(bias)),
    |sum, v, w| _mm256_castps_si256(_mm256_fmadd_ps(
        _mm256_castsi256_ps(v),
        _mm256_castsi256_ps(w),
        _mm256_castsi256_ps(sum)
    ))
);
kernel!(
    int8,
    "avx2,avxvnni",
    "Kernel for bytes, four in each word; needs AVX-VNNI.",
    |_: *const f32| _mm256_setzero_si256(),
    |sum, v, w| _mm256_dpbusd_avx_epi32(sum, v, w)
);
