//! Vectors for AVX-512 and AVX2.

use super::{Bf16, HALF, SimdF32, UPPER};
use bytemuck::cast_slice;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Sixteen lanes of AVX-512.
#[derive(Debug, Clone, Copy)]
pub struct Sixteen(__m512);

/// Eight lanes of AVX2.
#[derive(Debug, Clone, Copy)]
pub struct Eight(__m256);

impl Sixteen {
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub fn zero() -> Self {
        Self(_mm512_setzero_ps())
    }
}

impl Eight {
    #[inline]
    #[target_feature(enable = "avx2")]
    pub fn zero() -> Self {
        Self(_mm256_setzero_ps())
    }
}

macro_rules! operators {
    ($vector:ident: $($operator:ident::$method:ident = $instruction:ident),*) => {
        $(impl $operator for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(unsafe { $instruction(self.0, other.0) })
            }
        })*
    };
}
operators!(Sixteen: Add::add = _mm512_add_ps, Sub::sub = _mm512_sub_ps, Mul::mul = _mm512_mul_ps, Div::div = _mm512_div_ps);
operators!(Eight: Add::add = _mm256_add_ps, Sub::sub = _mm256_sub_ps, Mul::mul = _mm256_mul_ps, Div::div = _mm256_div_ps);

#[rustfmt::skip]
impl SimdF32 for Sixteen {
    type Mask = __mmask16;
    const N: usize = 16;

    #[inline(always)] fn splat(self, number: f32) -> Self { Self(unsafe { _mm512_set1_ps(number) }) }
    #[inline(always)] fn load(self, from: &[f32]) -> Self {
        let from = &from[..Self::N];
        Self(unsafe { _mm512_loadu_ps(from.as_ptr()) })
    }
    #[inline(always)] fn store(self, to: &mut [f32]) {
        let to = &mut to[..Self::N];
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)] fn times_plus(self, factor: Self, more: Self) -> Self { Self(unsafe { _mm512_fmadd_ps(self.0, factor.0, more.0) }) }
    // Approximation and one Newton step, because a division takes ten times as long as such an instruction.
    #[inline(always)] fn inverse(self) -> Self {
        unsafe {
            let near = _mm512_rcp14_ps(self.0);
            let missing = _mm512_fnmadd_ps(self.0, near, _mm512_set1_ps(1.0));
            Self(_mm512_fmadd_ps(near, missing, near))
        }
    }
    #[inline(always)] fn max(self, other: Self) -> Self { Self(unsafe { _mm512_max_ps(self.0, other.0) }) }
    #[inline(always)] fn min(self, other: Self) -> Self { Self(unsafe { _mm512_min_ps(self.0, other.0) }) }
    #[inline(always)] fn abs(self) -> Self { Self(unsafe { _mm512_abs_ps(self.0) }) }
    #[inline(always)] fn is_at_least(self, other: Self) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, other.0) } }
    #[inline(always)] fn is_below(self, other: Self) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) } }
    #[inline(always)] fn both(self, one: __mmask16, other: __mmask16) -> __mmask16 { one & other }
    #[inline(always)] fn zero_unless(self, mask: __mmask16) -> Self { Self(unsafe { _mm512_maskz_mov_ps(mask, self.0) }) }
    #[inline(always)] fn load_halves(self, words: &[u32]) -> [Self; 2] {
        let words = &words[..Self::N];
        unsafe {
            let words = _mm512_loadu_si512(words.as_ptr().cast());
            let upper = _mm512_and_si512(words, _mm512_set1_epi32(UPPER as i32));
            [_mm512_slli_epi32::<16>(words), upper].map(|half| Self(_mm512_castsi512_ps(half)))
        }
    }
    #[inline(always)] fn store_halves(self, upper: Self, words: &mut [u32]) {
        let words = &mut words[..Self::N];
        unsafe {
            let half = _mm512_set1_epi32(HALF as i32);
            let lower = _mm512_srli_epi32::<16>(_mm512_add_epi32(_mm512_castps_si512(self.0), half));
            let upper = _mm512_add_epi32(_mm512_castps_si512(upper.0), half);
            // Takes bits of the second vector where the mask is set, else of the first.
            let both = _mm512_ternarylogic_epi32::<0xD8>(lower, upper, _mm512_set1_epi32(UPPER as i32));
            _mm512_storeu_si512(words.as_mut_ptr().cast(), both);
        }
    }
    #[inline(always)] fn store_bf16(self, to: &mut [Bf16]) {
        let to = &mut to[..Self::N];
        unsafe {
            let bits = _mm512_castps_si512(self.0);
            let odd = _mm512_and_si512(_mm512_srli_epi32::<16>(bits), _mm512_set1_epi32(1));
            let rounded = _mm512_add_epi32(_mm512_add_epi32(bits, _mm512_set1_epi32(0x7FFF)), odd);
            let halves = _mm512_cvtepi32_epi16(_mm512_srli_epi32::<16>(rounded));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), halves);
        }
    }
    #[inline(always)] fn load_integers(self, words: &[u32]) -> Self {
        let words = &words[..Self::N];
        Self(unsafe { _mm512_cvtepi32_ps(_mm512_loadu_si512(words.as_ptr().cast())) })
    }
    #[inline(always)] fn store_bytes(numbers: [Self; 2], factors: [Self; 2], bytes: &mut [u8]) {
        let bytes = &mut bytes[..2 * Self::N];
        unsafe {
            // An f32 near 1.5·2²³ has no fraction, and its low 16 bits are the signed integer.
            let whole = _mm512_set1_ps(12_582_912.0);
            let sum = |at: usize| _mm512_castps_si512(_mm512_fmadd_ps(numbers[at].0, factors[at].0, whole));
            let [lower, upper] = [sum(0), sum(1)];
            let both = _mm512_mask_blend_epi16(0xAAAA_AAAA, lower, _mm512_slli_epi32::<16>(upper));
            let signed = _mm512_cvtsepi16_epi8(both);
            _mm256_storeu_si256(bytes.as_mut_ptr().cast(), _mm256_xor_si256(signed, _mm256_set1_epi8(-128)));
        }
    }
    #[inline(always)] fn halves(self) -> [Self; 2] {
        unsafe {
            let words = _mm512_castps_si512(self.0);
            let upper = _mm512_and_si512(words, _mm512_set1_epi32(UPPER as i32));
            [_mm512_slli_epi32::<16>(words), upper].map(|half| Self(_mm512_castsi512_ps(half)))
        }
    }
    #[inline(always)] fn pixels_transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        unsafe {
            let pairs = |a: Self, b: Self| [_mm512_unpacklo_ps(a.0, b.0), _mm512_unpackhi_ps(a.0, b.0)].map(|v| _mm512_castps_pd(v));
            let ([ab, ab_high], [cd, cd_high]) = (pairs(a, b), pairs(c, d));
            let [first, second] = [_mm512_unpacklo_pd(ab, cd), _mm512_unpackhi_pd(ab, cd)];
            let [third, fourth] = [_mm512_unpacklo_pd(ab_high, cd_high), _mm512_unpackhi_pd(ab_high, cd_high)];
            [first, second, third, fourth].map(|v| Self(_mm512_castpd_ps(v)))
        }
    }
    // Elements of one residue class mod 3 are first blended into one vector, then permuted into order.
    #[inline(always)] fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
        const EVERY_THIRD: [u16; 3] = [0b1001_0010_0100_1001, 0b0010_0100_1001_0010, 0b0100_1001_0010_0100];
        unsafe {
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
    }
    #[inline(always)] fn repeat3(self) -> [Self; 3] {
        unsafe {
            let orders = [
                _mm512_setr_epi32(0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5),
                _mm512_setr_epi32(5, 5, 6, 6, 6, 7, 7, 7, 8, 8, 8, 9, 9, 9, 10, 10),
                _mm512_setr_epi32(10, 11, 11, 11, 12, 12, 12, 13, 13, 13, 14, 14, 14, 15, 15, 15),
            ];
            orders.map(|order| Self(_mm512_permutexvar_ps(order, self.0)))
        }
    }
    #[inline(always)] fn deinterleave2(self, others: Self) -> [Self; 2] {
        unsafe {
            let evens = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odds = _mm512_add_epi32(evens, _mm512_set1_epi32(1));
            [evens, odds].map(|order| Self(_mm512_permutex2var_ps(self.0, order, others.0)))
        }
    }
    #[inline(always)] fn evens(self, others: Self) -> Self { Self(unsafe { _mm512_shuffle_f32x4::<0b10_00_10_00>(self.0, others.0) }) }
    #[inline(always)] fn odds(self, others: Self) -> Self { Self(unsafe { _mm512_shuffle_f32x4::<0b11_01_11_01>(self.0, others.0) }) }
    #[inline(always)] fn zip_low(self, others: Self) -> Self {
        let order = unsafe { _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23) };
        Self(unsafe { _mm512_permutex2var_ps(self.0, order, others.0) })
    }
    #[inline(always)] fn zip_high(self, others: Self) -> Self {
        let order = unsafe { _mm512_setr_epi32(8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31) };
        Self(unsafe { _mm512_permutex2var_ps(self.0, order, others.0) })
    }
    #[inline(always)] fn with_zeros(self) -> Self {
        let order = unsafe { _mm512_setr_epi32(0, 1, 2, 0, 3, 4, 5, 0, 6, 7, 8, 0, 9, 10, 11, 0) };
        Self(unsafe { _mm512_maskz_permutexvar_ps(0x7777, order, self.0) })
    }
    #[inline(always)] fn without_fourths(self) -> Self {
        let order = unsafe { _mm512_setr_epi32(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 0, 0, 0, 0) };
        Self(unsafe { _mm512_permutexvar_ps(order, self.0) })
    }
    #[inline(always)] fn fourths(self) -> Self { Self(unsafe { _mm512_permute_ps::<0xFF>(self.0) }) }
    #[inline(always)] fn with_fourths(self, others: Self) -> Self { Self(unsafe { _mm512_mask_blend_ps(0x8888, self.0, others.0) }) }
}

#[rustfmt::skip]
impl SimdF32 for Eight {
    type Mask = __m256;
    const N: usize = 8;

    #[inline(always)] fn splat(self, number: f32) -> Self { Self(unsafe { _mm256_set1_ps(number) }) }
    #[inline(always)] fn load(self, from: &[f32]) -> Self {
        let from = &from[..Self::N];
        Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }
    #[inline(always)] fn store(self, to: &mut [f32]) {
        let to = &mut to[..Self::N];
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)] fn times_plus(self, factor: Self, more: Self) -> Self { Self(unsafe { _mm256_fmadd_ps(self.0, factor.0, more.0) }) }
    #[inline(always)] fn max(self, other: Self) -> Self { Self(unsafe { _mm256_max_ps(self.0, other.0) }) }
    #[inline(always)] fn min(self, other: Self) -> Self { Self(unsafe { _mm256_min_ps(self.0, other.0) }) }
    #[inline(always)] fn abs(self) -> Self { Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) }) }
    #[inline(always)] fn is_at_least(self, other: Self) -> __m256 { unsafe { _mm256_cmp_ps::<_CMP_GE_OQ>(self.0, other.0) } }
    #[inline(always)] fn is_below(self, other: Self) -> __m256 { unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) } }
    #[inline(always)] fn both(self, one: __m256, other: __m256) -> __m256 { unsafe { _mm256_and_ps(one, other) } }
    #[inline(always)] fn zero_unless(self, mask: __m256) -> Self { Self(unsafe { _mm256_and_ps(mask, self.0) }) }
    #[inline(always)] fn halves(self) -> [Self; 2] {
        unsafe {
            let words = _mm256_castps_si256(self.0);
            let upper = _mm256_and_si256(words, _mm256_set1_epi32(UPPER as i32));
            [_mm256_slli_epi32::<16>(words), upper].map(|half| Self(_mm256_castsi256_ps(half)))
        }
    }
    #[inline(always)] fn load_halves(self, words: &[u32]) -> [Self; 2] { self.load(cast_slice(&words[..Self::N])).halves() }
    #[inline(always)] fn pixels_transposed([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        unsafe {
            let pairs = |a: Self, b: Self| [_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0)].map(|v| _mm256_castps_pd(v));
            let ([ab, ab_high], [cd, cd_high]) = (pairs(a, b), pairs(c, d));
            let [first, second] = [_mm256_unpacklo_pd(ab, cd), _mm256_unpackhi_pd(ab, cd)];
            let [third, fourth] = [_mm256_unpacklo_pd(ab_high, cd_high), _mm256_unpackhi_pd(ab_high, cd_high)];
            [first, second, third, fourth].map(|v| Self(_mm256_castpd_ps(v)))
        }
    }
    #[inline(always)] fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
        unsafe {
            let first = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
            let one = |n: i32, gathered: __m256| {
                let order = _mm256_add_epi32(first, _mm256_set1_epi32(n));
                Self(_mm256_permutevar8x32_ps(gathered, order))
            };
            // Elements 0, 3 and 6 of one vector, 1, 4 and 7 of another, 2 and 5 of the third.
            let of = |zero: Self, one: Self, two: Self| _mm256_blend_ps::<0b0010_0100>(_mm256_blend_ps::<0b1001_0010>(zero.0, one.0), two.0);
            [one(0, of(a, b, c)), one(1, of(c, a, b)), one(2, of(b, c, a))]
        }
    }
    #[inline(always)] fn repeat3(self) -> [Self; 3] {
        unsafe {
            let orders = [
                _mm256_setr_epi32(0, 0, 0, 1, 1, 1, 2, 2),
                _mm256_setr_epi32(2, 3, 3, 3, 4, 4, 4, 5),
                _mm256_setr_epi32(5, 5, 6, 6, 6, 7, 7, 7),
            ];
            orders.map(|order| Self(_mm256_permutevar8x32_ps(self.0, order)))
        }
    }
    #[inline(always)] fn deinterleave2(self, others: Self) -> [Self; 2] {
        unsafe {
            let pairs = [_mm256_shuffle_ps::<0b10_00_10_00>(self.0, others.0), _mm256_shuffle_ps::<0b11_01_11_01>(self.0, others.0)];
            pairs.map(|pair| Self(_mm256_castpd_ps(_mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(pair)))))
        }
    }
    #[inline(always)] fn evens(self, others: Self) -> Self { Self(unsafe { _mm256_permute2f128_ps::<0x20>(self.0, others.0) }) }
    #[inline(always)] fn odds(self, others: Self) -> Self { Self(unsafe { _mm256_permute2f128_ps::<0x31>(self.0, others.0) }) }
    #[inline(always)] fn zip_low(self, others: Self) -> Self { self.evens(others) }
    #[inline(always)] fn zip_high(self, others: Self) -> Self { self.odds(others) }
    #[inline(always)] fn with_zeros(self) -> Self {
        let order = unsafe { _mm256_setr_epi32(0, 1, 2, 0, 3, 4, 5, 0) };
        Self(unsafe { _mm256_blend_ps::<0x88>(_mm256_permutevar8x32_ps(self.0, order), _mm256_setzero_ps()) })
    }
    #[inline(always)] fn without_fourths(self) -> Self {
        let order = unsafe { _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 0, 0) };
        Self(unsafe { _mm256_permutevar8x32_ps(self.0, order) })
    }
    #[inline(always)] fn fourths(self) -> Self { Self(unsafe { _mm256_permute_ps::<0xFF>(self.0) }) }
    #[inline(always)] fn with_fourths(self, others: Self) -> Self { Self(unsafe { _mm256_blend_ps::<0x88>(self.0, others.0) }) }
}
