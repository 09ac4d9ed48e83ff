//! Views of rows of images, for reading.

use crate::cpu::tensor::{AnyTensor, Tensor};
use bytemuck::{Pod, cast_slice};
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
            $crate::cpu::tensor::rows::View::F32($rows) => $body,
            $crate::cpu::tensor::rows::View::Bf16($rows) => $body,
        }
    };
}
pub(crate) use with_rows;

impl<'a> View<'a> {
    /// Words of row `y`.
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
        fn all<T: Pod>(map: &Tensor<T>) -> Rows<'_, T> {
            Rows::new([&map.data, &[], &[]], 0, [map.height, map.width, map.channels])
        }
        match stored {
            AnyTensor::F32(map) => Self::F32(all(map)),
            AnyTensor::Bf16(map) => Self::Bf16(all(map)),
        }
    }
}
