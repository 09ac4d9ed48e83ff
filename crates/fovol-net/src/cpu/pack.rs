//! What convolutions make of the numbers they read, before they multiply them.
//!
//! Loops go over whole rows wherever they can: those become vectors, others may not.

use super::element::{Bf16, Element};
use super::lines::Lines;
use bytemuck::Pod;

/// Numbers that are copied at once.
const LANES: usize = 16;

/// A way to make what is multiplied out of what is stored.
pub trait Pack: Copy {
    /// What is multiplied.
    type Number: Pod + Default;

    /// Makes numbers of `from`, pixels side by side with `channels`, and writes them to `to`; `row` is memory.
    fn pack<T: Element>(self, channels: Channels, from: &[T], row: &mut Lines, to: To<'_, Self::Number>);
}

/// Channels of a source.
#[derive(Debug, Clone, Copy)]
pub struct Channels {
    /// The first of them, among those of all sources.
    pub first: usize,
    /// How many there are.
    pub count: usize,
}

/// Where numbers go.
pub struct To<'a, N> {
    /// From the first channel of the first pixel on.
    pub numbers: &'a mut [N],
    /// From one pixel to the next.
    pub stride: usize,
}

impl<N: Pod> To<'_, N> {
    /// Writes `pixels` of `count` channels.
    #[inline(always)]
    fn place(self, pixels: &[N], count: usize) {
        if self.stride == count {
            self.numbers[..pixels.len()].copy_from_slice(pixels);
            return;
        }
        // Few numbers take longer to count than to copy.
        match count {
            2 => return self.place_each::<2>(pixels),
            3 => return self.place_each::<3>(pixels),
            4 => return self.place_each::<4>(pixels),
            6 => return self.place_each::<6>(pixels),
            16 => return self.place_each::<16>(pixels),
            32 => return self.place_each::<32>(pixels),
            _ => {}
        }
        for (to, from) in self.numbers.chunks_mut(self.stride).zip(pixels.chunks_exact(count)) {
            let ((to, last), (from, from_last)) = (to[..count].as_chunks_mut(), from.as_chunks::<LANES>());
            for (to, from) in to.iter_mut().zip(from) {
                *to = *from;
            }
            for (to, from) in last.iter_mut().zip(from_last) {
                *to = *from;
            }
        }
    }

    /// The same for `COUNT` channels.
    #[inline(always)]
    fn place_each<const COUNT: usize>(self, pixels: &[N]) {
        for (to, from) in self.numbers.chunks_mut(self.stride).zip(pixels.as_chunks::<COUNT>().0) {
            if let Some(to) = to.first_chunk_mut() {
                *to = *from;
            }
        }
    }
}

/// f32.
#[derive(Debug, Clone, Copy)]
pub struct Singles;

impl Pack for Singles {
    type Number = f32;

    #[inline(always)]
    fn pack<T: Element>(self, channels: Channels, from: &[T], row: &mut Lines, to: To<'_, f32>) {
        if let Some(from) = T::singles(from) {
            return to.place(from, channels.count);
        }
        let row = row.numbers(from.len());
        for (to, from) in row.iter_mut().zip(from) {
            *to = from.to_f32();
        }
        to.place(row, channels.count);
    }
}

/// bf16.
#[derive(Debug, Clone, Copy)]
pub struct Halves;

impl Pack for Halves {
    type Number = Bf16;

    #[inline(always)]
    fn pack<T: Element>(self, channels: Channels, from: &[T], row: &mut Lines, to: To<'_, Bf16>) {
        if let Some(from) = T::halves(from) {
            return to.place(from, channels.count);
        }
        let row = row.numbers(from.len());
        for (to, from) in row.iter_mut().zip(from) {
            *to = Bf16::from_f32(from.to_f32());
        }
        to.place(row, channels.count);
    }
}

/// Bytes: value · factor of its channel, rounded, 0…255.
#[derive(Debug, Clone, Copy)]
pub struct Bytes<'a>(pub &'a [f32]);

impl Pack for Bytes<'_> {
    type Number = u8;

    #[inline(always)]
    fn pack<T: Element>(self, channels: Channels, from: &[T], _: &mut Lines, to: To<'_, u8>) {
        let Channels { first, count } = channels;
        let factors = &self.0[first..first + count];
        for (to, from) in to.numbers.chunks_mut(to.stride).zip(from.chunks_exact(count)) {
            for ((to, from), factor) in to[..count].iter_mut().zip(from).zip(factors) {
                *to = rounded(from.to_f32() * factor);
            }
        }
    }
}

/// The nearest byte. Next to 2²³ an f32 has no fraction, so its last bits are the whole number: unlike a cast, which
/// minds numbers that are none, this becomes vectors.
#[inline(always)]
fn rounded(value: f32) -> u8 {
    (value.clamp(0.0, 255.0) + 8_388_608.0).to_bits() as u8
}
