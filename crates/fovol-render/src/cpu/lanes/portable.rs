#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "the safety comment of the impl speaks for all its one-instruction methods"
)]

use super::Lanes;
use std::array::from_fn;

/// 8 lanes as arrays, for every processor; the compiler turns them into what vectors it has.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

type F = [f32; 8];
type I = [i32; 8];
type M = [bool; 8];

// SAFETY: plain code; only pointers can be wrong, which the trait's contract forbids.
#[rustfmt::skip]
unsafe impl Lanes for Portable {
    const N: usize = 8;
    type F = F;
    type I = I;
    type M = M;

    #[inline(always)] unsafe fn splat(x: f32) -> F { [x; 8] }
    #[inline(always)] unsafe fn load(from: *const f32) -> F { unsafe { from.cast::<F>().read_unaligned() } }
    #[inline(always)] unsafe fn store(v: F, to: *mut f32) { unsafe { to.cast::<F>().write_unaligned(v) } }
    #[inline(always)] unsafe fn add(a: F, b: F) -> F { from_fn(|i| a[i] + b[i]) }
    #[inline(always)] unsafe fn sub(a: F, b: F) -> F { from_fn(|i| a[i] - b[i]) }
    #[inline(always)] unsafe fn mul(a: F, b: F) -> F { from_fn(|i| a[i] * b[i]) }
    #[inline(always)] unsafe fn div(a: F, b: F) -> F { from_fn(|i| a[i] / b[i]) }
    // Rounded twice: a fused one is a slow call where the processor lacks it.
    #[inline(always)] unsafe fn fma(a: F, b: F, c: F) -> F { from_fn(|i| a[i] * b[i] + c[i]) }
    #[inline(always)] unsafe fn min(a: F, b: F) -> F { from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] }) }
    #[inline(always)] unsafe fn max(a: F, b: F) -> F { from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] }) }
    #[inline(always)] unsafe fn sqrt(a: F) -> F { a.map(f32::sqrt) }
    #[inline(always)] unsafe fn ceil(a: F) -> F { a.map(f32::ceil) }
    #[inline(always)] unsafe fn abs(a: F) -> F { a.map(f32::abs) }
    #[inline(always)] unsafe fn iota() -> F { from_fn(|i| i as f32) }
    #[inline(always)] unsafe fn sum(a: F) -> f32 { a.iter().sum() }
    #[inline(always)]
    unsafe fn products_before(a: F) -> (F, f32) {
        let mut product = 1.0;
        let before = a.map(|x| { let p = product; product *= x; p });
        (before, product)
    }
    #[inline(always)]
    unsafe fn moved_up(v: F, first: f32) -> F { from_fn(|i| if i == 0 { first } else { v[i - 1] }) }
    #[inline(always)] unsafe fn neighbours(v: F) -> F { from_fn(|i| v[i ^ 1]) }
    #[inline(always)] unsafe fn next_neighbours(v: F) -> F { from_fn(|i| v[i ^ 2]) }
    #[inline(always)]
    unsafe fn compress(v: F, m: M, to: *mut f32) {
        let mut to = to;
        for i in 0..8 {
            if m[i] {
                unsafe { to.write(v[i]); to = to.add(1); }
            }
        }
    }

    #[inline(always)]
    unsafe fn expand(old: F, m: M, from: *const f32) -> F {
        let (mut lanes, mut from) = (old, from);
        for i in 0..8 {
            if m[i] {
                unsafe { lanes[i] = from.read(); from = from.add(1); }
            }
        }
        lanes
    }

    #[inline(always)] unsafe fn truncate(a: F) -> I { a.map(|x| x as i32) }
    #[inline(always)] unsafe fn to_f32(a: I) -> F { a.map(|x| x as f32) }
    #[inline(always)] unsafe fn from_bits(a: I) -> F { a.map(|x| f32::from_bits(x as u32)) }
    #[inline(always)] unsafe fn to_bits(a: F) -> I { a.map(|x| x.to_bits() as i32) }
    #[inline(always)] unsafe fn splat_i(x: i32) -> I { [x; 8] }
    #[inline(always)] unsafe fn add_i(a: I, b: I) -> I { from_fn(|i| a[i].wrapping_add(b[i])) }
    #[inline(always)] unsafe fn sub_i(a: I, b: I) -> I { from_fn(|i| a[i].wrapping_sub(b[i])) }
    #[inline(always)] unsafe fn mul_i(a: I, b: I) -> I { from_fn(|i| a[i].wrapping_mul(b[i])) }
    #[inline(always)] unsafe fn and_i(a: I, b: I) -> I { from_fn(|i| a[i] & b[i]) }
    #[inline(always)] unsafe fn shr_i<const BITS: u32>(a: I) -> I { a.map(|x| (x as u32 >> BITS) as i32) }
    #[inline(always)] unsafe fn shr_by(a: I, bits: u32) -> I { a.map(|x| (x as u32 >> bits) as i32) }
    #[inline(always)] unsafe fn shift_left(a: I, by: I) -> I {
        from_fn(|i| (a[i] as u32).checked_shl(by[i] as u32).unwrap_or(0) as i32)
    }
    #[inline(always)] unsafe fn shift_right(a: I, by: I) -> I {
        from_fn(|i| (a[i] as u32).checked_shr(by[i] as u32).unwrap_or(0) as i32)
    }
    #[inline(always)] unsafe fn gather<const SCALE: i32>(base: *const u8, offset: I) -> I {
        offset.map(|o| unsafe { base.offset(o as isize * SCALE as isize).cast::<i32>().read_unaligned() })
    }
    #[inline(always)] unsafe fn gather_f32(table: *const f32, index: I) -> F {
        index.map(|i| unsafe { table.offset(i as isize).read() })
    }
    #[inline(always)] unsafe fn gather_words(base: *const u32, index: I) -> (I, I) {
        let at = |i: i32| unsafe { base.offset(i as isize).read() as i32 };
        (index.map(at), index.map(|i| at(i + 1)))
    }
    #[inline(always)] unsafe fn weighted_bytes<const PAIR: usize>(words: I, weights: I) -> I {
        from_fn(|i| {
            let pair = words[i] as u32 >> (16 * PAIR as u32);
            let weights = weights[i] as u32;
            ((pair & 0xFF) * (weights & 0xFFFF) + (pair >> 8 & 0xFF) * (weights >> 16)) as i32
        })
    }
    #[inline(always)] unsafe fn gather_pair(base: *const u8, index: I) -> (F, F) {
        let at = |i: i32| unsafe { base.cast::<f32>().offset(i as isize).read_unaligned() };
        (index.map(at), index.map(|i| at(i + 1)))
    }

    #[inline(always)] unsafe fn lt(a: F, b: F) -> M { from_fn(|i| a[i] < b[i]) }
    #[inline(always)] unsafe fn gt(a: F, b: F) -> M { from_fn(|i| a[i] > b[i]) }
    #[inline(always)] unsafe fn and_m(a: M, b: M) -> M { from_fn(|i| a[i] & b[i]) }
    #[inline(always)] unsafe fn select(m: M, a: F, b: F) -> F { from_fn(|i| if m[i] { a[i] } else { b[i] }) }
    #[inline(always)] unsafe fn bits(m: M) -> u32 { (0..8).fold(0, |bits, i| bits | u32::from(m[i]) << i) }
    #[inline(always)] unsafe fn mask(bits: u32) -> M { from_fn(|i| bits >> i & 1 == 1) }
}
