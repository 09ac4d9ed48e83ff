//! Arrays of values: packed, and without the inactive ones where a few numbers replace them.

use super::cursor::Cursor;
use super::kind::{Kind, Store};
use crate::volume::active_box::{is_on, on_bits};
use crate::volume::blosc;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// How the arrays of a grid are packed.
#[derive(Debug, Clone, Copy)]
pub struct Packing(pub u32);

impl Packing {
    const ZLIB: u32 = 1;
    const ACTIVE_MASK: u32 = 2;
    const BLOSC: u32 = 4;

    fn has(self, flag: u32) -> bool {
        self.0 & flag != 0
    }
}

/// Numbers that say how inactive values are stored.
mod inactive {
    pub const BACKGROUND: u8 = 0;
    pub const ONE: u8 = 2;
    pub const MASK_OF_SIGNS: u8 = 3;
    pub const MASK_AND_ONE: u8 = 4;
    pub const MASK_AND_TWO: u8 = 5;
    pub const ALL_THERE: u8 = 6;
}

/// Why an array cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Problem {
    /// The file is cut short or changed.
    Damaged,
    /// A codec of Blosc that is not read.
    Codec(&'static str),
}

/// The arrays of a grid.
#[derive(Debug)]
pub struct Arrays<'a> {
    pub kind: &'a Kind,
    pub packing: Packing,
    /// The value of all that is not stored.
    pub background: Vec<u8>,
}

impl Arrays<'_> {
    /// Reads the `count` values at `cursor`, those of `mask` active.
    ///
    /// # Errors
    /// Damage, codecs that are not read.
    pub fn read(&self, cursor: &mut Cursor<'_>, count: usize, mask: &[u8]) -> Result<Vec<u8>, Problem> {
        let size = self.kind.size();
        let form = cursor.u8().ok_or(Problem::Damaged)?;
        let [off, other] = self.inactive(cursor, form).ok_or(Problem::Damaged)?;
        let choice = match form {
            inactive::MASK_OF_SIGNS | inactive::MASK_AND_ONE | inactive::MASK_AND_TWO => {
                cursor.take(mask.len()).ok_or(Problem::Damaged)?
            }
            _ => &[],
        };
        let is_full = !self.packing.has(Packing::ACTIVE_MASK) || form == inactive::ALL_THERE;
        let active = if is_full { count } else { on_bits(mask).count() };
        // OpenVDB writes not even a length for no halves.
        let stored = match self.kind.store {
            Store::Half if active == 0 => Vec::new(),
            _ => self.unpacked(cursor, active * size)?,
        };
        if active == count {
            return Ok(stored);
        }
        let mut out = Vec::with_capacity(count * size);
        let mut active = stored.chunks_exact(size);
        for index in 0..count {
            let value = match () {
                () if is_on(mask, index) => active.next().ok_or(Problem::Damaged)?,
                () if is_on(choice, index) => &other,
                () => &off,
            };
            out.extend_from_slice(value);
        }
        Ok(out)
    }

    /// The two values that inactive ones may have.
    fn inactive(&self, cursor: &mut Cursor<'_>, form: u8) -> Option<[Vec<u8>; 2]> {
        let mut alone = || Some(self.kind.stored(cursor.take(self.kind.full_size())?));
        let background = || self.background.clone();
        Some(match form {
            inactive::BACKGROUND => [background(), background()],
            inactive::ONE | inactive::MASK_AND_ONE => [alone()?, background()],
            inactive::MASK_AND_TWO => [alone()?, alone()?],
            _ => [self.kind.negated(&self.background), background()],
        })
    }

    /// The `length` bytes that are packed at `cursor`.
    fn unpacked(&self, cursor: &mut Cursor<'_>, length: usize) -> Result<Vec<u8>, Problem> {
        if !self.packing.has(Packing::ZLIB | Packing::BLOSC) {
            return cursor.take(length).map(<[u8]>::to_vec).ok_or(Problem::Damaged);
        }
        let packed = cursor.i64().ok_or(Problem::Damaged)?;
        let bytes = usize::try_from(packed.unsigned_abs()).ok().and_then(|count| cursor.take(count));
        let bytes = bytes.ok_or(Problem::Damaged)?;
        let out = match () {
            // What does not shrink is stored, with its length negated.
            () if packed <= 0 => bytes.to_vec(),
            () if self.packing.has(Packing::BLOSC) => {
                blosc::unpacked(bytes, length).map_err(|problem| match problem {
                    blosc::Problem::Damaged => Problem::Damaged,
                    blosc::Problem::Codec(name) => Problem::Codec(name),
                })?
            }
            () => {
                let mut out = Vec::new();
                let mut reader = ZlibDecoder::new(bytes).take(length as u64 + 1);
                reader.read_to_end(&mut out).map_err(|_| Problem::Damaged)?;
                out
            }
        };
        if out.len() == length { Ok(out) } else { Err(Problem::Damaged) }
    }
}
