//! From Fortran order, where the first axis is the fastest, to C order.

use fovol_core::stop;

/// Side of the tiles in which axes are swapped: rows of both arrays stay in the cache.
const TILE: usize = 32;

/// Copies an array of `shape` from Fortran order, `from`, to C order, `to`. Values have `size` bytes each.
///
/// # Panics
/// If either buffer has another length than `shape` and `size` say.
pub fn to_c_order(shape: &[usize], size: usize, from: &[u8], to: &mut [u8]) {
    let [first, middle @ .., last] = shape else {
        to.copy_from_slice(from);
        return;
    };
    let between: usize = middle.iter().product();
    assert_eq!(from.len(), to.len(), "both orders have the same values");
    assert_eq!(to.len(), first * between * last * size, "the shape is that of the values");
    for in_c in 0..between {
        stop::point();
        let in_fortran = reversed(middle, in_c);
        for tile in Tiles::new(*first, *last) {
            for i in tile.rows.clone() {
                for k in tile.columns.clone() {
                    let source = ((k * between + in_fortran) * first + i) * size;
                    let target = ((i * between + in_c) * last + k) * size;
                    to[target..target + size].copy_from_slice(&from[source..source + size]);
                }
            }
        }
    }
}

/// Position in Fortran order of the element at `index` in C order.
fn reversed(shape: &[usize], mut index: usize) -> usize {
    let mut strides = Vec::with_capacity(shape.len());
    let mut stride = 1;
    for length in shape {
        strides.push(stride);
        stride *= length;
    }
    let mut position = 0;
    for (length, stride) in shape.iter().zip(strides).rev() {
        position += index % length * stride;
        index /= length;
    }
    position
}

/// A rectangle of a table.
struct Tile {
    rows: std::ops::Range<usize>,
    columns: std::ops::Range<usize>,
}

/// All tiles of a table.
struct Tiles {
    rows: usize,
    columns: usize,
    next: [usize; 2],
}

impl Tiles {
    fn new(rows: usize, columns: usize) -> Self {
        Self { rows, columns, next: [0, 0] }
    }
}

impl Iterator for Tiles {
    type Item = Tile;

    fn next(&mut self) -> Option<Tile> {
        let [row, column] = self.next;
        if row >= self.rows || column >= self.columns {
            return None;
        }
        self.next = if column + TILE < self.columns { [row, column + TILE] } else { [row + TILE, 0] };
        Some(Tile { rows: row..self.rows.min(row + TILE), columns: column..self.columns.min(column + TILE) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_finds_its_value() {
        for shape in [&[5][..], &[3, 4], &[40, 2, 33], &[2, 3, 4, 5], &[2, 3, 1, 2, 3]] {
            let count: usize = shape.iter().product();
            let from: Vec<u8> = (0..count as u16).flat_map(u16::to_le_bytes).collect();
            let mut to = vec![0; from.len()];
            to_c_order(shape, 2, &from, &mut to);
            for index in 0..count {
                let value = u16::from_le_bytes([to[2 * index], to[2 * index + 1]]);
                assert_eq!(usize::from(value), reversed(shape, index), "{shape:?} {index}");
            }
        }
    }
}
