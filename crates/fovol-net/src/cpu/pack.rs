//! What convolutions make of the numbers they read, before they multiply them.

use super::element::{Bf16, Element};
use bytemuck::Pod;

/// Numbers that are made at once: loops over as many become vectors.
const LANES: usize = 16;

/// A way to make what is multiplied out of what is stored.
pub trait Pack: Copy {
    /// What is multiplied.
    type Number: Pod + Default;

    /// What the numbers of `count` channels from `channel` on are multiplied by beforehand; nothing where they are not.
    fn factors(&self, channel: usize, count: usize) -> &[f32];

    /// Makes one.
    fn number<T: Element>(value: T, factor: f32) -> Self::Number;

    /// Makes some at once.
    #[inline(always)]
    fn lanes<T: Element>(from: [T; LANES], factors: &[f32; LANES]) -> [Self::Number; LANES] {
        let mut made = [Self::Number::default(); LANES];
        for k in 0..LANES {
            made[k] = Self::number(from[k], factors[k]);
        }
        made
    }

    /// Makes `to` of `from`, numbers of a pixel from `channel` on.
    #[inline(always)]
    fn numbers<T: Element>(self, channel: usize, from: &[T], to: &mut [Self::Number]) {
        let factors = Lanes::of(self.factors(channel, from.len()));
        let ((wide, from), (wide_to, to)) = (from.as_chunks::<LANES>(), to.as_chunks_mut::<LANES>());
        for (i, (to, from)) in wide_to.iter_mut().zip(wide).enumerate() {
            *to = Self::lanes(*from, factors.lanes(i));
        }
        for (k, (to, from)) in to.iter_mut().zip(from).enumerate() {
            *to = Self::number(*from, factors.last(k));
        }
    }

    /// The same of the sum of `left` and `right`, each times its weight.
    #[inline(always)]
    fn sums(self, channel: usize, left: (&[f32], f32), right: (&[f32], f32), to: &mut [Self::Number]) {
        let factors = Lanes::of(self.factors(channel, left.0.len()));
        let ((left, l), (right, r)) = (left, right);
        let ((wide_left, left), (wide_right, right)) =
            (left.as_chunks::<LANES>(), right.as_chunks::<LANES>());
        let (wide_to, to) = to.as_chunks_mut::<LANES>();
        for (i, (to, (left, right))) in wide_to.iter_mut().zip(wide_left.iter().zip(wide_right)).enumerate() {
            let mut sums = [0.0; LANES];
            for k in 0..LANES {
                sums[k] = l * left[k] + r * right[k];
            }
            *to = Self::lanes(sums, factors.lanes(i));
        }
        for (k, (to, (left, right))) in to.iter_mut().zip(left.iter().zip(right)).enumerate() {
            *to = Self::number(l * left + r * right, factors.last(k));
        }
    }
}

/// Factors, or ones where there are none.
#[derive(Clone, Copy)]
struct Lanes<'a> {
    wide: &'a [[f32; LANES]],
    last: &'a [f32],
}

impl<'a> Lanes<'a> {
    #[inline(always)]
    fn of(factors: &'a [f32]) -> Self {
        let (wide, last) = factors.as_chunks();
        Self { wide, last }
    }

    #[inline(always)]
    fn lanes(self, i: usize) -> &'a [f32; LANES] {
        if self.wide.is_empty() { &[1.0; LANES] } else { &self.wide[i] }
    }

    #[inline(always)]
    fn last(self, k: usize) -> f32 {
        if self.last.is_empty() { 1.0 } else { self.last[k] }
    }
}

/// f32.
#[derive(Debug, Clone, Copy)]
pub struct Singles;

impl Pack for Singles {
    type Number = f32;

    #[inline(always)]
    fn factors(&self, _: usize, _: usize) -> &[f32] {
        &[]
    }

    #[inline(always)]
    fn number<T: Element>(value: T, _: f32) -> f32 {
        value.to_f32()
    }
}

/// bf16.
#[derive(Debug, Clone, Copy)]
pub struct Halves;

impl Pack for Halves {
    type Number = Bf16;

    #[inline(always)]
    fn factors(&self, _: usize, _: usize) -> &[f32] {
        &[]
    }

    #[inline(always)]
    fn number<T: Element>(value: T, _: f32) -> Bf16 {
        value.to_bf16()
    }

    #[inline(always)]
    fn lanes<T: Element>(from: [T; LANES], _: &[f32; LANES]) -> [Bf16; LANES] {
        T::to_bf16s(from)
    }
}

/// Bytes: value · factor of its channel, rounded, 0…255.
#[derive(Debug, Clone, Copy)]
pub struct Bytes<'a>(pub &'a [f32]);

impl Pack for Bytes<'_> {
    type Number = u8;

    #[inline(always)]
    fn factors(&self, channel: usize, count: usize) -> &[f32] {
        &self.0[channel..channel + count]
    }

    /// The nearest byte. Next to 2²³ an f32 has no fraction, so its last bits are the whole number: unlike a cast, which
    /// minds numbers that are none, this becomes vectors.
    #[inline(always)]
    fn number<T: Element>(value: T, factor: f32) -> u8 {
        ((value.to_f32() * factor).clamp(0.0, 255.0) + 8_388_608.0).to_bits() as u8
    }
}
