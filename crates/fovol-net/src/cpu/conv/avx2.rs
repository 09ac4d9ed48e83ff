//! 6 pixels × 16 channels in the 16 registers of AVX2.

use super::Call;
use std::arch::x86_64::*;

/// Pixels of a group.
pub const GROUP: usize = 6;

/// 16 channels.
///
/// # Safety
/// AVX2 and FMA must be available, the call's patch and weights readable, `out` writable for a whole block.
#[target_feature(enable = "avx2,fma")]
pub unsafe fn sixteen(call: &Call, out: *mut f32) {
    // SAFETY: the caller's.
    unsafe {
        let bias = [_mm256_loadu_ps(call.bias), _mm256_loadu_ps(call.bias.add(8))];
        let mut sums = [bias; GROUP];
        for row in 0..call.rows {
            let patch = call.patch.add(row * call.row);
            let mut weights = call.weights.add(row * call.run * 16);
            for k in 0..call.run {
                let w = [_mm256_loadu_ps(weights.cast()), _mm256_loadu_ps(weights.add(8).cast())];
                weights = weights.add(16);
                for p in 0..GROUP {
                    let value = _mm256_set1_ps(f32::from_bits(*patch.add(p * call.pixel + k)));
                    sums[p][0] = _mm256_fmadd_ps(value, w[0], sums[p][0]);
                    sums[p][1] = _mm256_fmadd_ps(value, w[1], sums[p][1]);
                }
            }
        }
        for p in 0..GROUP {
            _mm256_storeu_ps(out.add(p * 16), sums[p][0]);
            _mm256_storeu_ps(out.add(p * 16 + 8), sums[p][1]);
        }
    }
}
