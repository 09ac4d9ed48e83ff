#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the safety comment of the impl speaks for all its one-instruction methods"
)]

use super::{Lanes, PICK_HIGH, PICK_LOW};
use std::arch::x86_64::*;

/// 8 lanes of AVX2 and FMA.
#[derive(Debug, Clone, Copy)]
pub struct Avx2;

/// Lane i takes lane i − 1; lane 0 takes `first`.
#[inline(always)]
unsafe fn by1(v: __m256, first: f32) -> __m256 {
    // SAFETY: the caller runs where AVX2 is available.
    unsafe {
        let from = _mm256_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6);
        _mm256_blend_ps::<0b0000_0001>(_mm256_permutevar8x32_ps(v, from), _mm256_set1_ps(first))
    }
}

/// Lane i takes lane i − 2; the first two take 1.
#[inline(always)]
unsafe fn by2(v: __m256) -> __m256 {
    // SAFETY: the caller runs where AVX2 is available.
    unsafe {
        let from = _mm256_setr_epi32(0, 0, 0, 1, 2, 3, 4, 5);
        _mm256_blend_ps::<0b0000_0011>(_mm256_permutevar8x32_ps(v, from), _mm256_set1_ps(1.0))
    }
}

/// Lane i takes lane i − 4; the first four take 1.
#[inline(always)]
unsafe fn by4(v: __m256) -> __m256 {
    // SAFETY: the caller runs where AVX2 is available.
    unsafe { _mm256_blend_ps::<0b0000_1111>(_mm256_permute2f128_ps::<0x00>(v, v), _mm256_set1_ps(1.0)) }
}

/// Whether this processor has it.
pub fn available() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

// SAFETY: every method only wraps instructions of AVX2 and FMA, which the trait's contract requires.
#[rustfmt::skip]
unsafe impl Lanes for Avx2 {
    const N: usize = 8;
    type F = __m256;
    type I = __m256i;
    type M = __m256;

    #[inline(always)] unsafe fn splat(x: f32) -> __m256 { unsafe { _mm256_set1_ps(x) } }
    #[inline(always)] unsafe fn load(from: *const f32) -> __m256 { unsafe { _mm256_loadu_ps(from) } }
    #[inline(always)] unsafe fn store(v: __m256, to: *mut f32) { unsafe { _mm256_storeu_ps(to, v) } }
    #[inline(always)] unsafe fn add(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_add_ps(a, b) } }
    #[inline(always)] unsafe fn sub(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_sub_ps(a, b) } }
    #[inline(always)] unsafe fn mul(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_mul_ps(a, b) } }
    #[inline(always)] unsafe fn div(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_div_ps(a, b) } }
    #[inline(always)] unsafe fn fma(a: __m256, b: __m256, c: __m256) -> __m256 { unsafe { _mm256_fmadd_ps(a, b, c) } }
    #[inline(always)] unsafe fn min(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_min_ps(a, b) } }
    #[inline(always)] unsafe fn max(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_max_ps(a, b) } }
    #[inline(always)] unsafe fn sqrt(a: __m256) -> __m256 { unsafe { _mm256_sqrt_ps(a) } }
    #[inline(always)] unsafe fn ceil(a: __m256) -> __m256 { unsafe { _mm256_ceil_ps(a) } }
    #[inline(always)] unsafe fn abs(a: __m256) -> __m256 { unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) } }
    #[inline(always)] unsafe fn iota() -> __m256 { unsafe { _mm256_setr_ps(0., 1., 2., 3., 4., 5., 6., 7.) } }
    #[inline(always)]
    unsafe fn sum(a: __m256) -> f32 {
        unsafe {
            let four = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
        }
    }
    #[inline(always)]
    unsafe fn products_before(a: __m256) -> (__m256, f32) {
        unsafe {
            let p = _mm256_mul_ps(a, by1(a, 1.0));
            let p = _mm256_mul_ps(p, by2(p));
            let p = _mm256_mul_ps(p, by4(p));
            let last = _mm256_permutevar8x32_ps(p, _mm256_set1_epi32(7));
            (by1(p, 1.0), _mm256_cvtss_f32(last))
        }
    }
    #[inline(always)] unsafe fn moved_up(v: __m256, first: f32) -> __m256 { unsafe { by1(v, first) } }
    #[inline(always)] unsafe fn neighbours(v: __m256) -> __m256 { unsafe { _mm256_permute_ps::<0b10_11_00_01>(v) } }
    #[inline(always)] unsafe fn next_neighbours(v: __m256) -> __m256 { unsafe { _mm256_permute_ps::<0b01_00_11_10>(v) } }
    #[inline(always)]
    unsafe fn compress(v: __m256, m: __m256, to: *mut f32) {
        unsafe {
            let mut lanes = [0.0f32; 8];
            _mm256_storeu_ps(lanes.as_mut_ptr(), v);
            let mut bits = _mm256_movemask_ps(m) as u32;
            let mut to = to;
            while bits != 0 {
                to.write(lanes[bits.trailing_zeros() as usize]);
                to = to.add(1);
                bits &= bits - 1;
            }
        }
    }

    #[inline(always)]
    unsafe fn expand(old: __m256, m: __m256, from: *const f32) -> __m256 {
        unsafe {
            let mut lanes = [0.0f32; 8];
            _mm256_storeu_ps(lanes.as_mut_ptr(), old);
            let mut bits = _mm256_movemask_ps(m) as u32;
            let mut from = from;
            while bits != 0 {
                lanes[bits.trailing_zeros() as usize] = from.read();
                from = from.add(1);
                bits &= bits - 1;
            }
            _mm256_loadu_ps(lanes.as_ptr())
        }
    }

    #[inline(always)] unsafe fn truncate(a: __m256) -> __m256i { unsafe { _mm256_cvttps_epi32(a) } }
    #[inline(always)] unsafe fn to_f32(a: __m256i) -> __m256 { unsafe { _mm256_cvtepi32_ps(a) } }
    #[inline(always)] unsafe fn from_bits(a: __m256i) -> __m256 { unsafe { _mm256_castsi256_ps(a) } }
    #[inline(always)] unsafe fn to_bits(a: __m256) -> __m256i { unsafe { _mm256_castps_si256(a) } }
    #[inline(always)] unsafe fn splat_i(x: i32) -> __m256i { unsafe { _mm256_set1_epi32(x) } }
    #[inline(always)] unsafe fn add_i(a: __m256i, b: __m256i) -> __m256i { unsafe { _mm256_add_epi32(a, b) } }
    #[inline(always)] unsafe fn sub_i(a: __m256i, b: __m256i) -> __m256i { unsafe { _mm256_sub_epi32(a, b) } }
    #[inline(always)] unsafe fn mul_i(a: __m256i, b: __m256i) -> __m256i { unsafe { _mm256_mullo_epi32(a, b) } }
    #[inline(always)] unsafe fn and_i(a: __m256i, b: __m256i) -> __m256i { unsafe { _mm256_and_si256(a, b) } }
    #[inline(always)] unsafe fn shr_i<const BITS: u32>(a: __m256i) -> __m256i {
        unsafe { _mm256_srl_epi32(a, _mm_cvtsi32_si128(BITS as i32)) }
    }
    #[inline(always)] unsafe fn shr_by(a: __m256i, bits: u32) -> __m256i {
        unsafe { _mm256_srl_epi32(a, _mm_cvtsi32_si128(bits as i32)) }
    }
    #[inline(always)] unsafe fn shift_left(a: __m256i, by: __m256i) -> __m256i { unsafe { _mm256_sllv_epi32(a, by) } }
    #[inline(always)] unsafe fn shift_right(a: __m256i, by: __m256i) -> __m256i { unsafe { _mm256_srlv_epi32(a, by) } }
    #[inline(always)] unsafe fn gather<const SCALE: i32>(base: *const u8, offset: __m256i) -> __m256i {
        unsafe { _mm256_i32gather_epi32::<SCALE>(base.cast(), offset) }
    }
    #[inline(always)] unsafe fn gather_f32(table: *const f32, index: __m256i) -> __m256 {
        unsafe { _mm256_i32gather_ps::<4>(table, index) }
    }
    #[inline(always)]
    unsafe fn gather_words(base: *const u32, index: __m256i) -> (__m256i, __m256i) {
        unsafe {
            let (a, b) = Self::gather_pair(base.cast(), index);
            (_mm256_castps_si256(a), _mm256_castps_si256(b))
        }
    }
    #[inline(always)]
    unsafe fn weighted_bytes<const PAIR: usize>(words: __m256i, weights: __m256i) -> __m256i {
        unsafe {
            let pick = if PAIR == 0 { PICK_LOW } else { PICK_HIGH };
            let pairs = _mm256_shuffle_epi8(words, _mm256_broadcastsi128_si256(_mm_loadu_si128(pick.as_ptr().cast())));
            _mm256_madd_epi16(pairs, weights)
        }
    }
    #[inline(always)]
    unsafe fn gather_pair(base: *const u8, index: __m256i) -> (__m256, __m256) {
        unsafe {
            let low = _mm256_castpd_ps(_mm256_i32gather_pd::<4>(base.cast(), _mm256_castsi256_si128(index)));
            let high = _mm256_castpd_ps(_mm256_i32gather_pd::<4>(base.cast(), _mm256_extracti128_si256::<1>(index)));
            // Within 128-bit halves first (0 1 4 5 | 2 3 6 7), then into order.
            let order = |v: __m256| _mm256_castpd_ps(_mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(v)));
            (order(_mm256_shuffle_ps::<0b10_00_10_00>(low, high)), order(_mm256_shuffle_ps::<0b11_01_11_01>(low, high)))
        }
    }

    #[inline(always)] unsafe fn lt(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(a, b) } }
    #[inline(always)] unsafe fn gt(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(a, b) } }
    #[inline(always)] unsafe fn and_m(a: __m256, b: __m256) -> __m256 { unsafe { _mm256_and_ps(a, b) } }
    #[inline(always)] unsafe fn select(m: __m256, a: __m256, b: __m256) -> __m256 { unsafe { _mm256_blendv_ps(b, a, m) } }
    #[inline(always)] unsafe fn bits(m: __m256) -> u32 { unsafe { _mm256_movemask_ps(m) as u32 } }
    #[inline(always)]
    unsafe fn mask(bits: u32) -> __m256 {
        unsafe {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane))
        }
    }
}
