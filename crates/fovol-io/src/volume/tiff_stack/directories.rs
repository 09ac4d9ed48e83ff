//! A look at the directories of a TIFF file before it is decoded: the decoder makes room for a tag before it
//! knows whether the file has as many bytes, and has no limit of ours until it has read the first directory.

use crate::Result;
use crate::volume::Source;

/// Refuses a file with a tag that is longer than the file. What cannot be followed is left to the decoder.
///
/// # Errors
/// Such a tag.
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

/// Numbers of a TIFF or BigTIFF file in its byte order.
struct Reader<'a> {
    bytes: &'a [u8],
    is_little: bool,
    is_big_tiff: bool,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Option<Self> {
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
