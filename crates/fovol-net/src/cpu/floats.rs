//! Vectors of f32, for what compilers do not make vectors of by themselves; written once for every instruction set.
//!
//! The first vector is made where the instructions are known to be there ([`Simd::in_vectors`]), and all others come from it: so
//! none is ever used where they are not.

use super::element::{Bf16, Element};
use super::simd::Simd;
use glam::{BVec4A, Mat4, Vec4};
use std::ops::{Add, Div, Mul, Sub};

/// The numbers of the longest vectors.
pub const MOST: usize = 16;

/// The upper half of a word.
const UPPER: u32 = 0xFFFF_0000;
/// Half of the last place of a bf16.
const HALF: u32 = 0x8000;

/// A vector of [`N`](Self::N) numbers, which may also be N / 4 pixels of four.
pub trait Floats:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A truth value for each number.
    type Mask: Copy;
    /// How many numbers it has.
    const N: usize;

    /// The same number everywhere.
    fn splat(self, number: f32) -> Self;
    /// The first numbers of some.
    ///
    /// # Panics
    /// Where there are fewer.
    fn load(self, from: &[f32]) -> Self;
    /// Writes them to the first of `to`.
    ///
    /// # Panics
    /// Where there is less room.
    fn store(self, to: &mut [f32]);
    /// Times one, plus other numbers, rounded once where there is an instruction for it.
    fn times_plus(self, factor: Self, more: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn is_at_least(self, other: Self) -> Self::Mask;
    fn is_below(self, other: Self) -> Self::Mask;
    fn both(self, one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// The numbers where the mask is set, else 0.
    fn keep(self, mask: Self::Mask) -> Self;

    /// The bf16 in the lower and in the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than numbers.
    #[inline(always)]
    fn load_halves(self, words: &[u32]) -> [Self; 2] {
        let mut halves = [[0.0; MOST]; 2];
        for i in 0..Self::N {
            halves[0][i] = f32::from_bits(words[i] << 16);
            halves[1][i] = f32::from_bits(words[i] & UPPER);
        }
        halves.map(|half| self.load(&half))
    }
    /// Writes these and others, rounded, to the lower and the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than numbers.
    #[inline(always)]
    fn store_halves(self, upper: Self, words: &mut [u32]) {
        let mut halves = [[0.0; MOST]; 2];
        self.store(&mut halves[0]);
        upper.store(&mut halves[1]);
        for i in 0..Self::N {
            let [lower, upper] = [halves[0][i], halves[1][i]].map(|half| half.to_bits().wrapping_add(HALF));
            words[i] = lower >> 16 | upper & UPPER;
        }
    }

    /// Writes them as the nearest bf16, ties to even.
    ///
    /// # Panics
    /// Where there is less room.
    #[inline(always)]
    fn store_bf16(self, to: &mut [Bf16]) {
        let mut numbers = [0.0; MOST];
        self.store(&mut numbers);
        for i in 0..Self::N {
            to[i] = Bf16::from_f32(numbers[i]);
        }
    }
    /// The numbers that words are with signs.
    ///
    /// # Panics
    /// Where there are fewer.
    #[inline(always)]
    fn load_integers(self, words: &[u32]) -> Self {
        let mut numbers = [0.0; MOST];
        for i in 0..Self::N {
            numbers[i] = words[i] as i32 as f32;
        }
        self.load(&numbers)
    }
    /// Writes some numbers and others in turn, times factors, rounded, as bytes of which 128 stands for 0; what is beyond -128…127 is
    /// cut off there, and what is beyond ±32767 may become anything.
    ///
    /// # Panics
    /// Where there are fewer than two bytes for a number.
    #[inline(always)]
    fn store_bytes(numbers: [Self; 2], factors: [Self; 2], bytes: &mut [u8]) {
        let mut both = [[0.0; MOST]; 2];
        (numbers[0] * factors[0]).store(&mut both[0]);
        (numbers[1] * factors[1]).store(&mut both[1]);
        for i in 0..Self::N {
            for (part, numbers) in both.iter().enumerate() {
                bytes[2 * i + part] = (numbers[i].round_ties_even().clamp(-128.0, 127.0) + 128.0) as u8;
            }
        }
    }

    /// The bf16 that each number is two of, as words: the lower and the upper ones.
    fn halves(self) -> [Self; 2];
    /// Number i of pixel p of each of four vectors as pixel p of vector i.
    fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4];

    /// Every other pixel of these and others, from the first on.
    fn evens(self, others: Self) -> Self;
    /// The same from the second on.
    fn odds(self, others: Self) -> Self;
    /// The first pixels of these and others in turn.
    fn zip_low(self, others: Self) -> Self;
    /// The last ones.
    fn zip_high(self, others: Self) -> Self;
    /// The fourth number of each pixel, in all four places.
    fn fourths(self) -> Self;
    /// The pixels with the fourth numbers of others.
    fn with_fourths(self, others: Self) -> Self;
}

/// Number i of each of four vectors as vector i.
#[inline(always)]
pub fn transposed([a, b, c, d]: [Vec4; 4]) -> [Vec4; 4] {
    let columns = Mat4::from_cols(a, b, c, d).transpose();
    [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis]
}

/// Four numbers of some from `at` on.
#[inline(always)]
pub fn four(numbers: &[f32], at: usize) -> Vec4 {
    Vec4::from_slice(&numbers[at..at + 4])
}

/// Something to do with vectors. As with [`Work`](super::simd::Work), whatever matters must be `#[inline(always)]`.
pub trait VectorWork {
    /// Does it with vectors like `some`.
    fn run<V: Floats>(self, some: V);
}

impl Simd {
    /// Does `work` with the longest vectors of this set.
    #[inline(always)]
    pub fn in_vectors(self, work: impl VectorWork) {
        #[cfg(target_arch = "x86_64")]
        {
            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]
            unsafe fn avx512(work: impl VectorWork) {
                work.run(x86::Sixteen::zero());
            }

            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx2,fma")]
            unsafe fn avx2(work: impl VectorWork) {
                work.run(x86::Eight::zero());
            }

            match self {
                // SAFETY: instruction sets are only named where the processor has them.
                Self::Avx512 | Self::Amx => return unsafe { avx512(work) },
                // SAFETY: as above.
                Self::Avx2 => return unsafe { avx2(work) },
                Self::Portable => {}
            }
        }
        work.run(Vec4::ZERO);
    }
}

impl Floats for Vec4 {
    type Mask = BVec4A;
    const N: usize = 4;

    #[inline(always)]
    fn splat(self, number: f32) -> Self {
        Self::splat(number)
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> Self {
        Self::from_slice(from)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.write_to_slice(to);
    }
    #[inline(always)]
    fn times_plus(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn is_at_least(self, other: Self) -> BVec4A {
        self.cmpge(other)
    }
    #[inline(always)]
    fn is_below(self, other: Self) -> BVec4A {
        self.cmplt(other)
    }
    #[inline(always)]
    fn both(self, one: BVec4A, other: BVec4A) -> BVec4A {
        one & other
    }
    #[inline(always)]
    fn keep(self, mask: BVec4A) -> Self {
        Self::select(mask, self, Self::ZERO)
    }
    #[inline(always)]
    fn halves(self) -> [Self; 2] {
        let words = self.to_array().map(f32::to_bits);
        [words.map(|word| word << 16), words.map(|word| word & UPPER)]
            .map(|half| Self::from_array(half.map(f32::from_bits)))
    }
    #[inline(always)]
    fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4] {
        transposed(vectors)
    }
    #[inline(always)]
    fn evens(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn odds(self, others: Self) -> Self {
        others
    }
    #[inline(always)]
    fn zip_low(self, _: Self) -> Self {
        self
    }
    #[inline(always)]
    fn zip_high(self, others: Self) -> Self {
        others
    }
    #[inline(always)]
    fn fourths(self) -> Self {
        Self::splat(self.w)
    }
    #[inline(always)]
    fn with_fourths(self, others: Self) -> Self {
        self.with_w(others.w)
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is one instruction on vectors, which are only there where it is; loads and stores check their slices"
)]
mod x86 {
    use super::{Bf16, Floats, HALF, UPPER};
    use bytemuck::cast_slice;
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Sub};

    /// Sixteen numbers of AVX-512.
    #[derive(Debug, Clone, Copy)]
    pub struct Sixteen(__m512);

    /// Eight numbers of AVX2.
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
    impl Floats for Sixteen {
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
        #[inline(always)] fn max(self, other: Self) -> Self { Self(unsafe { _mm512_max_ps(self.0, other.0) }) }
        #[inline(always)] fn min(self, other: Self) -> Self { Self(unsafe { _mm512_min_ps(self.0, other.0) }) }
        #[inline(always)] fn abs(self) -> Self { Self(unsafe { _mm512_abs_ps(self.0) }) }
        #[inline(always)] fn is_at_least(self, other: Self) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self.0, other.0) } }
        #[inline(always)] fn is_below(self, other: Self) -> __mmask16 { unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) } }
        #[inline(always)] fn both(self, one: __mmask16, other: __mmask16) -> __mmask16 { one & other }
        #[inline(always)] fn keep(self, mask: __mmask16) -> Self { Self(unsafe { _mm512_maskz_mov_ps(mask, self.0) }) }
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
                // Where the mask is set the second, else the first.
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
                // An f32 of this size has no fraction, and its lower 16 bits are the whole number with its sign.
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
        #[inline(always)] fn fourths(self) -> Self { Self(unsafe { _mm512_permute_ps::<0xFF>(self.0) }) }
        #[inline(always)] fn with_fourths(self, others: Self) -> Self { Self(unsafe { _mm512_mask_blend_ps(0x8888, self.0, others.0) }) }
    }

    #[rustfmt::skip]
    impl Floats for Eight {
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
        #[inline(always)] fn keep(self, mask: __m256) -> Self { Self(unsafe { _mm256_and_ps(mask, self.0) }) }
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
        #[inline(always)] fn evens(self, others: Self) -> Self { Self(unsafe { _mm256_permute2f128_ps::<0x20>(self.0, others.0) }) }
        #[inline(always)] fn odds(self, others: Self) -> Self { Self(unsafe { _mm256_permute2f128_ps::<0x31>(self.0, others.0) }) }
        #[inline(always)] fn zip_low(self, others: Self) -> Self { self.evens(others) }
        #[inline(always)] fn zip_high(self, others: Self) -> Self { self.odds(others) }
        #[inline(always)] fn fourths(self) -> Self { Self(unsafe { _mm256_permute_ps::<0xFF>(self.0) }) }
        #[inline(always)] fn with_fourths(self, others: Self) -> Self { Self(unsafe { _mm256_blend_ps::<0x88>(self.0, others.0) }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Shuffles;

    impl VectorWork for Shuffles {
        fn run<V: Floats>(self, some: V) {
            let numbers: Vec<f32> = (0..2 * V::N).map(|i| i as f32 - 3.5).collect();
            let (a, b) = (some.load(&numbers), some.load(&numbers[V::N..]));
            let read = |v: V| {
                let mut out = vec![0.0; V::N];
                v.store(&mut out);
                out
            };
            let pixels: Vec<&[f32]> = numbers.chunks_exact(4).collect();
            let count = V::N / 4;
            let every_other =
                |first: usize| pixels[first..].iter().step_by(2).copied().collect::<Vec<_>>().concat();
            assert_eq!(read(a.evens(b)), every_other(0));
            assert_eq!(read(a.odds(b)), every_other(1));
            let zipped: Vec<f32> =
                (0..count).flat_map(|i| [pixels[i], pixels[count + i]]).collect::<Vec<_>>().concat();
            assert_eq!(read(a.zip_low(b)), zipped[..V::N]);
            assert_eq!(read(a.zip_high(b)), zipped[V::N..]);
            let expected = |f: &dyn Fn(usize) -> f32| (0..V::N).map(f).collect::<Vec<_>>();
            assert_eq!(read(a.fourths()), expected(&|i| numbers[i / 4 * 4 + 3]));
            let fourth = |i: usize| if i % 4 == 3 { numbers[V::N + i] } else { numbers[i] };
            assert_eq!(read(a.with_fourths(b)), expected(&fourth));
            assert_eq!(read(a.abs()), expected(&|i| numbers[i].abs()));
            assert_eq!(
                read(a.max(some.splat(0.25)).min(some.splat(1.0))),
                expected(&|i| numbers[i].clamp(0.25, 1.0))
            );
            let words: Vec<u32> = (0..V::N as u32).map(|i| 0x3F81_BE02 + 0x0001_0003 * i).collect();
            let [lower, upper] = some.load_halves(&words);
            assert_eq!(read(lower), expected(&|i| f32::from_bits(words[i] << 16)));
            assert_eq!(read(upper), expected(&|i| f32::from_bits(words[i] & UPPER)));
            let mut stored = vec![0; V::N];
            // Less than half of a last place is nothing, more is one.
            let (more, less) = (some.splat(1.0 + 0.7 / 256.0), some.splat(1.0 + 0.3 / 256.0));
            (lower * more).store_halves(upper * less, &mut stored);
            let rounded = |value: f32| (value.to_bits() + HALF) >> 16;
            for i in 0..V::N {
                let [lower, upper] = [read(lower * more)[i], read(upper * less)[i]].map(rounded);
                assert_eq!(stored[i], lower | upper << 16);
            }
            let four = std::array::from_fn(|v| {
                some.load(&(0..V::N).map(|i| (100 * v + i) as f32).collect::<Vec<_>>())
            });
            for (i, vector) in V::pixels_transposed(four).into_iter().enumerate() {
                assert_eq!(read(vector), expected(&|at| (100 * (at % 4) + at / 4 * 4 + i) as f32));
            }
            let mut halves = vec![Bf16::default(); V::N];
            // Some are half way between two bf16.
            let between: Vec<f32> =
                (0..V::N as u32).map(|i| f32::from_bits(0x3F80_8000 + 0x5000 * i)).collect();
            some.load(&between).store_bf16(&mut halves);
            assert!(halves.iter().zip(&between).all(|(half, &v)| *half == Bf16::from_f32(v)));
            let mut bytes = vec![0; 2 * V::N];
            let wide: Vec<f32> = (0..2 * V::N).map(|i| (i as f32 - 11.25) * 21.5).collect();
            V::store_bytes([some.load(&wide), some.load(&wide[V::N..])], [some.splat(0.5); 2], &mut bytes);
            for (i, byte) in bytes.into_iter().enumerate() {
                let number = 0.5 * wide[i / 2 + i % 2 * V::N];
                assert_eq!(byte, (number.round_ties_even() as i8 as u8) ^ 0x80, "{number}");
            }
            let words: Vec<u32> = (0..V::N as u32).map(|i| (3 * i).wrapping_sub(7)).collect();
            assert_eq!(read(some.load_integers(&words)), expected(&|i| 3.0 * i as f32 - 7.0));
            let is_between = some.both(a.is_at_least(some.splat(-1.5)), a.is_below(some.splat(0.5)));
            let kept = |i: usize| if (-1.5..0.5).contains(&numbers[i]) { numbers[i] } else { 0.0 };
            assert_eq!(read(a.keep(is_between)), expected(&kept));
            assert_eq!(
                read(a * b - a / b + a),
                expected(&|i| {
                    let (a, b) = (numbers[i], numbers[V::N + i]);
                    a * b - a / b + a
                })
            );
        }
    }

    #[test]
    fn every_instruction_set_does_the_same() {
        Simd::available().into_iter().for_each(|simd| simd.in_vectors(Shuffles));
    }
}
