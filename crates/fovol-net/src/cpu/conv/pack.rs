//! Packs tensor elements into the formats that convolution kernels multiply.
//!
//! Loops go over whole rows where possible, since the compiler vectorises only those.

use crate::cpu::tensor::element::Element;
use bytemuck::Pod;
use fovol_simd::AlignedBuf;
use std::marker::PhantomData;

/// Number of elements that are copied at once.
const LANES: usize = 16;

/// Converts stored elements to the elements that kernels multiply.
pub trait Pack: Copy {
    /// Element type of the kernel.
    type Number: Pod + Default;

    /// Packs the pixels `from`, which have `channels`, and writes them to `to`. `row` is scratch memory.
    fn pack<T: Element>(self, channels: Channels, from: &[T], row: &mut AlignedBuf, to: To<'_, Self::Number>);

    /// Packs 2×2 pixels, folded into one. `rows` are the upper and the lower pixels; `channels` counts those of the
    /// two upper pixels and then of the two lower ones.
    #[inline(always)]
    fn pack_squares<T: Element>(
        self,
        channels: Channels,
        rows: [&[T]; 2],
        row: &mut AlignedBuf,
        to: To<'_, Self::Number>,
    ) {
        pack_rows(self, channels, rows, row, to);
    }
}

/// Implements [`Pack::pack_squares`] one row after the other.
#[inline(always)]
fn pack_rows<P: Pack, T: Element>(
    pack: P,
    Channels { first, count }: Channels,
    rows: [&[T]; 2],
    row: &mut AlignedBuf,
    To { numbers, stride }: To<'_, P::Number>,
) {
    let count = count / 2;
    for (below, from) in rows.into_iter().enumerate() {
        let channels = Channels { first: first + below * count, count };
        pack.pack(channels, from, row, To { numbers: &mut numbers[below * count..], stride });
    }
}

/// Range of channels of a source.
#[derive(Debug, Clone, Copy)]
pub struct Channels {
    /// First channel, counted over all sources.
    pub first: usize,
    /// Number of channels.
    pub count: usize,
}

/// Destination of packed elements.
pub struct To<'a, N> {
    /// Elements from the first channel of the first pixel on.
    pub numbers: &'a mut [N],
    /// Distance between pixels.
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
        // For few channels a copy of constant length is faster than a loop.
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

    /// Writes pixels of `COUNT` channels.
    #[inline(always)]
    fn place_each<const COUNT: usize>(self, pixels: &[N]) {
        for (to, from) in self.numbers.chunks_mut(self.stride).zip(pixels.as_chunks::<COUNT>().0) {
            if let Some(to) = to.first_chunk_mut() {
                *to = *from;
            }
        }
    }
}

/// Packing as floats of type `N`.
#[derive(Debug)]
pub struct Floats<N>(PhantomData<N>);

impl<N> Default for Floats<N> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<N> Clone for Floats<N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<N> Copy for Floats<N> {}

impl<N: Element> Pack for Floats<N> {
    type Number = N;

    #[inline(always)]
    fn pack<T: Element>(self, channels: Channels, from: &[T], row: &mut AlignedBuf, to: To<'_, N>) {
        if let Some(from) = T::as_stored(from) {
            return to.place(from, channels.count);
        }
        let row = row.numbers(from.len());
        for (to, from) in row.iter_mut().zip(from) {
            *to = N::from_f32(from.to_f32());
        }
        to.place(row, channels.count);
    }

    #[inline(always)]
    fn pack_squares<T: Element>(
        self,
        channels: Channels,
        rows: [&[T]; 2],
        row: &mut AlignedBuf,
        to: To<'_, N>,
    ) {
        match rows.map(T::as_stored) {
            [Some(above), Some(below)] if channels.count == 2 * SIX => {
                pack_coloured_squares(channels.first, [above, below], to);
            }
            _ => pack_rows(self, channels, rows, row, to),
        }
    }
}

/// Number of elements of two pixels of three channels.
const SIX: usize = 6;
/// Number of elements of a row that are read at once for two pixels.
const EIGHT: usize = 8;

/// Packs 2×2 pixels of three channels, folded into one, with `first` as their first channel.
#[inline(always)]
fn pack_coloured_squares<N: Element>(
    first: usize,
    [above, below]: [&[f32]; 2],
    To { numbers, stride }: To<'_, N>,
) {
    let room = stride - first;
    let squares = above.len() / SIX;
    // Reads and writes may exceed a square. The excess belongs to later sources, which overwrite it.
    let whole = if room < LANES { 0 } else { squares.saturating_sub(1) };
    let mut places = numbers.chunks_mut(stride);
    for (x, place) in places.by_ref().take(whole).enumerate() {
        let rows = [above, below].map(|row| row[SIX * x..].first_chunk::<EIGHT>());
        if let ([Some(above), Some(below)], Some(place)) = (rows, place.first_chunk_mut::<LANES>()) {
            let mut square = [0.0f32; LANES];
            square[..EIGHT].copy_from_slice(above);
            square[SIX..SIX + EIGHT].copy_from_slice(below);
            for (to, from) in place.iter_mut().zip(square) {
                *to = N::from_f32(from);
            }
        }
    }
    for (x, place) in (whole..squares).zip(places) {
        for (to, from) in place.iter_mut().zip(above[SIX * x..][..SIX].iter().chain(&below[SIX * x..][..SIX]))
        {
            *to = N::from_f32(*from);
        }
    }
}

/// Packing as bytes: value · factor of its channel, rounded and clamped to 0…255.
#[derive(Debug, Clone, Copy)]
pub struct Bytes<'a>(pub &'a [f32]);

impl Pack for Bytes<'_> {
    type Number = u8;

    #[inline(always)]
    fn pack<T: Element>(self, channels: Channels, from: &[T], _: &mut AlignedBuf, to: To<'_, u8>) {
        let Channels { first, count } = channels;
        let factors = &self.0[first..first + count];
        for (to, from) in to.numbers.chunks_mut(to.stride).zip(from.chunks_exact(count)) {
            for ((to, from), factor) in to[..count].iter_mut().zip(from).zip(factors) {
                *to = rounded(from.to_f32() * factor);
            }
        }
    }
}

/// Rounds to the nearest byte. Near 2²³ an f32 has no fraction, so its low bits are the integer. Unlike a cast,
/// which has to treat NaN, the compiler vectorises this.
#[inline(always)]
fn rounded(value: f32) -> u8 {
    (value.clamp(0.0, 255.0) + 8_388_608.0).to_bits() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_simd::Bf16;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn squares_are_packed_at_once_as_row_by_row(
            squares in 1usize..20,
            first in 0usize..20,
            more in 0usize..20,
            seed in prop::collection::vec(-1f32..1.0, 240),
        ) {
            let (channels, stride) = (Channels { first, count: 2 * SIX }, first + 2 * SIX + more);
            let rows = [&seed[..SIX * squares], &seed[120..][..SIX * squares]];
            let mut packed = [(); 2].map(|()| vec![Bf16::default(); squares * stride + first]);
            let [at_once, by_row] = &mut packed;
            let row = &mut AlignedBuf::default();
            Floats::default().pack_squares(channels, rows, row, To { numbers: &mut at_once[first..], stride });
            pack_rows(Floats::default(), channels, rows, row, To { numbers: &mut by_row[first..], stride });
            for square in 0..squares {
                let at = square * stride + first;
                prop_assert_eq!(&at_once[at..at + 2 * SIX], &by_row[at..at + 2 * SIX]);
                // Channels of earlier sources in the next square are unchanged.
                let next = &at_once[(square + 1) * stride..][..first];
                prop_assert!(next.iter().all(|v| *v == Bf16::default()));
            }
        }
    }
}
