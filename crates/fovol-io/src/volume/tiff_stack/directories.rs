//! Validates the directories of a TIFF file before the decoder reads it.
//!
//! The decoder allocates memory for a tag before it checks the file's length. Our limits apply only after it has read
//! the first directory.

use crate::Result;
use crate::volume::Source;
use fovol_core::Endian;

/// Checks that no tag is longer than the file. Broken links are left to the decoder.
///
/// # Errors
/// A tag that is longer than the file.
pub fn check(source: &Source) -> Result<()> {
    let bytes = source.bytes();
    let Some(reader) = Reader::new(bytes) else { return Ok(()) };
    let mut next = reader.first();
    // Damaged files can chain their directories in a ring: no more are followed than fit.
    for _ in 0..bytes.len() / 6 {
        let Some(at) = next.filter(|&at| at != 0) else { break };
        let Some(count) = reader.entry_count(at) else { break };
        for number in 0..count {
            let Some([tag, length]) = reader.entry(at, number) else { return Ok(()) };
            if length > bytes.len() {
                return Err(source.malformed(format!(
                    "its tag {tag} claims {length} bytes, more than the file has; copy or download it again"
                )));
            }
        }
        next = reader.next(at, count);
    }
    Ok(())
}

/// The tag that marks a page as a smaller version of another.
const SUBFILE: usize = 254;

/// The tag of the interpretation of grey values, and its numbers for dark and bright zeros.
const INTERPRETATION: usize = 262;
const WHITE_IS_ZERO: f64 = 0.0;
const BLACK_IS_ZERO: u8 = 1;

/// Relabels pages of `source` from WhiteIsZero to BlackIsZero; also returns whether there were any.
///
/// Decoders would invert such pages, but scans are shown by their stored values.
pub fn as_stored(source: &Source) -> (Source, bool) {
    let places = Reader::new(source.bytes()).map(|reader| reader.white_zeros()).unwrap_or_default();
    if places.is_empty() {
        return (source.clone(), false);
    }
    let mut bytes = source.bytes().to_vec();
    for place in places {
        bytes[place] = BLACK_IS_ZERO;
    }
    (Source::from_bytes(source.path(), bytes), true)
}

/// Numbers of a TIFF or BigTIFF file in its byte order.
pub struct Reader<'a> {
    bytes: &'a [u8],
    is_little: bool,
    is_big_tiff: bool,
}

impl<'a> Reader<'a> {
    /// Reads `bytes`; none if they are too short to tell TIFF from BigTIFF.
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let is_little = bytes.starts_with(b"II");
        let mut reader = Self { bytes, is_little, is_big_tiff: false };
        reader.is_big_tiff = reader.number(2, 2)? == 43;
        Some(reader)
    }

    /// The unsigned number of `size` bytes at `at`.
    fn number(&self, at: usize, size: usize) -> Option<usize> {
        let digits = self.bytes.get(at..at.checked_add(size)?)?;
        let append = |value: usize, &digit: &u8| value << 8 | usize::from(digit);
        Some(match self.is_little {
            true => digits.iter().rev().fold(0, append),
            false => digits.iter().fold(0, append),
        })
    }

    /// Bytes of an offset or a count.
    fn word(&self) -> usize {
        if self.is_big_tiff { 8 } else { 4 }
    }

    /// Bytes of the number of entries of a directory, and of one entry.
    fn sizes(&self) -> (usize, usize) {
        if self.is_big_tiff { (8, 20) } else { (2, 12) }
    }

    fn first(&self) -> Option<usize> {
        self.number(if self.is_big_tiff { 8 } else { 4 }, self.word())
    }

    fn entry_count(&self, directory: usize) -> Option<usize> {
        self.number(directory, self.sizes().0)
    }

    /// Where entry `number` of a directory begins; the one past the last is the next directory's place.
    fn place(&self, directory: usize, number: usize) -> Option<usize> {
        let (before, each) = self.sizes();
        number.checked_mul(each)?.checked_add(before)?.checked_add(directory)
    }

    /// The tag of an entry and the bytes that its values take.
    fn entry(&self, directory: usize, number: usize) -> Option<[usize; 2]> {
        let at = self.place(directory, number)?;
        let [tag, kind] = [self.number(at, 2)?, self.number(at + 2, 2)?];
        let count = self.number(at + 4, self.word())?;
        Some([tag, count.saturating_mul(size_of_type(kind))])
    }

    fn next(&self, directory: usize, count: usize) -> Option<usize> {
        self.number(self.place(directory, count)?, self.word())
    }

    /// Where the directories begin, one after another; no more than fit into the file.
    fn directories(&self) -> Vec<usize> {
        let mut found = Vec::new();
        let mut next = self.first();
        while let Some(at) = next.filter(|&at| at != 0 && found.len() < self.bytes.len() / 6) {
            let Some(count) = self.entry_count(at) else { break };
            found.push(at);
            next = self.next(at, count);
        }
        found
    }

    /// Where the directories of pages that are no previews begin.
    pub fn pages(&self) -> Vec<usize> {
        let is_preview = |&at: &usize| self.value(at, SUBFILE).is_some_and(|kind| kind as u64 & 1 == 1);
        self.directories().into_iter().filter(|at| !is_preview(at)).collect()
    }

    /// The low bytes of all interpretations whose zeros are white.
    fn white_zeros(&self) -> Vec<usize> {
        let low_byte = |at: usize| {
            let values = self.values(at, INTERPRETATION)?;
            let is_white = values.kind == 3 && self.value(at, INTERPRETATION) == Some(WHITE_IS_ZERO);
            is_white.then_some(if self.is_little { values.at } else { values.at + 1 })
        };
        self.directories().into_iter().filter_map(low_byte).collect()
    }

    /// Offset, type and number of the values of `tag`; none if the directory lacks it or they lie outside the file.
    pub fn values(&self, directory: usize, tag: usize) -> Option<Values> {
        let count = self.entry_count(directory)?;
        let number = (0..count.min(self.bytes.len() / 12))
            .find(|&number| self.place(directory, number).and_then(|at| self.number(at, 2)) == Some(tag))?;
        let at = self.place(directory, number)?;
        let (kind, count) = (self.number(at + 2, 2)?, self.number(at + 4, self.word())?);
        let inline = at + 4 + self.word();
        let length = count.checked_mul(size_of_type(kind))?;
        let at = if length <= self.word() { inline } else { self.number(inline, self.word())? };
        (at.checked_add(length)? <= self.bytes.len()).then_some(Values { at, kind, count })
    }

    /// The first value of `tag` as a number: a whole number or a fraction.
    pub fn value(&self, directory: usize, tag: usize) -> Option<f64> {
        let Values { at, kind, count } = self.values(directory, tag)?;
        match kind {
            _ if count == 0 => None,
            5 => {
                let [above, below] = [self.number(at, 4)?, self.number(at + 4, 4)?];
                (below != 0).then(|| above as f64 / below as f64)
            }
            1 | 3 | 4 | 13 | 16..=18 => self.number(at, size_of_type(kind)).map(|value| value as f64),
            _ => None,
        }
    }

    /// The bytes of `tag` as they are.
    pub fn raw(&self, directory: usize, tag: usize) -> Option<&'a [u8]> {
        let Values { at, kind, count } = self.values(directory, tag)?;
        self.bytes.get(at..at.checked_add(count.checked_mul(size_of_type(kind))?)?)
    }

    /// The text of `tag`, up to its first null byte.
    pub fn text(&self, directory: usize, tag: usize) -> Option<String> {
        let Values { at, count, .. } = self.values(directory, tag)?;
        let bytes = self.bytes.get(at..at + count)?;
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        Some(String::from_utf8_lossy(&bytes[..end]).into_owned())
    }

    /// The byte order of the file.
    pub fn endian(&self) -> Endian {
        if self.is_little { Endian::Little } else { Endian::Big }
    }
}

/// The values of one tag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Values {
    /// The place of the first.
    pub at: usize,
    /// The TIFF type.
    pub kind: usize,
    /// Their number.
    pub count: usize,
}

/// Bytes of a value of a TIFF type; unknown types count as bytes.
fn size_of_type(kind: usize) -> usize {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn checked(bytes: &[u8]) -> Result<()> {
        check(&Source::from_bytes(Path::new("x.tif"), bytes.to_vec()))
    }

    #[test]
    fn tags_longer_than_the_file_are_refused() {
        let with_count = |count: u32| {
            let mut bytes = b"II*\0\x08\0\0\0\x01\0\x0e\x01\x02\0".to_vec();
            bytes.extend(count.to_le_bytes());
            bytes.extend([0; 8]);
            bytes
        };
        assert!(checked(&with_count(26)).is_ok());
        let error = checked(&with_count(0x1000_0000)).unwrap_err().to_string();
        assert!(error.contains("tag 270 claims 268435456 bytes"), "{error}");
        let big = b"MM\0+\0\x08\0\0\0\0\0\0\0\0\0\x10\0\0\0\0\0\0\0\x01\x01\x0e\0\x05\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\0\0";
        assert!(checked(big).unwrap_err().to_string().contains("claims 2048 bytes"));
    }

    #[test]
    fn rings_and_ends_are_left_to_the_decoder() {
        assert!(checked(b"II*\0\x08\0\0\0\0\0\x08\0\0\0").is_ok());
        assert!(checked(b"II*\0\xff\xff\xff\xff").is_ok());
        assert!(checked(b"II").is_ok());
    }
}
