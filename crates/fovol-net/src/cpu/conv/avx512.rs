//! Convolution kernels for AVX-512: 14 pixels × 32 (or 16) channels in its 32 registers.

use super::call::Call;
use std::arch::x86_64::*;

/// Number of pixels of a group.
pub const GROUP: usize = 14;

/// Defines the kernels of one type of arithmetic, for 32 and for 16 channels.
macro_rules! kernels {
    ($module:ident, $features:literal, $doc:literal, $start:expr, $step:expr) => {
        #[doc = $doc]
        pub mod $module {
            use super::*;

            /// Kernel for 32 channels.
            ///
            /// # Safety
            /// The instructions must be available, the call's patch and weights readable, `out` writable for a
            /// whole block.
            #[target_feature(enable = $features)]
            pub unsafe fn thirty_two(call: &Call, out: *mut f32) {
                // SAFETY: required of the caller.
                unsafe { kernel::<2>(call, out) }
            }

            /// Kernel for 16 channels.
            ///
            /// # Safety
            /// The conditions of [`thirty_two`].
            #[target_feature(enable = $features)]
            pub unsafe fn sixteen(call: &Call, out: *mut f32) {
                // SAFETY: required of the caller.
                unsafe { kernel::<1>(call, out) }
            }

            #[inline]
            #[target_feature(enable = $features)]
            unsafe fn kernel<const V: usize>(call: &Call, out: *mut f32) {
                // SAFETY: required of the caller.
                unsafe {
                    let mut sums = [[_mm512_setzero_si512(); V]; GROUP];
                    for v in 0..V {
                        let start = $start(call.bias.add(16 * v));
                        for p in 0..GROUP {
                            sums[p][v] = start;
                        }
                    }
                    for row in 0..call.rows {
                        let patch = call.patch.add(row * call.row);
                        let mut weights = call.weights.add(row * call.run * 16 * V);
                        for k in 0..call.run {
                            let mut w = [_mm512_setzero_si512(); V];
                            for v in 0..V {
                                w[v] = _mm512_loadu_si512(weights.add(16 * v).cast());
                            }
                            weights = weights.add(16 * V);
                            for p in 0..GROUP {
                                let value = _mm512_set1_epi32(*patch.add(p * call.pixel + k) as i32);
                                for v in 0..V {
                                    sums[p][v] = $step(sums[p][v], value, w[v]);
                                }
                            }
                        }
                    }
                    for p in 0..GROUP {
                        for v in 0..V {
                            _mm512_storeu_si512(out.add((p * V + v) * 16).cast(), sums[p][v]);
                        }
                    }
                }
            }
        }
    };
}

kernels!(
    f32,
    "avx512f",
    "Kernels for f32: each word holds one number.",
    |bias: *const f32| _mm512_castps_si512(_mm512_loadu_ps(bias)),
    |sum, v, w| _mm512_castps_si512(_mm512_fmadd_ps(
        _mm512_castsi512_ps(v),
        _mm512_castsi512_ps(w),
        _mm512_castsi512_ps(sum)
    ))
);
kernels!(
    bf16,
    "avx512f,avx512bf16",
    "Kernels for bf16, two in each word.",
    |bias: *const f32| _mm512_castps_si512(_mm512_loadu_ps(bias)),
    |sum, v, w| _mm512_castps_si512(_mm512_dpbf16_ps(
        _mm512_castsi512_ps(sum),
        std::mem::transmute::<__m512i, __m512bh>(v),
        std::mem::transmute::<__m512i, __m512bh>(w)
    ))
);
kernels!(
    int8,
    "avx512f,avx512vnni",
    "Kernels for bytes, four in each word.",
    |_: *const f32| _mm512_setzero_si512(),
    |sum, v, w| _mm512_dpbusd_epi32(sum, v, w)
);
