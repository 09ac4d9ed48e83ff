//! The order of bytes or bits in a block.

/// How the bytes of a block were put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shuffle {
    /// Unchanged.
    None,
    /// First bytes of all values first.
    Bytes,
    /// First bits of all values first.
    Bits,
}

impl Shuffle {
    /// The shuffle that the `flags` of a chunk name.
    pub fn of(flags: u8) -> Self {
        match flags {
            _ if flags & 1 != 0 => Self::Bytes,
            _ if flags & 4 != 0 => Self::Bits,
            _ => Self::None,
        }
    }

    /// Appends the values of `size` bytes, shuffled in `block`, to `out`. Bytes behind the last whole value stay.
    pub fn undo(self, size: usize, block: &[u8], out: &mut Vec<u8>) {
        let start = out.len();
        out.extend_from_slice(block);
        let out = &mut out[start..];
        match (self, size) {
            (Self::Bytes, 2) => bytes::<2>(block, out),
            (Self::Bytes, 4) => bytes::<4>(block, out),
            (Self::Bytes, 8) => bytes::<8>(block, out),
            (Self::Bytes, 2..) => {
                let count = block.len() / size;
                for (byte, plane) in block.chunks_exact(count.max(1)).take(size).enumerate() {
                    out.chunks_exact_mut(size).zip(plane).for_each(|(value, &part)| value[byte] = part);
                }
            }
            (Self::Bits, 1..) => bits(size, block, out),
            _ => {}
        }
    }
}

/// Puts the bytes of values of `N` bytes together.
fn bytes<const N: usize>(block: &[u8], out: &mut [u8]) {
    let values = out.as_chunks_mut::<N>().0;
    let count = values.len();
    for (index, value) in values.iter_mut().enumerate() {
        *value = std::array::from_fn(|byte| block[byte * count + index]);
    }
}

/// Puts the bits of values of `size` bytes together. Blosc shuffles the bits of eight values at a time, or none.
fn bits(size: usize, block: &[u8], out: &mut [u8]) {
    let count = block.len() / size;
    if !count.is_multiple_of(8) {
        return;
    }
    let row = count / 8;
    for (index, value) in out.chunks_exact_mut(size).enumerate() {
        let (at, shift) = (index / 8, index % 8);
        for (byte, part) in value.iter_mut().enumerate() {
            *part =
                (0..8).fold(0, |bits, bit| bits | (block[(8 * byte + bit) * row + at] >> shift & 1) << bit);
        }
    }
}
