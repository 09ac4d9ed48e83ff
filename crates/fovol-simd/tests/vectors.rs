//! Every operation of every instruction set against plain arithmetic.

use fovol_simd::{Bf16, Simd, SimdF32, SimdF32Op, SimdI32};
use proptest::prelude::*;

struct Arithmetic;

impl SimdF32Op for Arithmetic {
    type Output = ();

    fn run<V: SimdF32>(self, some: V) {
        let numbers: Vec<f32> = (0..2 * V::N).map(|i| i as f32 - 3.5).collect();
        let (a, b) = (some.load(&numbers), some.load(&numbers[V::N..]));
        let read = |v: V| {
            let mut out = vec![0.0; V::N];
            v.store(&mut out);
            out
        };
        let expected = |f: &dyn Fn(usize) -> f32| (0..V::N).map(f).collect::<Vec<_>>();
        assert_eq!(read(a.abs()), expected(&|i| numbers[i].abs()));
        assert_eq!(
            read(a.max(some.splat(0.25)).min(some.splat(1.0))),
            expected(&|i| numbers[i].clamp(0.25, 1.0))
        );
        for (number, inverse) in read(a).into_iter().zip(read(a.recip())) {
            assert!((number * inverse - 1.0).abs() <= 3.0 * f32::EPSILON, "{number} and {inverse}");
        }
        let is_between = a.simd_ge(some.splat(-1.5)) & a.simd_lt(some.splat(0.5));
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

struct Pixels;

impl SimdF32Op for Pixels {
    type Output = ();

    fn run<V: SimdF32>(self, some: V) {
        let numbers: Vec<f32> = (0..2 * V::N).map(|i| i as f32 - 3.5).collect();
        let (a, b) = (some.load(&numbers), some.load(&numbers[V::N..]));
        let read = |v: V| {
            let mut out = vec![0.0; V::N];
            v.store(&mut out);
            out
        };
        let expected = |f: &dyn Fn(usize) -> f32| (0..V::N).map(f).collect::<Vec<_>>();
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
        let spaced = |i: usize| if i % 4 == 3 { 0.0 } else { numbers[i / 4 * 3 + i % 4] };
        assert_eq!(read(a.with_zeros()), expected(&spaced));
        let close = |i: usize| numbers[i / 3 * 4 + i % 3];
        let three_quarters = V::N / 4 * 3;
        assert_eq!(read(a.without_fourths())[..three_quarters], expected(&close)[..three_quarters]);
        assert_eq!(read(a.fourths()), expected(&|i| numbers[i / 4 * 4 + 3]));
        let fourth = |i: usize| if i % 4 == 3 { numbers[V::N + i] } else { numbers[i] };
        assert_eq!(read(a.with_fourths(b)), expected(&fourth));
        let four =
            std::array::from_fn(|v| some.load(&(0..V::N).map(|i| (100 * v + i) as f32).collect::<Vec<_>>()));
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
        for (n, vector) in a.deinterleave2(b).into_iter().enumerate() {
            assert_eq!(read(vector), expected(&|i| numbers[2 * i + n]));
        }
    }
}

struct Storage;

impl SimdF32Op for Storage {
    type Output = ();

    fn run<V: SimdF32>(self, some: V) {
        let read = |v: V| {
            let mut out = vec![0.0; V::N];
            v.store(&mut out);
            out
        };
        let expected = |f: &dyn Fn(usize) -> f32| (0..V::N).map(f).collect::<Vec<_>>();
        let words: Vec<u32> = (0..V::N as u32).map(|i| 0x3F81_BE02 + 0x0001_0003 * i).collect();
        let [lower, upper] = some.load_halves(&words);
        assert_eq!(read(lower), expected(&|i| f32::from_bits(words[i] << 16)));
        assert_eq!(read(upper), expected(&|i| f32::from_bits(words[i] & 0xFFFF_0000)));
        let mut stored = vec![0; V::N];
        // Less than half a unit in the last place is rounded down, more is rounded up.
        let (more, less) = (some.splat(1.0 + 0.7 / 256.0), some.splat(1.0 + 0.3 / 256.0));
        (lower * more).store_halves(upper * less, &mut stored);
        let rounded = |value: f32| (value.to_bits() + 0x8000) >> 16;
        for i in 0..V::N {
            let [lower, upper] = [read(lower * more)[i], read(upper * less)[i]].map(rounded);
            assert_eq!(stored[i], lower | upper << 16);
        }
        let mut halves = vec![Bf16::default(); V::N];
        // Some values lie half way between two bf16.
        let between: Vec<f32> = (0..V::N as u32).map(|i| f32::from_bits(0x3F80_8000 + 0x5000 * i)).collect();
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
    }
}

/// Integer lanes as a list.
fn list<I: SimdI32>(integers: I, count: usize) -> Vec<i32> {
    let mut lanes = vec![0; 16];
    integers.store(&mut lanes);
    lanes.truncate(count);
    lanes
}

/// Lanes as a list.
fn read<V: SimdF32>(v: V) -> Vec<f32> {
    let mut out = vec![0.0; V::N];
    v.store(&mut out);
    out
}

struct Lanes {
    numbers: Vec<f32>,
    bits: u32,
}

impl SimdF32Op for &Lanes {
    type Output = ();

    fn run<V: SimdF32>(self, zero: V) {
        let (n, numbers) = (V::N, &self.numbers[..V::N]);
        let bits = self.bits & (u32::MAX >> (32 - n as u32));
        let (v, mask) = (zero.load(numbers), zero.mask_of(bits));
        let is_set = |i: usize| bits >> i & 1 == 1;
        let expected = |f: &dyn Fn(usize) -> f32| (0..n).map(f).collect::<Vec<_>>();
        assert_eq!(V::bits_of(mask), bits);
        assert_eq!(read(zero.iota()), expected(&|i| i as f32));
        let sum: f64 = numbers.iter().map(|&x| f64::from(x)).sum();
        assert!((f64::from(v.sum()) - sum).abs() < 1e-4, "{} and {sum}", v.sum());
        let (before, all) = v.products_before();
        let mut product = 1.0;
        for (before, number) in read(before).into_iter().zip(numbers) {
            assert!((f64::from(before) - product).abs() <= 1e-5 * product.abs(), "{before} and {product}");
            product *= f64::from(*number);
        }
        assert!((f64::from(all) - product).abs() <= 1e-5 * product.abs(), "{all} and {product}");
        assert_eq!(read(v.moved_up(0.25)), expected(&|i| if i == 0 { 0.25 } else { numbers[i - 1] }));
        assert_eq!(read(v.neighbours()), expected(&|i| numbers[i ^ 1]));
        assert_eq!(read(v.next_neighbours()), expected(&|i| numbers[i ^ 2]));
        assert_eq!(read(v.sqrt()), expected(&|i| numbers[i].sqrt()));
        assert_eq!(read(v.ceil()), expected(&|i| numbers[i].ceil()));
        assert_eq!(
            read(V::select(mask, v, zero.splat(-1.0))),
            expected(&|i| if is_set(i) { numbers[i] } else { -1.0 })
        );
        let mut packed = vec![7.0; n];
        v.compress(mask, &mut packed);
        let kept: Vec<f32> = (0..n).filter(|&i| is_set(i)).map(|i| numbers[i]).collect();
        assert_eq!(packed[..kept.len()], kept);
        let spread = read(zero.splat(-2.0).expand(mask, &packed));
        assert_eq!(spread, expected(&|i| if is_set(i) { numbers[i] } else { -2.0 }));
        let nan = zero.splat(f32::NAN);
        assert_eq!((read(nan.min(v)), read(nan.max(v))), (numbers.to_vec(), numbers.to_vec()));
    }
}

struct Integers {
    a: Vec<i32>,
    b: Vec<i32>,
}

impl SimdF32Op for &Integers {
    type Output = ();

    fn run<V: SimdF32>(self, zero: V) {
        let vector = |numbers: &[i32]| {
            let bits: Vec<f32> = numbers.iter().map(|&x| f32::from_bits(x as u32)).collect();
            zero.load(&bits).to_bits()
        };
        let (a, b) = (vector(&self.a), vector(&self.b));
        let expected = |f: &dyn Fn(i32, i32) -> i32| -> Vec<i32> {
            self.a.iter().zip(&self.b).map(|(&a, &b)| f(a, b)).take(V::N).collect()
        };
        let list = |integers: V::I32| list(integers, V::N);
        assert_eq!(list(a + b), expected(&i32::wrapping_add));
        assert_eq!(list(a - b), expected(&i32::wrapping_sub));
        assert_eq!(list(a * b), expected(&i32::wrapping_mul));
        assert_eq!(list(a & b), expected(&|a, b| a & b));
        assert_eq!(list(a.shr::<7>()), expected(&|a, _| (a as u32 >> 7) as i32));
        assert_eq!(list(a.shr_by(9)), expected(&|a, _| (a as u32 >> 9) as i32));
        let by = b & a.splat(0x3F);
        let shifted = |shift: fn(u32, u32) -> Option<u32>| {
            expected(&|a, b| shift(a as u32, b as u32 & 0x3F).unwrap_or(0) as i32)
        };
        assert_eq!(list(a.shl_lanes(by)), shifted(u32::checked_shl));
        assert_eq!(list(a.shr_lanes(by)), shifted(u32::checked_shr));
        let weights = b & a.splat(0x7FFF_7FFF);
        let pair = |at: u32| {
            expected(&|a, b| {
                let [low, high] = [a >> (16 * at) & 0xFF, a >> (16 * at + 8) & 0xFF];
                low * (b & 0x7FFF) + high * (b >> 16 & 0x7FFF)
            })
        };
        assert_eq!(list(a.weighted_bytes::<0>(weights)), pair(0));
        assert_eq!(list(a.weighted_bytes::<1>(weights)), pair(1));
        let small = a.shr::<9>();
        assert_eq!(list(V::from_i32(small).to_i32()), expected(&|a, _| (a as u32 >> 9) as i32));
        assert_eq!(list(V::from_bits(a).to_bits()), expected(&|a, _| a));
        assert_eq!(list(zero.splat_i32(-5)), expected(&|_, _| -5));
    }
}

struct Gathers {
    words: Vec<u32>,
    index: Vec<usize>,
}

impl SimdF32Op for &Gathers {
    type Output = ();

    fn run<V: SimdF32>(self, zero: V) {
        let numbers: Vec<f32> = self.words.iter().map(|&word| word as f32).collect();
        let index: Vec<f32> = self.index.iter().map(|&at| at as f32).collect();
        let at = zero.load(&index).to_i32();
        let expected =
            |f: &dyn Fn(usize) -> i32| self.index.iter().map(|&at| f(at)).take(V::N).collect::<Vec<_>>();
        let bytes: Vec<u8> = self.words.iter().flat_map(|word| word.to_ne_bytes()).collect();
        let word = |at: usize| i32::from_ne_bytes(bytes[at..at + 4].try_into().unwrap());
        // SAFETY: indices and their successors are those of words.
        let (words, pairs, one, both, byte) = unsafe {
            (
                V::gather_bytes::<4>(&bytes, at),
                V::load_word_pairs(&self.words, at),
                V::gather(&numbers, at),
                V::gather_pairs(&numbers, at),
                V::gather_bytes::<1>(&bytes, at),
            )
        };
        assert_eq!(list(words, V::N), expected(&|at| self.words[at] as i32));
        assert_eq!(list(byte, V::N), expected(&word));
        for next in 0..2 {
            assert_eq!(list(pairs[next], V::N), expected(&|at| self.words[at + next] as i32));
            assert_eq!(list(both[next].to_i32(), V::N), expected(&|at| numbers[at + next] as i32));
        }
        assert_eq!(list(one.to_i32(), V::N), expected(&|at| numbers[at] as i32));
    }
}

#[test]
fn every_instruction_set_shuffles_stores_and_computes_alike() {
    for simd in Simd::available() {
        simd.in_vectors(Arithmetic);
        simd.in_vectors(Pixels);
        simd.in_vectors(Storage);
    }
}

proptest! {
    #[test]
    fn lanes_move(numbers in prop::collection::vec(0.1f32..1.9, 16), bits in any::<u32>()) {
        let lanes = Lanes { numbers, bits };
        Simd::available().into_iter().for_each(|simd| simd.in_vectors(&lanes));
    }

    #[test]
    fn integers_wrap_and_shift(a in prop::collection::vec(any::<i32>(), 16), b in prop::collection::vec(any::<i32>(), 16)) {
        let integers = Integers { a, b };
        Simd::available().into_iter().for_each(|simd| simd.in_vectors(&integers));
    }

    #[test]
    fn gathers_read_what_indices_name(
        words in prop::collection::vec(0u32..1 << 24, 100),
        index in prop::collection::vec(0usize..99, 16),
    ) {
        let gathers = Gathers { words, index };
        Simd::available().into_iter().for_each(|simd| simd.in_vectors(&gathers));
    }
}
