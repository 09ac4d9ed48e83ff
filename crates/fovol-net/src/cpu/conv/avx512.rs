//! 14 pixels × 32 (or 16) channels in the 32 registers of AVX-512.

use super::Call;
use std::arch::x86_64::*;

/// Pixels of a group.
pub const GROUP: usize = 14;

/// 32 channels.
///
/// # Safety
/// As [`sixteen`].
#[target_feature(enable = "avx512f")]
pub unsafe fn thirty_two(call: &Call, out: *mut f32) {
    // SAFETY: the caller's.
    unsafe { kernel::<2>(call, out) }
}

/// 16 channels.
///
/// # Safety
/// AVX-512 must be available, the call's patch and weights readable, `out` writable for a whole block.
#[target_feature(enable = "avx512f")]
pub unsafe fn sixteen(call: &Call, out: *mut f32) {
    // SAFETY: the caller's.
    unsafe { kernel::<1>(call, out) }
}

#[inline(always)]
unsafe fn kernel<const V: usize>(call: &Call, out: *mut f32) {
    // SAFETY: the caller's.
    unsafe {
        let bias: [__m512; V] = std::array::from_fn(|v| _mm512_loadu_ps(call.bias.add(16 * v)));
        let mut sums = [bias; GROUP];
        for row in 0..call.rows {
            let patch = call.patch.add(row * call.row);
            let mut weights = call.weights.add(row * call.run * 16 * V);
            for k in 0..call.run {
                let mut w = [_mm512_setzero_ps(); V];
                for v in 0..V {
                    w[v] = _mm512_loadu_ps(weights.add(16 * v));
                }
                weights = weights.add(16 * V);
                for p in 0..GROUP {
                    let value = _mm512_set1_ps(*patch.add(p * call.pixel + k));
                    for v in 0..V {
                        sums[p][v] = _mm512_fmadd_ps(value, w[v], sums[p][v]);
                    }
                }
            }
        }
        for p in 0..GROUP {
            for v in 0..V {
                _mm512_storeu_ps(out.add((p * V + v) * 16), sums[p][v]);
            }
        }
    }
}
