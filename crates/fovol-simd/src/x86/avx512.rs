//! Vectors of AVX-512 (F, BW, DQ, VL): sixteen lanes.

use super::gathers::{self, Sample};
use super::{PICK_HIGH, PICK_LOW, instructions, operators};
use crate::bf16::{Bf16, HALF_ULP, UPPER_HALF};
use crate::vector::{Arithmetic, Gather, Integers, Lanes, Pixels, SimdI32, Storage};
use bytemuck::cast_slice;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Sub};

/// Sixteen lanes of f32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx512(__m512);

/// Sixteen lanes of i32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx512I32(__m512i);

impl Avx512 {
    /// Sixteen zeros, and the proof for all other vectors.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
    pub(crate) fn zero() -> Self {
        Self(_mm512_setzero_ps())
    }

    instructions! {
        /// Lane i takes lane i − `BY`; where there is none, 1.
        fn shifted<const BY: i32>(self) -> Self {
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            let from = _mm512_sub_epi32(lanes, _mm512_set1_epi32(BY));
            Self(_mm512_mask_permutexvar_ps(_mm512_set1_ps(1.0), (0xFFFFu32 << BY) as u16, from, self.0))
        }
    }
}

operators!(Avx512: Add::add = _mm512_add_ps, Sub::sub = _mm512_sub_ps, Mul::mul = _mm512_mul_ps, Div::div = _mm512_div_ps);
operators!(Avx512I32: Add::add = _mm512_add_epi32, Sub::sub = _mm512_sub_epi32, Mul::mul = _mm512_mullo_epi32, BitAnd::bitand = _mm512_and_si512);

impl Arithmetic for Avx512 {
    type Mask = __mmask16;
    const N: usize = 16;

    instructions! {
        fn splat(self, number: f32) -> Self { Self(_mm512_set1_ps(number)) }
        fn load(self, from: &[f32]) -> Self { Self(_mm512_loadu_ps(from[..Self::N].as_ptr())) }
        fn store(self, to: &mut [f32]) { _mm512_storeu_ps(to[..Self::N].as_mut_ptr(), self.0) }
        fn mul_add(self, factor: Self, more: Self) -> Self { Self(_mm512_fmadd_ps(self.0, factor.0, more.0)) }
        // Approximation and one Newton step, because a division takes ten times as long as such an instruction.
        fn recip(self) -> Self {
            let near = _mm512_rcp14_ps(self.0);
            let missing = _mm512_fnmadd_ps(self.0, near, _mm512_set1_ps(1.0));
            Self(_mm512_fmadd_ps(near, missing, near))
        }
        fn max(self, other: Self) -> Self { Self(_mm512_max_ps(self.0, other.0)) }
        fn min(self, other: Self) -> Self { Self(_mm512_min_ps(self.0, other.0)) }
        fn abs(self) -> Self { Self(_mm512_abs_ps(self.0)) }
        fn sqrt(self) -> Self { Self(_mm512_sqrt_ps(self.0)) }
        fn ceil(self) -> Self { Self(_mm512_roundscale_ps::<0x0A>(self.0)) }
        fn simd_lt(self, other: Self) -> __mmask16 { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
        fn simd_gt(self, other: Self) -> __mmask16 { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0) }
        fn simd_ge(self, other: Self) -> __mmask16 { _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, other.0) }
        fn select(mask: __mmask16, yes: Self, no: Self) -> Self { Self(_mm512_mask_blend_ps(mask, no.0, yes.0)) }
        fn zero_unless(self, mask: __mmask16) -> Self { Self(_mm512_maskz_mov_ps(mask, self.0)) }
    }

    #[inline(always)]
    fn bits_of(mask: __mmask16) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn mask_of(self, bits: u32) -> __mmask16 {
        bits as u16
    }
}

impl Lanes for Avx512 {
    instructions! {
        fn iota(self) -> Self { Self(_mm512_setr_ps(0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.)) }
        fn sum(self) -> f32 { _mm512_reduce_add_ps(self.0) }
        fn products_before(self) -> (Self, f32) {
            let p = self * self.shifted::<1>();
            let p = p * p.shifted::<2>();
            let p = p * p.shifted::<4>();
            let p = p * p.shifted::<8>();
            let last = _mm512_permutexvar_ps(_mm512_set1_epi32(15), p.0);
            (p.shifted::<1>(), _mm512_cvtss_f32(last))
        }
        fn moved_up(self, first: f32) -> Self {
            let from = _mm512_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14);
            Self(_mm512_mask_permutexvar_ps(_mm512_set1_ps(first), 0xFFFE, from, self.0))
        }
        fn neighbours(self) -> Self { Self(_mm512_permute_ps::<0b10_11_00_01>(self.0)) }
        fn next_neighbours(self) -> Self { Self(_mm512_permute_ps::<0b01_00_11_10>(self.0)) }
        // In a register first: compressing stores are slow on some processors.
        fn compress(self, mask: __mmask16, to: &mut [f32]) { _mm512_storeu_ps(to[..Self::N].as_mut_ptr(), _mm512_maskz_compress_ps(mask, self.0)) }
        fn expand(self, mask: __mmask16, from: &[f32]) -> Self { Self(_mm512_mask_expand_ps(self.0, mask, self.load(from).0)) }
    }
}

impl SimdI32 for Avx512I32 {
    instructions! {
        fn splat(self, number: i32) -> Self { Self(_mm512_set1_epi32(number)) }
        fn store(self, to: &mut [i32]) { _mm512_storeu_si512(to[..16].as_mut_ptr().cast(), self.0) }
        fn shr<const BITS: u32>(self) -> Self { Self(_mm512_srli_epi32::<BITS>(self.0)) }
        fn shr_by(self, bits: u32) -> Self { Self(_mm512_srl_epi32(self.0, _mm_cvtsi32_si128(bits as i32))) }
        fn shl_lanes(self, by: Self) -> Self { Self(_mm512_sllv_epi32(self.0, by.0)) }
        fn shr_lanes(self, by: Self) -> Self { Self(_mm512_srlv_epi32(self.0, by.0)) }
        fn weighted_bytes<const PAIR: usize>(self, weights: Self) -> Self {
            let pick = if PAIR == 0 { PICK_LOW } else { PICK_HIGH };
            let pick = _mm512_broadcast_i32x4(_mm_loadu_si128(pick.as_ptr().cast()));
            Self(_mm512_madd_epi16(_mm512_shuffle_epi8(self.0, pick), weights.0))
        }
    }
}

impl Integers for Avx512 {
    type I32 = Avx512I32;

    instructions! {
        fn splat_i32(self, number: i32) -> Avx512I32 { Avx512I32(_mm512_set1_epi32(number)) }
        fn to_i32(self) -> Avx512I32 { Avx512I32(_mm512_cvttps_epi32(self.0)) }
        fn from_i32(integers: Avx512I32) -> Self { Self(_mm512_cvtepi32_ps(integers.0)) }
        fn to_bits(self) -> Avx512I32 { Avx512I32(_mm512_castps_si512(self.0)) }
        fn from_bits(bits: Avx512I32) -> Self { Self(_mm512_castsi512_ps(bits.0)) }
    }
}

impl Gather for Avx512 {
    #[inline(always)]
    unsafe fn gather_bytes<const SCALE: i32>(from: &[u8], offset: Avx512I32) -> Avx512I32 {
        debug_assert!(Self::are_below(offset, SCALE, from.len().saturating_sub(3)));
        // SAFETY: the vectors prove the instructions, the caller vouches for the addresses.
        Avx512I32(unsafe { _mm512_i32gather_epi32::<SCALE>(offset.0, from.as_ptr().cast()) })
    }
    #[inline(always)]
    unsafe fn gather(from: &[f32], index: Avx512I32) -> Self {
        debug_assert!(Self::are_below(index, 1, from.len()));
        // SAFETY: see above.
        Self(unsafe { _mm512_i32gather_ps::<4>(index.0, from.as_ptr()) })
    }
    #[inline(always)]
    unsafe fn gather_pairs(from: &[f32], index: Avx512I32) -> [Self; 2] {
        debug_assert!(Self::are_below(index, 1, from.len().saturating_sub(1)));
        // SAFETY: see above.
        unsafe {
            let base = from.as_ptr().cast();
            let low = _mm512_castpd_ps(_mm512_i32gather_pd::<4>(_mm512_castsi512_si256(index.0), base));
            let high =
                _mm512_castpd_ps(_mm512_i32gather_pd::<4>(_mm512_extracti64x4_epi64::<1>(index.0), base));
            Self(low).deinterleave2(Self(high))
        }
    }
    #[inline(always)]
    unsafe fn load_word_pairs(from: &[u32], index: Avx512I32) -> [Avx512I32; 2] {
        // SAFETY: the caller's.
        unsafe { if gathers::AVX512.is_hardware() { gathered(from, index) } else { loaded(from, index) } }
    }
}

impl Avx512 {
    /// Chooses how pairs of words are loaded.
    #[inline]
    pub(crate) fn choose_gathers() {
        // SAFETY: the process is about to run vectors of this type, so the processor has their instructions.
        gathers::AVX512
            .make(|sample| unsafe { gather::<true>(sample) }, |sample| unsafe { gather::<false>(sample) });
    }
}

/// Gathers all pairs of `sample` with the processor's gathers (`HARDWARE`) or plain loads; returns a sum that depends on
/// their order.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn gather<const HARDWARE: bool>(sample: &Sample) -> u32 {
    let mut sum = [Avx512::zero().to_bits(); 2];
    for index in sample.indices.chunks_exact(Avx512::N) {
        // SAFETY: the chunks have sixteen indices; they and their successors are words of the sample.
        let [words, next] = unsafe {
            let index = Avx512I32(_mm512_loadu_si512(index.as_ptr().cast()));
            if HARDWARE { gathered(&sample.words, index) } else { loaded(&sample.words, index) }
        };
        sum = [sum[0] + words, sum[1] + next];
    }
    let mut lanes = [0; 2 * Avx512::N];
    sum[0].store(&mut lanes[..Avx512::N]);
    sum[1].store(&mut lanes[Avx512::N..]);
    gathers::in_order(&lanes)
}

/// Gathers words and their successors.
///
/// # Safety
/// The processor must have AVX-512, and the pairs must lie in `from`.
#[inline(always)]
unsafe fn gathered(from: &[u32], index: Avx512I32) -> [Avx512I32; 2] {
    // SAFETY: the caller's.
    let [words, next] = unsafe { Avx512::gather_pairs(cast_slice(from), index) };
    [words.to_bits(), next.to_bits()]
}

/// Loads words and their successors one by one.
///
/// # Safety
/// That of [`gathered`].
#[inline(always)]
unsafe fn loaded(from: &[u32], index: Avx512I32) -> [Avx512I32; 2] {
    debug_assert!(Avx512::are_below(index, 1, from.len().saturating_sub(1)));
    let mut at = [0; 16];
    index.store(&mut at);
    // SAFETY: the caller's. Sixteen plain loads overlap with what comes before and after.
    unsafe {
        let (low, high) = (Avx512I32(eight(from, &at[..8])), Avx512I32(eight(from, &at[8..])));
        let [words, next] = Avx512::from_bits(low).deinterleave2(Avx512::from_bits(high));
        [words.to_bits(), next.to_bits()]
    }
}

/// Loads pairs of words at eight indices.
///
/// # Safety
/// The processor must have AVX-512, and the pairs must lie in `from`.
#[inline(always)]
unsafe fn eight(from: &[u32], at: &[i32]) -> __m512i {
    // SAFETY: the caller's.
    unsafe {
        let low = _mm256_set_m128i(two(from, at[2], at[3]), two(from, at[0], at[1]));
        let high = _mm256_set_m128i(two(from, at[6], at[7]), two(from, at[4], at[5]));
        _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
    }
}

/// Loads pairs of words at two indices.
///
/// # Safety
/// That of [`eight`].
#[inline(always)]
unsafe fn two(from: &[u32], first: i32, second: i32) -> __m128i {
    // SAFETY: the caller's.
    unsafe {
        let low = _mm_loadl_epi64(from.as_ptr().offset(first as isize).cast());
        let both = _mm_loadh_pd(_mm_castsi128_pd(low), from.as_ptr().offset(second as isize).cast());
        _mm_castpd_si128(both)
    }
}

impl Pixels for Avx512 {
    instructions! {
        fn pixels_transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
            let pairs = |a: Self, b: Self| [_mm512_castps_pd(_mm512_unpacklo_ps(a.0, b.0)), _mm512_castps_pd(_mm512_unpackhi_ps(a.0, b.0))];
            let ([ab, ab_high], [cd, cd_high]) = (pairs(a, b), pairs(c, d));
            let [first, second] = [_mm512_unpacklo_pd(ab, cd), _mm512_unpackhi_pd(ab, cd)];
            let [third, fourth] = [_mm512_unpacklo_pd(ab_high, cd_high), _mm512_unpackhi_pd(ab_high, cd_high)];
            [Self(_mm512_castpd_ps(first)), Self(_mm512_castpd_ps(second)), Self(_mm512_castpd_ps(third)), Self(_mm512_castpd_ps(fourth))]
        }
        // Elements of one residue class mod 3 are first blended into one vector, then permuted into order.
        fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
            const EVERY_THIRD: [u16; 3] = [0b1001_0010_0100_1001, 0b0010_0100_1001_0010, 0b0100_1001_0010_0100];
            let first = _mm512_setr_epi32(0, 3, 6, 9, 12, 15, 2, 5, 8, 11, 14, 1, 4, 7, 10, 13);
            let gathered = |n: usize| {
                // Element i of the second vector is number 16 + i, and 16 = 3·5 + 1.
                let both = _mm512_mask_blend_ps(EVERY_THIRD[(n + 2) % 3], a.0, b.0);
                _mm512_mask_blend_ps(EVERY_THIRD[(n + 1) % 3], both, c.0)
            };
            let one = |n: usize| {
                let order = _mm512_add_epi32(first, _mm512_set1_epi32(n as i32));
                Self(_mm512_permutexvar_ps(order, gathered(n)))
            };
            [one(0), one(1), one(2)]
        }
        fn repeat3(self) -> [Self; 3] {
            let orders = [
                _mm512_setr_epi32(0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5),
                _mm512_setr_epi32(5, 5, 6, 6, 6, 7, 7, 7, 8, 8, 8, 9, 9, 9, 10, 10),
                _mm512_setr_epi32(10, 11, 11, 11, 12, 12, 12, 13, 13, 13, 14, 14, 14, 15, 15, 15),
            ];
            [Self(_mm512_permutexvar_ps(orders[0], self.0)), Self(_mm512_permutexvar_ps(orders[1], self.0)), Self(_mm512_permutexvar_ps(orders[2], self.0))]
        }
        fn deinterleave2(self, others: Self) -> [Self; 2] {
            let evens = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odds = _mm512_add_epi32(evens, _mm512_set1_epi32(1));
            [Self(_mm512_permutex2var_ps(self.0, evens, others.0)), Self(_mm512_permutex2var_ps(self.0, odds, others.0))]
        }
        fn evens(self, others: Self) -> Self { Self(_mm512_shuffle_f32x4::<0b10_00_10_00>(self.0, others.0)) }
        fn odds(self, others: Self) -> Self { Self(_mm512_shuffle_f32x4::<0b11_01_11_01>(self.0, others.0)) }
        fn zip_low(self, others: Self) -> Self {
            let order = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
            Self(_mm512_permutex2var_ps(self.0, order, others.0))
        }
        fn zip_high(self, others: Self) -> Self {
            let order = _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
            Self(_mm512_permutex2var_ps(self.0, order, others.0))
        }
        fn with_zeros(self) -> Self {
            let order = _mm512_setr_epi32(0, 1, 2, 0, 3, 4, 5, 0, 6, 7, 8, 0, 9, 10, 11, 0);
            Self(_mm512_maskz_permutexvar_ps(0x7777, order, self.0))
        }
        fn without_fourths(self) -> Self {
            let order = _mm512_setr_epi32(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 0, 0, 0, 0);
            Self(_mm512_permutexvar_ps(order, self.0))
        }
        fn fourths(self) -> Self { Self(_mm512_permute_ps::<0xFF>(self.0)) }
        fn with_fourths(self, others: Self) -> Self { Self(_mm512_mask_blend_ps(0x8888, self.0, others.0)) }
    }
}

impl Storage for Avx512 {
    instructions! {
        fn load_halves(self, words: &[u32]) -> [Self; 2] {
            let words = &words[..Self::N];
            let words = _mm512_loadu_si512(words.as_ptr().cast());
            let upper = _mm512_and_si512(words, _mm512_set1_epi32(UPPER_HALF as i32));
            [Self(_mm512_castsi512_ps(_mm512_slli_epi32::<16>(words))), Self(_mm512_castsi512_ps(upper))]
        }
        fn store_halves(self, upper: Self, words: &mut [u32]) {
            let words = &mut words[..Self::N];
            let half = _mm512_set1_epi32(HALF_ULP as i32);
            let lower = _mm512_srli_epi32::<16>(_mm512_add_epi32(_mm512_castps_si512(self.0), half));
            let upper = _mm512_add_epi32(_mm512_castps_si512(upper.0), half);
            // Takes bits of the second vector where the mask is set, else of the first.
            let both = _mm512_ternarylogic_epi32::<0xD8>(lower, upper, _mm512_set1_epi32(UPPER_HALF as i32));
            _mm512_storeu_si512(words.as_mut_ptr().cast(), both);
        }
        fn store_bf16(self, to: &mut [Bf16]) {
            let to = &mut to[..Self::N];
            let bits = _mm512_castps_si512(self.0);
            let odd = _mm512_and_si512(_mm512_srli_epi32::<16>(bits), _mm512_set1_epi32(1));
            let rounded = _mm512_add_epi32(_mm512_add_epi32(bits, _mm512_set1_epi32(0x7FFF)), odd);
            let halves = _mm512_cvtepi32_epi16(_mm512_srli_epi32::<16>(rounded));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), halves);
        }
        fn load_integers(self, words: &[u32]) -> Self {
            let words = &words[..Self::N];
            Self(_mm512_cvtepi32_ps(_mm512_loadu_si512(words.as_ptr().cast())))
        }
        fn store_bytes(numbers: [Self; 2], factors: [Self; 2], bytes: &mut [u8]) {
            let bytes = &mut bytes[..2 * Self::N];
            // An f32 near 1.5·2²³ has no fraction, and its low 16 bits are the signed integer.
            let whole = _mm512_set1_ps(12_582_912.0);
            let sum = |at: usize| _mm512_castps_si512(_mm512_fmadd_ps(numbers[at].0, factors[at].0, whole));
            let [lower, upper] = [sum(0), sum(1)];
            let both = _mm512_mask_blend_epi16(0xAAAA_AAAA, lower, _mm512_slli_epi32::<16>(upper));
            let signed = _mm512_cvtsepi16_epi8(both);
            _mm256_storeu_si256(bytes.as_mut_ptr().cast(), _mm256_xor_si256(signed, _mm256_set1_epi8(-128)));
        }
        fn halves(self) -> [Self; 2] {
            let words = _mm512_castps_si512(self.0);
            let upper = _mm512_and_si512(words, _mm512_set1_epi32(UPPER_HALF as i32));
            [Self(_mm512_castsi512_ps(_mm512_slli_epi32::<16>(words))), Self(_mm512_castsi512_ps(upper))]
        }
    }
}
