use super::element::Element;
use super::rows::Rows;

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
