//! Vectors of AVX2 and FMA: eight lanes.

use super::gathers::{self, Sample};
use super::{PICK_HIGH, PICK_LOW, instructions, operators};
use crate::bf16::UPPER_HALF;
use crate::vector::{Arithmetic, Gather, Integers, Lanes, Pixels, SimdI32, Storage};
use bytemuck::cast_slice;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Sub};

/// Eight lanes of f32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2(__m256);

/// Eight lanes of i32.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2I32(__m256i);

/// Eight truth values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2Mask(__m256);

impl Avx2 {
    /// Eight zeros, and the proof for all other vectors.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
    pub(crate) fn zero() -> Self {
        Self(_mm256_setzero_ps())
    }

    instructions! {
        /// Lane i takes lane i − 2; the first two take 1.
        fn moved_up_by_2(self) -> Self {
            let from = _mm256_setr_epi32(0, 0, 0, 1, 2, 3, 4, 5);
            Self(_mm256_blend_ps::<0b0000_0011>(_mm256_permutevar8x32_ps(self.0, from), _mm256_set1_ps(1.0)))
        }
        /// Lane i takes lane i − 4; the first four take 1.
        fn moved_up_by_4(self) -> Self {
            Self(_mm256_blend_ps::<0b0000_1111>(_mm256_permute2f128_ps::<0x00>(self.0, self.0), _mm256_set1_ps(1.0)))
        }
    }
}

operators!(Avx2: Add::add = _mm256_add_ps, Sub::sub = _mm256_sub_ps, Mul::mul = _mm256_mul_ps, Div::div = _mm256_div_ps);
operators!(Avx2I32: Add::add = _mm256_add_epi32, Sub::sub = _mm256_sub_epi32, Mul::mul = _mm256_mullo_epi32, BitAnd::bitand = _mm256_and_si256);
operators!(Avx2Mask: BitAnd::bitand = _mm256_and_ps);

impl Arithmetic for Avx2 {
    type Mask = Avx2Mask;
    const N: usize = 8;

    instructions! {
        fn splat(self, number: f32) -> Self { Self(_mm256_set1_ps(number)) }
        fn load(self, from: &[f32]) -> Self { Self(_mm256_loadu_ps(from[..Self::N].as_ptr())) }
        fn store(self, to: &mut [f32]) { _mm256_storeu_ps(to[..Self::N].as_mut_ptr(), self.0) }
        fn mul_add(self, factor: Self, more: Self) -> Self { Self(_mm256_fmadd_ps(self.0, factor.0, more.0)) }
        fn max(self, other: Self) -> Self { Self(_mm256_max_ps(self.0, other.0)) }
        fn min(self, other: Self) -> Self { Self(_mm256_min_ps(self.0, other.0)) }
        fn abs(self) -> Self { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
        fn sqrt(self) -> Self { Self(_mm256_sqrt_ps(self.0)) }
        fn ceil(self) -> Self { Self(_mm256_ceil_ps(self.0)) }
        fn simd_lt(self, other: Self) -> Avx2Mask { Avx2Mask(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) }
        fn simd_gt(self, other: Self) -> Avx2Mask { Avx2Mask(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)) }
        fn simd_ge(self, other: Self) -> Avx2Mask { Avx2Mask(_mm256_cmp_ps::<_CMP_GE_OQ>(self.0, other.0)) }
        fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self { Self(_mm256_blendv_ps(no.0, yes.0, mask.0)) }
        fn zero_unless(self, mask: Avx2Mask) -> Self { Self(_mm256_and_ps(mask.0, self.0)) }
        fn bits_of(mask: Avx2Mask) -> u32 { _mm256_movemask_ps(mask.0) as u32 }
        fn mask_of(self, bits: u32) -> Avx2Mask {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane);
            Avx2Mask(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane)))
        }
    }
}

impl Lanes for Avx2 {
    instructions! {
        fn iota(self) -> Self { Self(_mm256_setr_ps(0., 1., 2., 3., 4., 5., 6., 7.)) }
        fn sum(self) -> f32 {
            let four = _mm_add_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
        }
        fn products_before(self) -> (Self, f32) {
            let p = self * self.moved_up(1.0);
            let p = p * p.moved_up_by_2();
            let p = p * p.moved_up_by_4();
            let last = _mm256_permutevar8x32_ps(p.0, _mm256_set1_epi32(7));
            (p.moved_up(1.0), _mm256_cvtss_f32(last))
        }
        fn moved_up(self, first: f32) -> Self {
            let from = _mm256_setr_epi32(0, 0, 1, 2, 3, 4, 5, 6);
            Self(_mm256_blend_ps::<0b0000_0001>(_mm256_permutevar8x32_ps(self.0, from), _mm256_set1_ps(first)))
        }
        fn neighbours(self) -> Self { Self(_mm256_permute_ps::<0b10_11_00_01>(self.0)) }
        fn next_neighbours(self) -> Self { Self(_mm256_permute_ps::<0b01_00_11_10>(self.0)) }
    }

    #[inline(always)]
    fn compress(self, mask: Avx2Mask, to: &mut [f32]) {
        let (to, mut lanes) = (&mut to[..Self::N], [0.0; 8]);
        self.store(&mut lanes);
        let (mut bits, mut next) = (Self::bits_of(mask), 0);
        while bits != 0 {
            to[next] = lanes[bits.trailing_zeros() as usize];
            next += 1;
            bits &= bits - 1;
        }
    }
    #[inline(always)]
    fn expand(self, mask: Avx2Mask, from: &[f32]) -> Self {
        let (from, mut lanes) = (&from[..Self::N], [0.0; 8]);
        self.store(&mut lanes);
        let (mut bits, mut next) = (Self::bits_of(mask), 0);
        while bits != 0 {
            lanes[bits.trailing_zeros() as usize] = from[next];
            next += 1;
            bits &= bits - 1;
        }
        self.load(&lanes)
    }
}

impl SimdI32 for Avx2I32 {
    #[inline(always)]
    fn shr<const BITS: u32>(self) -> Self {
        self.shr_by(BITS)
    }

    instructions! {
        fn splat(self, number: i32) -> Self { Self(_mm256_set1_epi32(number)) }
        fn store(self, to: &mut [i32]) { _mm256_storeu_si256(to[..8].as_mut_ptr().cast(), self.0) }
        fn shr_by(self, bits: u32) -> Self { Self(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(bits as i32))) }
        fn shl_lanes(self, by: Self) -> Self { Self(_mm256_sllv_epi32(self.0, by.0)) }
        fn shr_lanes(self, by: Self) -> Self { Self(_mm256_srlv_epi32(self.0, by.0)) }
        fn weighted_bytes<const PAIR: usize>(self, weights: Self) -> Self {
            let pick = if PAIR == 0 { PICK_LOW } else { PICK_HIGH };
            let pick = _mm256_broadcastsi128_si256(_mm_loadu_si128(pick.as_ptr().cast()));
            Self(_mm256_madd_epi16(_mm256_shuffle_epi8(self.0, pick), weights.0))
        }
    }
}

impl Integers for Avx2 {
    type I32 = Avx2I32;

    instructions! {
        fn splat_i32(self, number: i32) -> Avx2I32 { Avx2I32(_mm256_set1_epi32(number)) }
        fn to_i32(self) -> Avx2I32 { Avx2I32(_mm256_cvttps_epi32(self.0)) }
        fn from_i32(integers: Avx2I32) -> Self { Self(_mm256_cvtepi32_ps(integers.0)) }
        fn to_bits(self) -> Avx2I32 { Avx2I32(_mm256_castps_si256(self.0)) }
        fn from_bits(bits: Avx2I32) -> Self { Self(_mm256_castsi256_ps(bits.0)) }
    }
}

/// Numbers of the eight lanes.
///
/// # Safety
/// The processor has AVX2; all lanes are at least 0.
#[inline(always)]
unsafe fn indices(index: Avx2I32) -> [usize; 8] {
    // SAFETY: the caller vouches for the instructions.
    let [a, b, c, d] = unsafe {
        let high = _mm256_extracti128_si256::<1>(index.0);
        let low = _mm256_castsi256_si128(index.0);
        [
            _mm_cvtsi128_si64(low),
            _mm_extract_epi64::<1>(low),
            _mm_cvtsi128_si64(high),
            _mm_extract_epi64::<1>(high),
        ]
    };
    let [first, second] = [|pair: i64| pair as u32 as usize, |pair: i64| (pair as u64 >> 32) as usize];
    [first(a), second(a), first(b), second(b), first(c), second(c), first(d), second(d)]
}

/// Words at eight addresses of any alignment.
///
/// # Safety
/// The processor has AVX2; four bytes can be read at each address.
#[inline(always)]
unsafe fn words(at: [*const i32; 8]) -> Avx2I32 {
    // SAFETY: the caller vouches for instructions and addresses.
    unsafe {
        let four = |i: usize| {
            let two =
                _mm_insert_epi32::<1>(_mm_cvtsi32_si128(at[i].read_unaligned()), at[i + 1].read_unaligned());
            let three = _mm_insert_epi32::<2>(two, at[i + 2].read_unaligned());
            _mm_insert_epi32::<3>(three, at[i + 3].read_unaligned())
        };
        Avx2I32(_mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(0)), four(4)))
    }
}

// Operations ask once how to gather: the branch is always predicted, and a second vector type would double the code.
impl Gather for Avx2 {
    #[inline(always)]
    unsafe fn gather_bytes<const SCALE: i32>(from: &[u8], offset: Avx2I32) -> Avx2I32 {
        // SAFETY: the caller's.
        unsafe {
            if gathers::AVX2.is_hardware() {
                gathered::<SCALE>(from, offset)
            } else {
                loaded::<SCALE>(from, offset)
            }
        }
    }
    // The compiler takes the eight offsets out of their vector once for all four slices, as no branch lies between.
    #[inline(always)]
    unsafe fn gather_bytes_of_4<const SCALE: i32>([a, b, c, d]: [&[u8]; 4], at: Avx2I32) -> [Avx2I32; 4] {
        // SAFETY: the caller's.
        unsafe {
            if gathers::AVX2.is_hardware() {
                let [a, b] = [gathered::<SCALE>(a, at), gathered::<SCALE>(b, at)];
                [a, b, gathered::<SCALE>(c, at), gathered::<SCALE>(d, at)]
            } else {
                let [a, b] = [loaded::<SCALE>(a, at), loaded::<SCALE>(b, at)];
                [a, b, loaded::<SCALE>(c, at), loaded::<SCALE>(d, at)]
            }
        }
    }
    #[inline(always)]
    unsafe fn gather(from: &[f32], index: Avx2I32) -> Self {
        // SAFETY: the caller's; four times as many bytes as numbers lie in `from`.
        Self::from_bits(unsafe { Self::gather_bytes::<4>(cast_slice(from), index) })
    }
    #[inline(always)]
    unsafe fn gather_pairs(from: &[f32], index: Avx2I32) -> [Self; 2] {
        // SAFETY: the caller's.
        unsafe {
            if gathers::AVX2.is_hardware() { gathered_pairs(from, index) } else { loaded_pairs(from, index) }
        }
    }
    #[inline(always)]
    unsafe fn gather_pairs_of_4([a, b, c, d]: [&[f32]; 4], at: Avx2I32) -> [[Self; 2]; 4] {
        // SAFETY: the caller's.
        unsafe {
            if gathers::AVX2.is_hardware() {
                let [a, b] = [gathered_pairs(a, at), gathered_pairs(b, at)];
                [a, b, gathered_pairs(c, at), gathered_pairs(d, at)]
            } else {
                let [a, b] = [loaded_pairs(a, at), loaded_pairs(b, at)];
                [a, b, loaded_pairs(c, at), loaded_pairs(d, at)]
            }
        }
    }
    #[inline(always)]
    unsafe fn load_word_pairs(from: &[u32], index: Avx2I32) -> [Avx2I32; 2] {
        // SAFETY: the caller's.
        let [words, next] = unsafe { Self::gather_pairs(cast_slice(from), index) };
        [words.to_bits(), next.to_bits()]
    }
}

/// [`Gather::gather_bytes`] by a gather instruction.
///
/// # Safety
/// The processor has AVX2; four bytes from each offset, times `SCALE`, lie in `from`.
#[inline(always)]
unsafe fn gathered<const SCALE: i32>(from: &[u8], offset: Avx2I32) -> Avx2I32 {
    debug_assert!(Avx2::are_below(offset, SCALE, from.len().saturating_sub(3)));
    // SAFETY: the caller's.
    Avx2I32(unsafe { _mm256_i32gather_epi32::<SCALE>(from.as_ptr().cast(), offset.0) })
}

/// [`Gather::gather_bytes`] by plain loads.
///
/// # Safety
/// That of [`gathered`].
#[inline(always)]
unsafe fn loaded<const SCALE: i32>(from: &[u8], offset: Avx2I32) -> Avx2I32 {
    debug_assert!(Avx2::are_below(offset, SCALE, from.len().saturating_sub(3)));
    // SAFETY: the caller's.
    unsafe { words(indices(offset).map(|at| from.as_ptr().add(at * SCALE as usize).cast())) }
}

/// [`Gather::gather_pairs`] by gather instructions.
///
/// # Safety
/// The processor has AVX2; the number at each index and its successor lie in `from`.
#[inline(always)]
unsafe fn gathered_pairs(from: &[f32], index: Avx2I32) -> [Avx2; 2] {
    debug_assert!(Avx2::are_below(index, 1, from.len().saturating_sub(1)));
    let base = from.as_ptr().cast();
    // SAFETY: the caller's.
    unsafe {
        let low = _mm256_i32gather_pd::<4>(base, _mm256_castsi256_si128(index.0));
        let high = _mm256_i32gather_pd::<4>(base, _mm256_extracti128_si256::<1>(index.0));
        Avx2(_mm256_castpd_ps(low)).deinterleave2(Avx2(_mm256_castpd_ps(high)))
    }
}

/// [`Gather::gather_pairs`] by plain loads.
///
/// # Safety
/// That of [`gathered_pairs`].
#[inline(always)]
unsafe fn loaded_pairs(from: &[f32], index: Avx2I32) -> [Avx2; 2] {
    debug_assert!(Avx2::are_below(index, 1, from.len().saturating_sub(1)));
    // SAFETY: the caller's; both numbers of each pair lie in `from`.
    unsafe {
        let at = indices(index);
        let pair = |i: usize| from.as_ptr().add(at[i]).cast::<f64>();
        let two = |i: usize| _mm_loadh_pd(_mm_load_sd(pair(i)), pair(i + 1));
        let four = |i: usize| _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(two(i)), two(i + 2));
        let [low, high] = [four(0), four(4)].map(|pairs| Avx2(_mm256_castpd_ps(pairs)));
        low.deinterleave2(high)
    }
}

impl Avx2 {
    /// Chooses how vectors gather.
    #[inline]
    pub(crate) fn choose_gathers() {
        // SAFETY: the process is about to run vectors of this type, so the processor has their instructions.
        gathers::AVX2
            .make(|sample| unsafe { gather::<true>(sample) }, |sample| unsafe { gather::<false>(sample) });
    }
}

/// Gathers all words of `sample` with the processor's gathers (`HARDWARE`) or plain loads; returns a sum that depends on
/// their order.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
pub(super) fn gather<const HARDWARE: bool>(sample: &Sample) -> u32 {
    let from = cast_slice(&sample.words);
    let mut sum = Avx2::zero().to_bits();
    for index in sample.indices.chunks_exact(Avx2::N) {
        // SAFETY: the chunks have eight indices, which are words of the sample.
        let words = unsafe {
            let index = Avx2I32(_mm256_loadu_si256(index.as_ptr().cast()));
            if HARDWARE { gathered::<4>(from, index) } else { loaded::<4>(from, index) }
        };
        sum = sum + words;
    }
    let mut lanes = [0; Avx2::N];
    sum.store(&mut lanes);
    gathers::in_order(&lanes)
}

impl Pixels for Avx2 {
    #[inline(always)]
    fn zip_low(self, others: Self) -> Self {
        self.evens(others)
    }
    #[inline(always)]
    fn zip_high(self, others: Self) -> Self {
        self.odds(others)
    }

    instructions! {
        fn pixels_transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
            let pairs = |a: Self, b: Self| [_mm256_castps_pd(_mm256_unpacklo_ps(a.0, b.0)), _mm256_castps_pd(_mm256_unpackhi_ps(a.0, b.0))];
            let ([ab, ab_high], [cd, cd_high]) = (pairs(a, b), pairs(c, d));
            let [first, second] = [_mm256_unpacklo_pd(ab, cd), _mm256_unpackhi_pd(ab, cd)];
            let [third, fourth] = [_mm256_unpacklo_pd(ab_high, cd_high), _mm256_unpackhi_pd(ab_high, cd_high)];
            [Self(_mm256_castpd_ps(first)), Self(_mm256_castpd_ps(second)), Self(_mm256_castpd_ps(third)), Self(_mm256_castpd_ps(fourth))]
        }
        fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
            let first = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
            let one = |n: i32, gathered: __m256| {
                let order = _mm256_add_epi32(first, _mm256_set1_epi32(n));
                Self(_mm256_permutevar8x32_ps(gathered, order))
            };
            // Elements 0, 3 and 6 of one vector, 1, 4 and 7 of another, 2 and 5 of the third.
            let of = |zero: Self, one: Self, two: Self| _mm256_blend_ps::<0b0010_0100>(_mm256_blend_ps::<0b1001_0010>(zero.0, one.0), two.0);
            [one(0, of(a, b, c)), one(1, of(c, a, b)), one(2, of(b, c, a))]
        }
        fn repeat3(self) -> [Self; 3] {
            let orders = [
                _mm256_setr_epi32(0, 0, 0, 1, 1, 1, 2, 2),
                _mm256_setr_epi32(2, 3, 3, 3, 4, 4, 4, 5),
                _mm256_setr_epi32(5, 5, 6, 6, 6, 7, 7, 7),
            ];
            [Self(_mm256_permutevar8x32_ps(self.0, orders[0])), Self(_mm256_permutevar8x32_ps(self.0, orders[1])), Self(_mm256_permutevar8x32_ps(self.0, orders[2]))]
        }
        fn deinterleave2(self, others: Self) -> [Self; 2] {
            const ORDER: i32 = 0b11_01_10_00;
            let (evens, odds) = (_mm256_shuffle_ps::<0b10_00_10_00>(self.0, others.0), _mm256_shuffle_ps::<0b11_01_11_01>(self.0, others.0));
            let (evens, odds) = (_mm256_permute4x64_pd::<ORDER>(_mm256_castps_pd(evens)), _mm256_permute4x64_pd::<ORDER>(_mm256_castps_pd(odds)));
            [Self(_mm256_castpd_ps(evens)), Self(_mm256_castpd_ps(odds))]
        }
        fn evens(self, others: Self) -> Self { Self(_mm256_permute2f128_ps::<0x20>(self.0, others.0)) }
        fn odds(self, others: Self) -> Self { Self(_mm256_permute2f128_ps::<0x31>(self.0, others.0)) }
        fn with_zeros(self) -> Self {
            let order = _mm256_setr_epi32(0, 1, 2, 0, 3, 4, 5, 0);
            Self(_mm256_blend_ps::<0x88>(_mm256_permutevar8x32_ps(self.0, order), _mm256_setzero_ps()))
        }
        fn without_fourths(self) -> Self {
            let order = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 0, 0);
            Self(_mm256_permutevar8x32_ps(self.0, order))
        }
        fn fourths(self) -> Self { Self(_mm256_permute_ps::<0xFF>(self.0)) }
        fn with_fourths(self, others: Self) -> Self { Self(_mm256_blend_ps::<0x88>(self.0, others.0)) }
    }
}

impl Storage for Avx2 {
    #[inline(always)]
    fn load_halves(self, words: &[u32]) -> [Self; 2] {
        self.load(cast_slice(&words[..Self::N])).halves()
    }

    instructions! {
        fn halves(self) -> [Self; 2] {
            let words = _mm256_castps_si256(self.0);
            let upper = _mm256_and_si256(words, _mm256_set1_epi32(UPPER_HALF as i32));
            [Self(_mm256_castsi256_ps(_mm256_slli_epi32::<16>(words))), Self(_mm256_castsi256_ps(upper))]
        }
    }
}
