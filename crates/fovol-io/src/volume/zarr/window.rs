//! A part of an array, and where its values go in memory.

use std::ops::Range;

/// A box of an array, or of a chunk of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// The part along each axis, not empty.
    pub ranges: Vec<Range<usize>>,
    /// Bytes in memory from one index of an axis to the next.
    pub strides: Vec<usize>,
    /// Where the first value goes, in bytes.
    pub base: usize,
}

impl Window {
    /// All `count` values of `size` bytes of an array of one axis.
    pub fn row(count: usize, size: usize) -> Self {
        Self { ranges: std::iter::once(0..count).collect(), strides: vec![size], base: 0 }
    }

    /// The window with its axes in another order: axis i was `order[i]`.
    pub fn permuted(&self, order: &[usize]) -> Self {
        Self {
            ranges: order.iter().map(|&axis| self.ranges[axis].clone()).collect(),
            strides: order.iter().map(|&axis| self.strides[axis]).collect(),
            base: self.base,
        }
    }

    /// The chunks of shape `chunk` that it touches.
    pub fn chunks(&self, chunk: &[usize]) -> Chunks {
        let touched =
            |(range, &length): (&Range<usize>, &usize)| range.start / length..(range.end - 1) / length + 1;
        Chunks { ranges: self.ranges.iter().zip(chunk).map(touched).collect() }
    }

    /// The part of it in the chunk at `coordinates`, of shape `chunk`, counted from the start of that.
    pub fn within(&self, coordinates: &[usize], chunk: &[usize]) -> Self {
        let mut base = self.base;
        let mut ranges = Vec::with_capacity(self.ranges.len());
        for (axis, range) in self.ranges.iter().enumerate() {
            let origin = coordinates[axis] * chunk[axis];
            let from = range.start.max(origin);
            let to = range.end.min(origin.saturating_add(chunk[axis]));
            base += (from - range.start) * self.strides[axis];
            ranges.push(from - origin..to - origin);
        }
        Self { ranges, strides: self.strides.clone(), base }
    }
}

/// Chunks of a grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunks {
    ranges: Vec<Range<usize>>,
}

impl Chunks {
    /// Their number; saturates.
    pub fn count(&self) -> usize {
        self.ranges.iter().fold(1, |count, range| count.saturating_mul(range.len()))
    }

    /// The coordinates of the chunk `index`, in C order.
    pub fn coordinates(&self, mut index: usize) -> Vec<usize> {
        let mut coordinates = vec![0; self.ranges.len()];
        for (place, range) in coordinates.iter_mut().zip(&self.ranges).rev() {
            *place = range.start + index % range.len();
            index /= range.len();
        }
        coordinates
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_a_window_once() {
        let window = Window { ranges: vec![1..6, 3..4, 0..7], strides: vec![14, 0, 2], base: 5 };
        let (chunk, mut seen) = ([2, 5, 3], vec![0; 5 * 14 + 5]);
        let chunks = window.chunks(&chunk);
        assert_eq!(chunks.count(), 3 * 3);
        for index in 0..chunks.count() {
            let part = window.within(&chunks.coordinates(index), &chunk);
            for z in 0..part.ranges[0].len() {
                for x in 0..part.ranges[2].len() {
                    seen[part.base + 14 * z + 2 * x] += 1;
                }
            }
        }
        let written = |at: &usize| *at >= 5 && (at - 5).is_multiple_of(2) && (at - 5) % 14 / 2 < 7;
        assert!((0..seen.len()).all(|at| seen[at] == usize::from(written(&at))), "{seen:?}");
    }
}
