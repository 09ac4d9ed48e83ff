#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the safety comment of the impl speaks for all its one-instruction methods"
)]

use super::{Lanes, PICK_HIGH, PICK_LOW};
use std::arch::x86_64::*;

/// 16 lanes of AVX-512 (F, BW, DQ, VL).
#[derive(Debug, Clone, Copy)]
pub struct Avx512;

/// Lane i takes lane i − `BY`; where there is none, 1.
#[inline(always)]
unsafe fn shifted<const BY: i32>(v: __m512) -> __m512 {
    // SAFETY: the caller runs where AVX-512 is available.
    unsafe {
        let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
        let from = _mm512_sub_epi32(lanes, _mm512_set1_epi32(BY));
        _mm512_mask_permutexvar_ps(_mm512_set1_ps(1.0), (0xFFFFu32 << BY) as u16, from, v)
    }
}

/// The 64-bit words at `base` + 4·index for eight indices.
#[inline(always)]
unsafe fn eight(base: *const u32, at: &[i32]) -> __m512i {
    // SAFETY: the caller runs where AVX-512 is available, and the words are readable.
    unsafe {
        let a = _mm256_set_m128i(two(base, at[2], at[3]), two(base, at[0], at[1]));
        let b = _mm256_set_m128i(two(base, at[6], at[7]), two(base, at[4], at[5]));
        _mm512_inserti64x4::<1>(_mm512_castsi256_si512(a), b)
    }
}

/// The 64-bit words at `base` + 4·index for two indices.
#[inline(always)]
unsafe fn two(base: *const u32, first: i32, second: i32) -> __m128i {
    // SAFETY: as `eight`.
    unsafe {
        let low = _mm_loadl_epi64(base.offset(first as isize).cast());
        let both = _mm_loadh_pd(_mm_castsi128_pd(low), base.offset(second as isize).cast());
        _mm_castpd_si128(both)
    }
}

/// Whether this processor has it.
pub fn available() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("fma")
}

// SAFETY: every method only wraps instructions of AVX-512 F/BW/DQ/VL, which the trait's contract requires.
#[rustfmt::skip]
unsafe impl Lanes for Avx512 {
    const N: usize = 16;
    type F = __m512;
    type I = __m512i;
    type M = __mmask16;

    #[inline(always)] unsafe fn splat(x: f32) -> __m512 { unsafe { _mm512_set1_ps(x) } }
    #[inline(always)] unsafe fn load(from: *const f32) -> __m512 { unsafe { _mm512_loadu_ps(from) } }
    #[inline(always)] unsafe fn store(v: __m512, to: *mut f32) { unsafe { _mm512_storeu_ps(to, v) } }
    #[inline(always)] unsafe fn add(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_add_ps(a, b) } }
    #[inline(always)] unsafe fn sub(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_sub_ps(a, b) } }
    #[inline(always)] unsafe fn mul(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_mul_ps(a, b) } }
    #[inline(always)] unsafe fn div(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_div_ps(a, b) } }
    #[inline(always)] unsafe fn fma(a: __m512, b: __m512, c: __m512) -> __m512 { unsafe { _mm512_fmadd_ps(a, b, c) } }
    #[inline(always)] unsafe fn min(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_min_ps(a, b) } }
    #[inline(always)] unsafe fn max(a: __m512, b: __m512) -> __m512 { unsafe { _mm512_max_ps(a, b) } }
    #[inline(always)] unsafe fn sqrt(a: __m512) -> __m512 { unsafe { _mm512_sqrt_ps(a) } }
    #[inline(always)] unsafe fn ceil(a: __m512) -> __m512 { unsafe { _mm512_roundscale_ps::<0x0A>(a) } }
    #[inline(always)] unsafe fn abs(a: __m512) -> __m512 { unsafe { _mm512_abs_ps(a) } }
    #[inline(always)] unsafe fn iota() -> __m512 {
        unsafe { _mm512_setr_ps(0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.) }
    }
    #[inline(always)] unsafe fn sum(a: __m512) -> f32 { unsafe { _mm512_reduce_add_ps(a) } }
    #[inline(always)]
    unsafe fn products_before(a: __m512) -> (__m512, f32) {
        unsafe {
            let p = _mm512_mul_ps(a, shifted::<1>(a));
            let p = _mm512_mul_ps(p, shifted::<2>(p));
            let p = _mm512_mul_ps(p, shifted::<4>(p));
            let p = _mm512_mul_ps(p, shifted::<8>(p));
            let last = _mm512_permutexvar_ps(_mm512_set1_epi32(15), p);
            (shifted::<1>(p), _mm512_cvtss_f32(last))
        }
    }
    #[inline(always)]
    unsafe fn moved_up(v: __m512, first: f32) -> __m512 {
        unsafe {
            let from = _mm512_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14);
            _mm512_mask_permutexvar_ps(_mm512_set1_ps(first), 0xFFFE, from, v)
        }
    }
    #[inline(always)] unsafe fn neighbours(v: __m512) -> __m512 { unsafe { _mm512_permute_ps::<0b10_11_00_01>(v) } }
    #[inline(always)] unsafe fn next_neighbours(v: __m512) -> __m512 { unsafe { _mm512_permute_ps::<0b01_00_11_10>(v) } }
    #[inline(always)]
    unsafe fn compress(v: __m512, m: __mmask16, to: *mut f32) {
        // In a register first: compressing stores are slow on some processors.
        unsafe { _mm512_storeu_ps(to, _mm512_maskz_compress_ps(m, v)) }
    }

    #[inline(always)]
    unsafe fn expand(old: __m512, m: __mmask16, from: *const f32) -> __m512 {
        unsafe { _mm512_mask_expand_ps(old, m, _mm512_loadu_ps(from)) }
    }

    #[inline(always)] unsafe fn truncate(a: __m512) -> __m512i { unsafe { _mm512_cvttps_epi32(a) } }
    #[inline(always)] unsafe fn to_f32(a: __m512i) -> __m512 { unsafe { _mm512_cvtepi32_ps(a) } }
    #[inline(always)] unsafe fn from_bits(a: __m512i) -> __m512 { unsafe { _mm512_castsi512_ps(a) } }
    #[inline(always)] unsafe fn to_bits(a: __m512) -> __m512i { unsafe { _mm512_castps_si512(a) } }
    #[inline(always)] unsafe fn splat_i(x: i32) -> __m512i { unsafe { _mm512_set1_epi32(x) } }
    #[inline(always)] unsafe fn add_i(a: __m512i, b: __m512i) -> __m512i { unsafe { _mm512_add_epi32(a, b) } }
    #[inline(always)] unsafe fn sub_i(a: __m512i, b: __m512i) -> __m512i { unsafe { _mm512_sub_epi32(a, b) } }
    #[inline(always)] unsafe fn mul_i(a: __m512i, b: __m512i) -> __m512i { unsafe { _mm512_mullo_epi32(a, b) } }
    #[inline(always)] unsafe fn and_i(a: __m512i, b: __m512i) -> __m512i { unsafe { _mm512_and_si512(a, b) } }
    #[inline(always)] unsafe fn shr_i<const BITS: u32>(a: __m512i) -> __m512i { unsafe { _mm512_srli_epi32::<BITS>(a) } }
    #[inline(always)] unsafe fn shr_by(a: __m512i, bits: u32) -> __m512i {
        unsafe { _mm512_srl_epi32(a, _mm_cvtsi32_si128(bits as i32)) }
    }
    #[inline(always)] unsafe fn shift_left(a: __m512i, by: __m512i) -> __m512i { unsafe { _mm512_sllv_epi32(a, by) } }
    #[inline(always)] unsafe fn shift_right(a: __m512i, by: __m512i) -> __m512i { unsafe { _mm512_srlv_epi32(a, by) } }
    #[inline(always)] unsafe fn gather<const SCALE: i32>(base: *const u8, offset: __m512i) -> __m512i {
        unsafe { _mm512_i32gather_epi32::<SCALE>(offset, base.cast()) }
    }
    #[inline(always)] unsafe fn gather_f32(table: *const f32, index: __m512i) -> __m512 {
        unsafe { _mm512_i32gather_ps::<4>(index, table) }
    }
    #[inline(always)]
    unsafe fn gather_words(base: *const u32, index: __m512i) -> (__m512i, __m512i) {
        unsafe {
            // Sixteen plain loads: on processors with microcoded gathers these are faster, and they
            // overlap with what comes before and after.
            let mut at = [0i32; 16];
            _mm512_storeu_si512(at.as_mut_ptr().cast(), index);
            let low = eight(base, &at[..8]);
            let high = eight(base, &at[8..]);
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
            (_mm512_permutex2var_epi32(low, even, high), _mm512_permutex2var_epi32(low, odd, high))
        }
    }
    #[inline(always)]
    unsafe fn weighted_bytes<const PAIR: usize>(words: __m512i, weights: __m512i) -> __m512i {
        unsafe {
            let pick = if PAIR == 0 { PICK_LOW } else { PICK_HIGH };
            let pairs = _mm512_shuffle_epi8(words, _mm512_broadcast_i32x4(_mm_loadu_si128(pick.as_ptr().cast())));
            _mm512_madd_epi16(pairs, weights)
        }
    }
    #[inline(always)]
    unsafe fn gather_pair(base: *const u8, index: __m512i) -> (__m512, __m512) {
        unsafe {
            let low = _mm512_castpd_ps(_mm512_i32gather_pd::<4>(_mm512_castsi512_si256(index), base.cast()));
            let high = _mm512_castpd_ps(_mm512_i32gather_pd::<4>(_mm512_extracti64x4_epi64::<1>(index), base.cast()));
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
            (_mm512_permutex2var_ps(low, even, high), _mm512_permutex2var_ps(low, odd, high))
        }
    }

    #[inline(always)] unsafe fn lt(a: __m512, b: __m512) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b) } }
    #[inline(always)] unsafe fn gt(a: __m512, b: __m512) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a, b) } }
    #[inline(always)] unsafe fn and_m(a: __mmask16, b: __mmask16) -> __mmask16 { a & b }
    #[inline(always)] unsafe fn select(m: __mmask16, a: __m512, b: __m512) -> __m512 { unsafe { _mm512_mask_blend_ps(m, b, a) } }
    #[inline(always)] unsafe fn bits(m: __mmask16) -> u32 { u32::from(m) }
    #[inline(always)] unsafe fn mask(bits: u32) -> __mmask16 { bits as u16 }
}
