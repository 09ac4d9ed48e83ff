//! Vectors for every processor: eight lanes as arrays, which the compiler turns into the vectors that it has.

use crate::bf16::UPPER_HALF;
use crate::vector::{Arithmetic, Gather, Integers, Lanes, Pixels, SimdI32, Storage};
use bytemuck::cast_slice;
use std::ops::{Add, BitAnd, Div, Mul, Sub};

const N: usize = 8;

/// Eight lanes of f32 without special instructions.
#[derive(Debug, Clone, Copy)]
pub struct Portable([f32; N]);

/// Eight lanes of i32 without special instructions.
#[derive(Debug, Clone, Copy)]
pub struct PortableI32([i32; N]);

/// Eight truth values.
#[derive(Debug, Clone, Copy)]
pub struct PortableMask([bool; N]);

impl Portable {
    /// Eight zeros. It needs no instruction set.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([0.0; N])
    }
}

/// Lanes from an expression in the index of the lane. A loop is vectorised; closures are not always inlined.
macro_rules! each {
    ($i:ident => $lane:expr) => {{
        let mut lanes = [Default::default(); N];
        for $i in 0..N {
            lanes[$i] = $lane;
        }
        lanes
    }};
}

macro_rules! operators {
    ($vector:ident: $($operator:ident::$method:ident = $function:expr),*) => {
        $(impl $operator for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let function = $function;
                Self(each!(i => function(self.0[i], other.0[i])))
            }
        })*
    };
}
operators!(Portable: Add::add = |a: f32, b| a + b, Sub::sub = |a: f32, b| a - b, Mul::mul = |a: f32, b| a * b, Div::div = |a: f32, b| a / b);
operators!(PortableI32: Add::add = i32::wrapping_add, Sub::sub = i32::wrapping_sub, Mul::mul = i32::wrapping_mul, BitAnd::bitand = |a: i32, b: i32| a & b);
operators!(PortableMask: BitAnd::bitand = |a: bool, b: bool| a & b);

#[rustfmt::skip]
impl Arithmetic for Portable {
    type Mask = PortableMask;
    const N: usize = N;

    #[inline(always)] fn splat(self, number: f32) -> Self { Self([number; N]) }
    #[inline(always)] fn load(self, from: &[f32]) -> Self { let from = &from[..N]; Self(each!(i => from[i])) }
    #[inline(always)] fn store(self, to: &mut [f32]) { to[..N].copy_from_slice(&self.0); }
    // Rounded twice: a fused one is a slow call where the processor lacks it.
    #[inline(always)] fn mul_add(self, factor: Self, more: Self) -> Self { self * factor + more }
    #[inline(always)] fn max(self, other: Self) -> Self { Self(each!(i => if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] })) }
    #[inline(always)] fn min(self, other: Self) -> Self { Self(each!(i => if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] })) }
    #[inline(always)] fn abs(self) -> Self { Self(each!(i => self.0[i].abs())) }
    #[inline(always)] fn sqrt(self) -> Self { Self(each!(i => self.0[i].sqrt())) }
    #[inline(always)] fn ceil(self) -> Self { Self(each!(i => self.0[i].ceil())) }
    #[inline(always)] fn simd_lt(self, other: Self) -> PortableMask { PortableMask(each!(i => self.0[i] < other.0[i])) }
    #[inline(always)] fn simd_gt(self, other: Self) -> PortableMask { PortableMask(each!(i => self.0[i] > other.0[i])) }
    #[inline(always)] fn simd_ge(self, other: Self) -> PortableMask { PortableMask(each!(i => self.0[i] >= other.0[i])) }
    #[inline(always)] fn select(mask: PortableMask, yes: Self, no: Self) -> Self { Self(each!(i => if mask.0[i] { yes.0[i] } else { no.0[i] })) }
    #[inline(always)] fn zero_unless(self, mask: PortableMask) -> Self { Self::select(mask, self, Self::zero()) }
    #[inline(always)] fn bits_of(mask: PortableMask) -> u32 { (0..N).fold(0, |bits, i| bits | u32::from(mask.0[i]) << i) }
    #[inline(always)] fn mask_of(self, bits: u32) -> PortableMask { PortableMask(each!(i => bits >> i & 1 == 1)) }
}

#[rustfmt::skip]
impl Lanes for Portable {
    #[inline(always)] fn iota(self) -> Self { Self(each!(i => i as f32)) }
    #[inline(always)] fn sum(self) -> f32 { self.0.iter().sum() }
    #[inline(always)] fn products_before(self) -> (Self, f32) {
        let mut product = 1.0;
        let before = each!(i => { let before = product; product *= self.0[i]; before });
        (Self(before), product)
    }
    #[inline(always)] fn moved_up(self, first: f32) -> Self { Self(each!(i => if i == 0 { first } else { self.0[i - 1] })) }
    #[inline(always)] fn neighbours(self) -> Self { Self(each!(i => self.0[i ^ 1])) }
    #[inline(always)] fn next_neighbours(self) -> Self { Self(each!(i => self.0[i ^ 2])) }
    #[inline(always)] fn compress(self, mask: PortableMask, to: &mut [f32]) {
        let (to, mut next) = (&mut to[..N], 0);
        for i in 0..N {
            if mask.0[i] {
                to[next] = self.0[i];
                next += 1;
            }
        }
    }
    #[inline(always)] fn expand(self, mask: PortableMask, from: &[f32]) -> Self {
        let (from, mut next, mut lanes) = (&from[..N], 0, self.0);
        for i in 0..N {
            if mask.0[i] {
                lanes[i] = from[next];
                next += 1;
            }
        }
        Self(lanes)
    }
}

#[rustfmt::skip]
impl SimdI32 for PortableI32 {
    #[inline(always)] fn splat(self, number: i32) -> Self { Self([number; N]) }
    #[inline(always)] fn store(self, to: &mut [i32]) { to[..N].copy_from_slice(&self.0); }
    #[inline(always)] fn shr<const BITS: u32>(self) -> Self { self.shr_by(BITS) }
    #[inline(always)] fn shr_by(self, bits: u32) -> Self { Self(each!(i => (self.0[i] as u32 >> bits) as i32)) }
    #[inline(always)] fn shl_lanes(self, by: Self) -> Self { Self(each!(i => (self.0[i] as u32).checked_shl(by.0[i] as u32).unwrap_or(0) as i32)) }
    #[inline(always)] fn shr_lanes(self, by: Self) -> Self { Self(each!(i => (self.0[i] as u32).checked_shr(by.0[i] as u32).unwrap_or(0) as i32)) }
    #[inline(always)] fn weighted_bytes<const PAIR: usize>(self, weights: Self) -> Self {
        Self(each!(i => {
            let pair = self.0[i] as u32 >> (16 * PAIR as u32);
            let weights = weights.0[i] as u32;
            ((pair & 0xFF) * (weights & 0xFFFF) + (pair >> 8 & 0xFF) * (weights >> 16)) as i32
        }))
    }
}

#[rustfmt::skip]
impl Integers for Portable {
    type I32 = PortableI32;

    #[inline(always)] fn splat_i32(self, number: i32) -> PortableI32 { PortableI32([number; N]) }
    #[inline(always)] fn to_i32(self) -> PortableI32 { PortableI32(each!(i => self.0[i] as i32)) }
    #[inline(always)] fn from_i32(integers: PortableI32) -> Self { Self(each!(i => integers.0[i] as f32)) }
    #[inline(always)] fn to_bits(self) -> PortableI32 { PortableI32(each!(i => self.0[i].to_bits() as i32)) }
    #[inline(always)] fn from_bits(bits: PortableI32) -> Self { Self(each!(i => f32::from_bits(bits.0[i] as u32))) }
}

impl Gather for Portable {
    #[inline(always)]
    unsafe fn gather_bytes<const SCALE: i32>(from: &[u8], offset: PortableI32) -> PortableI32 {
        debug_assert!(Self::are_below(offset, SCALE, from.len().saturating_sub(3)));
        // SAFETY: the caller's.
        let word =
            |at: usize| unsafe { from.as_ptr().add(at * SCALE as usize).cast::<i32>().read_unaligned() };
        PortableI32(each!(i => word(offset.0[i] as usize)))
    }
    #[inline(always)]
    unsafe fn gather(from: &[f32], index: PortableI32) -> Self {
        debug_assert!(Self::are_below(index, 1, from.len()));
        // SAFETY: the caller's.
        Self(each!(i => unsafe { *from.get_unchecked(index.0[i] as usize) }))
    }
    #[inline(always)]
    unsafe fn gather_pairs(from: &[f32], index: PortableI32) -> [Self; 2] {
        // SAFETY: the caller's.
        unsafe { [Self::gather(from, index), Self::gather(from.get_unchecked(1..), index)] }
    }
    #[inline(always)]
    unsafe fn load_word_pairs(from: &[u32], index: PortableI32) -> [PortableI32; 2] {
        // SAFETY: the caller's. An f32 may hold any bits.
        let [words, next] = unsafe { Self::gather_pairs(cast_slice(from), index) };
        [words.to_bits(), next.to_bits()]
    }
}

#[rustfmt::skip]
impl Pixels for Portable {
    #[inline(always)] fn pixels_transposed(vectors: [Self; 4]) -> [Self; 4] {
        let [a, b, c, d] = vectors;
        [0, 1, 2, 3].map(|v| Self(each!(i => [a, b, c, d][i % 4].0[i / 4 * 4 + v])))
    }
    #[inline(always)] fn deinterleave3(vectors: [Self; 3]) -> [Self; 3] {
        [0, 1, 2].map(|n| Self(each!(i => vectors[(3 * i + n) / N].0[(3 * i + n) % N])))
    }
    #[inline(always)] fn repeat3(self) -> [Self; 3] { [0, 1, 2].map(|n| Self(each!(i => self.0[(n * N + i) / 3]))) }
    #[inline(always)] fn deinterleave2(self, others: Self) -> [Self; 2] {
        [0, 1].map(|n| Self(each!(i => [self, others][(2 * i + n) / N].0[(2 * i + n) % N])))
    }
    #[inline(always)] fn evens(self, others: Self) -> Self { Self(each!(i => [self, others][i / 4].0[i % 4])) }
    #[inline(always)] fn odds(self, others: Self) -> Self { Self(each!(i => [self, others][i / 4].0[4 + i % 4])) }
    #[inline(always)] fn zip_low(self, others: Self) -> Self { self.evens(others) }
    #[inline(always)] fn zip_high(self, others: Self) -> Self { self.odds(others) }
    #[inline(always)] fn with_zeros(self) -> Self { Self(each!(i => if i % 4 == 3 { 0.0 } else { self.0[i / 4 * 3 + i % 4] })) }
    #[inline(always)] fn without_fourths(self) -> Self { Self(each!(i => self.0[(i / 3 * 4 + i % 3).min(N - 1)])) }
    #[inline(always)] fn fourths(self) -> Self { Self(each!(i => self.0[i | 3])) }
    #[inline(always)] fn with_fourths(self, others: Self) -> Self { Self(each!(i => if i % 4 == 3 { others.0[i] } else { self.0[i] })) }
}

impl Storage for Portable {
    #[inline(always)]
    fn halves(self) -> [Self; 2] {
        let lower = each!(i => f32::from_bits(self.0[i].to_bits() << 16));
        [Self(lower), Self(each!(i => f32::from_bits(self.0[i].to_bits() & UPPER_HALF)))]
    }
}
