//! Unpacking of one chunk.

use super::Chain;

/// Buffers of one thread, used again for every chunk.
#[derive(Default)]
pub struct Scratch {
    a: Vec<u8>,
    b: Vec<u8>,
}

/// Where the bytes of a chunk are.
#[derive(Clone, Copy)]
enum Place {
    Packed,
    A,
    B,
}

/// More bytes than a chunk has that compressions may add between them.
const MOST_ADDED: usize = 1 << 16;

impl Chain {
    /// The `length` bytes that were packed to `packed`, in place or in `scratch`.
    ///
    /// # Errors
    /// What is wrong with `packed`.
    pub fn decode<'a>(
        &self,
        packed: &'a [u8],
        length: usize,
        scratch: &'a mut Scratch,
    ) -> Result<&'a [u8], String> {
        // Filters change the length in a known way, compressions do not.
        let stored = self.filters.iter().fold(length, |length, filter| filter.stored_length(length));
        let mut place = self.decompress(packed, stored, scratch)?;
        if self.is_turned {
            let (bytes, out, next) = scratch.step(place, packed);
            turn(bytes, out, stored / self.values(length).max(1));
            place = next;
        }
        for filter in self.filters.iter().rev() {
            let (bytes, out, next) = scratch.step(place, packed);
            filter.decode(bytes, out)?;
            place = next;
        }
        let bytes = scratch.at(place, packed);
        match bytes.len() == length {
            true => Ok(bytes),
            false => Err(format!("it has {} bytes, not {length}", bytes.len())),
        }
    }

    /// The bytes that were packed to `packed`, of any length.
    ///
    /// # Errors
    /// What is wrong with `packed`.
    pub fn unpacked<'a>(&self, packed: &'a [u8], scratch: &'a mut Scratch) -> Result<&'a [u8], String> {
        let place = self.decompress(packed, usize::MAX, scratch)?;
        Ok(scratch.at(place, packed))
    }

    /// Whether chunks are stored as they are, without filters and compressions.
    pub fn is_plain(&self) -> bool {
        self.filters.is_empty() && self.compressions.is_empty()
    }

    /// Undoes all compressions, and returns where the bytes are then: `most` at the most.
    fn decompress(&self, packed: &[u8], most: usize, scratch: &mut Scratch) -> Result<Place, String> {
        let mut place = Place::Packed;
        for (number, compression) in self.compressions.iter().enumerate().rev() {
            let most = if number == 0 { most } else { most.saturating_mul(2).saturating_add(MOST_ADDED) };
            let (bytes, out, next) = scratch.step(place, packed);
            compression.decode(bytes, out, most)?;
            place = next;
        }
        Ok(place)
    }

    /// Values in `length` decoded bytes, by the first filter.
    fn values(&self, length: usize) -> usize {
        self.filters.first().map_or(length, |filter| filter.values(length))
    }
}

impl Scratch {
    /// The bytes at `place`.
    fn at<'a>(&'a self, place: Place, packed: &'a [u8]) -> &'a [u8] {
        match place {
            Place::Packed => packed,
            Place::A => &self.a,
            Place::B => &self.b,
        }
    }

    /// The bytes at `place`, a buffer that they are not in, and the place of that.
    fn step<'a>(&'a mut self, place: Place, packed: &'a [u8]) -> (&'a [u8], &'a mut Vec<u8>, Place) {
        match place {
            Place::Packed => (packed, &mut self.a, Place::A),
            Place::A => (&self.a, &mut self.b, Place::B),
            Place::B => (&self.b, &mut self.a, Place::A),
        }
    }
}

/// Replaces `out` by `bytes` in the other byte order of values of `size` bytes.
fn turn(bytes: &[u8], out: &mut Vec<u8>, size: usize) {
    out.clear();
    bytes.chunks(size.max(1)).for_each(|value| out.extend(value.iter().rev()));
}
