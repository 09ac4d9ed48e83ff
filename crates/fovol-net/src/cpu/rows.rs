//! Views of rows of images, for reading.

use super::element::Element;
use super::tensor::{AnyTensor, Tensor};
use bytemuck::cast_slice;
use fovol_simd::{Bf16, WORDS_OF_LINE, prefetch};
use std::ops::Range;

/// Rows of an image, in up to three pieces of memory. Some rows may be absent.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a, T> {
    /// Pieces of whole rows, from row `first` on.
    pieces: [&'a [T]; 3],
    /// Number of the first row in the pieces.
    first: usize,
    /// Rows, columns and channels of the whole image.
    size: [usize; 3],
}

impl<'a, T> Rows<'a, T> {
    /// Makes a view of `pieces`, which hold whole rows from row `first` on. `size` is rows, columns and channels of
    /// the whole image.
    pub fn new(pieces: [&'a [T]; 3], first: usize, size: [usize; 3]) -> Self {
        Self { pieces, first, size }
    }

    /// Rows, columns and channels of the whole image.
    #[inline(always)]
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Elements of row `y`.
    ///
    /// # Panics
    /// Where row `y` is absent.
    #[inline(always)]
    pub fn row(&self, y: usize) -> &'a [T] {
        let length = self.size[1] * self.size[2];
        let mut at = (y - self.first) * length;
        let mut piece = self.pieces[0];
        for next in [self.pieces[1], self.pieces[2]] {
            if at >= piece.len() {
                (at, piece) = (at - piece.len(), next);
            } else {
                break;
            }
        }
        &piece[at..at + length]
    }

    /// Prefetches the elements `columns` of the row after row `y`, if it follows in memory.
    #[inline(always)]
    pub fn prefetch_after(&self, y: usize, columns: Range<usize>) {
        let length = self.size[1] * self.size[2];
        prefetch_all(self.row(y), columns.start + length..columns.end + length);
    }

    /// Prefetches the elements `columns` of the two rows after rows `y` and `y` + 1, if they follow in memory.
    #[inline(always)]
    pub fn prefetch_after_pair(&self, y: usize, columns: Range<usize>) {
        let length = self.size[1] * self.size[2];
        for below in [0, 1] {
            prefetch_all(self.row(y + below), columns.start + 2 * length..columns.end + 2 * length);
        }
    }
}

/// Prefetches the elements `range`, counted from the beginning of `row` and possibly beyond its end.
#[inline(always)]
fn prefetch_all<T>(row: &[T], range: Range<usize>) {
    let line = size_of::<u32>() * WORDS_OF_LINE / size_of::<T>();
    range.step_by(line).for_each(|at| prefetch(row, at));
}

/// Rows of an image with their element type.
#[derive(Debug, Clone, Copy)]
pub enum View<'a> {
    F32(Rows<'a, f32>),
    Bf16(Rows<'a, Bf16>),
}

/// Calls `$body` with `$rows` bound to the rows in `$view`, for any element type.
macro_rules! with_rows {
    ($view:expr, $rows:ident => $body:expr) => {
        match $view {
            $crate::cpu::rows::View::F32($rows) => $body,
            $crate::cpu::rows::View::Bf16($rows) => $body,
        }
    };
}
pub(crate) use with_rows;

impl<'a> View<'a> {
    /// PageBuf of row `y`.
    ///
    /// # Panics
    /// Where row `y` is absent, or does not begin and end at a word boundary.
    #[inline(always)]
    pub fn words(&self, y: usize) -> &'a [u32] {
        with_rows!(self, rows => cast_slice(rows.row(y)))
    }

    /// Rows, columns and channels of the whole image.
    #[inline(always)]
    pub fn size(&self) -> [usize; 3] {
        with_rows!(self, rows => rows.size())
    }
}

impl<'a> From<&'a AnyTensor> for View<'a> {
    fn from(stored: &'a AnyTensor) -> Self {
        fn all<T: Element>(map: &Tensor<T>) -> Rows<'_, T> {
            Rows::new([&map.data, &[], &[]], 0, [map.height, map.width, map.channels])
        }
        match stored {
            AnyTensor::F32(map) => Self::F32(all(map)),
            AnyTensor::Bf16(map) => Self::Bf16(all(map)),
        }
    }
}

/// Ring buffer of the last rows of an image that is computed from top to bottom.
pub struct Ring<'a, T: Element> {
    numbers: &'a mut [T],
    /// Number of rows in the buffer.
    room: usize,
    /// Offset of row numbers: row y has index (y + shift) mod room.
    shift: usize,
    /// First computed row, and end of the computed rows.
    made: [usize; 2],
    size: [usize; 3],
}

impl<'a, T: Element> Ring<'a, T> {
    /// Makes an empty ring in `numbers`, which has room for whole rows, for an image of `size`. Computation begins
    /// at row `first`. Rows from `aligned` on are contiguous as far as there is room.
    pub fn new(numbers: &'a mut [T], [first, aligned]: [usize; 2], size: [usize; 3]) -> Self {
        let room = numbers.len() / (size[1] * size[2]);
        Self { numbers, room, shift: room - aligned % room, made: [first; 2], size }
    }

    /// Computes rows up to `end`. `make` gets the first of several contiguous rows, and their memory.
    pub fn make(&mut self, end: usize, mut make: impl FnMut(usize, &mut [T])) {
        let row = self.size[1] * self.size[2];
        while self.made[1] < end {
            let place = (self.made[1] + self.shift) % self.room;
            let count = (end - self.made[1]).min(self.room - place);
            make(self.made[1], &mut self.numbers[place * row..(place + count) * row]);
            self.made[1] += count;
        }
    }

    /// Rows that are still in the buffer.
    pub fn rows(&self) -> Rows<'_, T> {
        let row = self.size[1] * self.size[2];
        let first = self.made[1].saturating_sub(self.room).max(self.made[0]);
        let (place, count) = ((first + self.shift) % self.room, self.made[1] - first);
        let before = count.min(self.room - place);
        let pieces = [
            &self.numbers[place * row..(place + before) * row],
            &self.numbers[..(count - before) * row],
            &[],
        ];
        Rows::new(pieces, first, self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_have_the_last_rows_and_pieces_are_read_in_turn() {
        let size = [20, 3, 2];
        let mut numbers = vec![0.0f32; 8 * 6];
        let mut ring = Ring::new(&mut numbers, [2, 6], size);
        for (end, first) in [(10, 2), (14, 6), (18, 10), (20, 12)] {
            let mut begun = Vec::new();
            ring.make(end, |y, out| {
                begun.push((y, out.len() / 6));
                out.chunks_exact_mut(6).enumerate().for_each(|(i, row)| row.fill((y + i) as f32));
            });
            assert!(begun.len() <= 2, "{begun:?}");
            let rows = ring.rows();
            for y in first..end {
                assert_eq!(rows.row(y), [y as f32; 6], "{y} of {first}..{end}");
            }
        }
    }
}
