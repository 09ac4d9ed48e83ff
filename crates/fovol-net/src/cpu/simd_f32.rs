//! SIMD vectors of f32, for code that compilers do not vectorise by themselves. It is written once for all
//! instruction sets.
//!
//! The first vector is made where the instructions are known to exist ([`Simd::in_vectors`]), and all others derive
//! from it. A vector can therefore only exist where its instructions do.

use super::element::{Bf16, Element};
use super::simd::Simd;
use glam::{BVec4A, Mat4, Vec4};
use std::ops::{Add, Div, Mul, Sub};

/// Number of lanes of the longest vectors.
pub const MOST: usize = 16;

/// Mask of the upper half of a word.
const UPPER: u32 = 0xFFFF_0000;
/// Half a unit in the last place of a bf16, as bits of an f32.
const HALF: u32 = 0x8000;

/// A vector of [`N`](Self::N) lanes. It can also hold N / 4 pixels of four values.
pub trait SimdF32:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// One truth value per lane.
    type Mask: Copy;
    /// Number of lanes.
    const N: usize;

    /// Sets all lanes to `number`.
    fn splat(self, number: f32) -> Self;
    /// Loads the first elements of `from`.
    ///
    /// # Panics
    /// Where `from` is shorter than the vector.
    fn load(self, from: &[f32]) -> Self;
    /// Stores the lanes in the first elements of `to`.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    fn store(self, to: &mut [f32]);
    /// Computes self · factor + more, rounded once where the instruction set has FMA.
    fn times_plus(self, factor: Self, more: Self) -> Self;
    /// Reciprocal of each lane, with an error of at most two units in the last place. Undefined for infinite and
    /// tiny values.
    #[inline(always)]
    fn inverse(self) -> Self {
        self.splat(1.0) / self
    }
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn abs(self) -> Self;
    fn is_at_least(self, other: Self) -> Self::Mask;
    fn is_below(self, other: Self) -> Self::Mask;
    fn both(self, one: Self::Mask, other: Self::Mask) -> Self::Mask;
    /// Keeps lanes where the mask is set; others become 0.
    fn zero_unless(self, mask: Self::Mask) -> Self;

    /// Loads the bf16 in the lower halves and in the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
    #[inline(always)]
    fn load_halves(self, words: &[u32]) -> [Self; 2] {
        let mut halves = [[0.0; MOST]; 2];
        for i in 0..Self::N {
            halves[0][i] = f32::from_bits(words[i] << 16);
            halves[1][i] = f32::from_bits(words[i] & UPPER);
        }
        halves.map(|half| self.load(&half))
    }
    /// Rounds two vectors to bf16 and stores them in the lower and the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
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

    /// Stores the lanes as bf16, rounded to nearest, ties to even.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    #[inline(always)]
    fn store_bf16(self, to: &mut [Bf16]) {
        let mut numbers = [0.0; MOST];
        self.store(&mut numbers);
        for i in 0..Self::N {
            to[i] = Bf16::from_f32(numbers[i]);
        }
    }
    /// Loads words as signed integers and converts them to f32.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
    #[inline(always)]
    fn load_integers(self, words: &[u32]) -> Self {
        let mut numbers = [0.0; MOST];
        for i in 0..Self::N {
            numbers[i] = words[i] as i32 as f32;
        }
        self.load(&numbers)
    }
    /// Stores two vectors, interleaved, as bytes: numbers times factors, rounded, clamped to −128…127, plus 128.
    /// Products beyond ±32767 are undefined.
    ///
    /// # Panics
    /// Where there are fewer than two bytes for each lane.
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

    /// Splits each lane, a word of two bf16, into the lower and the upper one.
    fn halves(self) -> [Self; 2];
    /// Transposes four vectors, pixel by pixel: value i of pixel p of vector v becomes value v of pixel p of vector
    /// i.
    fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4];

    /// Deinterleaves three vectors: number 3·i + n of all becomes lane i of vector n.
    fn deinterleave3(vectors: [Self; 3]) -> [Self; 3];
    /// Repeats each lane three times, in three vectors.
    fn repeat3(self) -> [Self; 3];
    /// Deinterleaves two vectors: the even lanes of both, and the odd ones.
    fn deinterleave2(self, others: Self) -> [Self; 2];

    /// Even pixels of `self` and then of `others`.
    fn evens(self, others: Self) -> Self;
    /// Odd pixels of `self` and then of `others`.
    fn odds(self, others: Self) -> Self;
    /// Interleaves the first halves of the pixels of both vectors.
    fn zip_low(self, others: Self) -> Self;
    /// Interleaves the last halves of the pixels of both vectors.
    fn zip_high(self, others: Self) -> Self;
    /// Spreads the first three quarters of the lanes to pixels of three values and a 0.
    fn with_zeros(self) -> Self;
    /// Packs the first three values of each pixel side by side. Lanes after them are undefined.
    fn without_fourths(self) -> Self;
    /// Copies the fourth value of each pixel to its four lanes.
    fn fourths(self) -> Self;
    /// Replaces the fourth value of each pixel by that of `others`.
    fn with_fourths(self, others: Self) -> Self;
}

/// Transposes four vectors: lane i of vector v becomes lane v of vector i.
#[inline(always)]
pub fn transposed([a, b, c, d]: [Vec4; 4]) -> [Vec4; 4] {
    let columns = Mat4::from_cols(a, b, c, d).transpose();
    [columns.x_axis, columns.y_axis, columns.z_axis, columns.w_axis]
}

/// Loads four elements from index `at` on.
#[inline(always)]
pub fn four(numbers: &[f32], at: usize) -> Vec4 {
    Vec4::from_slice(&numbers[at..at + 4])
}

/// An inner loop in SIMD vectors. `run` and its helpers must be `#[inline(always)]`, as in
/// [`SimdOp`](super::simd::SimdOp).
pub trait SimdF32Op {
    /// Runs the loop with vectors of the type of `some`.
    fn run<V: SimdF32>(self, some: V);
}

impl Simd {
    /// Runs `work` with the longest vectors of this instruction set.
    #[inline(always)]
    pub fn in_vectors(self, work: impl SimdF32Op) {
        #[cfg(target_arch = "x86_64")]
        {
            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]
            unsafe fn avx512(work: impl SimdF32Op) {
                work.run(x86::Sixteen::zero());
            }

            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx2,fma")]
            unsafe fn avx2(work: impl SimdF32Op) {
                work.run(x86::Eight::zero());
            }

            match self {
                // SAFETY: values of `Simd` exist only for instruction sets that the processor has.
                Self::Avx512 | Self::Amx => return unsafe { avx512(work) },
                // SAFETY: see above.
                Self::Avx2 => return unsafe { avx2(work) },
                Self::Portable => {}
            }
        }
        work.run(Vec4::ZERO);
    }
}

impl SimdF32 for Vec4 {
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
    fn zero_unless(self, mask: BVec4A) -> Self {
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
    fn deinterleave3([a, b, c]: [Self; 3]) -> [Self; 3] {
        [Self::new(a.x, a.w, b.z, c.y), Self::new(a.y, b.x, b.w, c.z), Self::new(a.z, b.y, c.x, c.w)]
    }
    #[inline(always)]
    fn repeat3(self) -> [Self; 3] {
        let [x, y, z, w] = self.to_array();
        [Self::new(x, x, x, y), Self::new(y, y, z, z), Self::new(z, w, w, w)]
    }
    #[inline(always)]
    fn deinterleave2(self, others: Self) -> [Self; 2] {
        [Self::new(self.x, self.z, others.x, others.z), Self::new(self.y, self.w, others.y, others.w)]
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
    fn with_zeros(self) -> Self {
        self.with_w(0.0)
    }
    #[inline(always)]
    fn without_fourths(self) -> Self {
        self
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
mod x86;

#[cfg(test)]
mod tests {
    use super::*;

    struct Shuffles;

    impl SimdF32Op for Shuffles {
        fn run<V: SimdF32>(self, some: V) {
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
            let spaced = |i: usize| if i % 4 == 3 { 0.0 } else { numbers[i / 4 * 3 + i % 4] };
            assert_eq!(read(a.with_zeros()), expected(&spaced));
            let close = |i: usize| numbers[i / 3 * 4 + i % 3];
            let three_quarters = V::N / 4 * 3;
            assert_eq!(read(a.without_fourths())[..three_quarters], expected(&close)[..three_quarters]);
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
            // Less than half a unit in the last place is rounded down, more is rounded up.
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
            let many: Vec<f32> = (0..3 * V::N).map(|i| i as f32).collect();
            let three = std::array::from_fn(|v| some.load(&many[v * V::N..]));
            for (n, vector) in V::deinterleave3(three).into_iter().enumerate() {
                assert_eq!(read(vector), expected(&|i| many[3 * i + n]));
            }
            for (n, vector) in a.repeat3().into_iter().enumerate() {
                assert_eq!(read(vector), expected(&|i| numbers[(n * V::N + i) / 3]));
            }
            for (number, inverse) in read(a).into_iter().zip(read(a.inverse())) {
                assert!((number * inverse - 1.0).abs() <= 3.0 * f32::EPSILON, "{number} and {inverse}");
            }
            for (n, vector) in a.deinterleave2(b).into_iter().enumerate() {
                assert_eq!(read(vector), expected(&|i| numbers[2 * i + n]));
            }
            let mut halves = vec![Bf16::default(); V::N];
            // Some values lie half way between two bf16.
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
            assert_eq!(read(a.zero_unless(is_between)), expected(&kept));
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
