//! The voxels that a text header speaks of: in the same file or in others, bare or encoded.

use super::decompress::{Compression, decompress, decompress_all};
use super::layout::Layout;
use super::{Source, numbers};
use crate::Result;
use fovol_core::{Endian, Volume, VoxelBytes};
use std::sync::Arc;

/// Where the voxels are.
#[derive(Debug, Clone, PartialEq)]
pub enum Files {
    /// In the file of the header, from this byte on.
    Attached(usize),
    /// In these files, equal parts in each, slowest axis last.
    Detached(Vec<String>),
}

/// How the voxels are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encoding {
    /// As they are in memory.
    Bare,
    /// As they are in memory, then compressed.
    Compressed(Compression),
    /// As decimal numbers.
    Decimal,
    /// As hexadecimal digits of their bytes.
    Hexadecimal,
}

/// What lies between the start of the data and the first voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Skip {
    /// This many bytes.
    Bytes(usize),
    /// Whatever there is before the last bytes, which are the voxels.
    UpToTheLast,
}

/// Where voxels are and how they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Payload {
    /// Where.
    pub files: Files,
    /// How.
    pub encoding: Encoding,
    /// Lines before the data, in the file itself.
    pub line_skip: usize,
    /// Bytes before the voxels, counted after decompression.
    pub byte_skip: Skip,
}

/// Decompressed data may begin with a foreign header of at most this size.
const LONGEST_FOREIGN_HEADER: usize = 1 << 20;

impl Payload {
    /// The first of `volumes` volumes of `layout`. Bare voxels of one file are mapped, not copied.
    ///
    /// # Errors
    /// Missing files, too few bytes, damaged data.
    pub fn volume(&self, source: &Source, mut layout: Layout, volumes: usize) -> Result<Volume> {
        let one = layout.length(source)?;
        let all = one.checked_mul(volumes).filter(|&all| all > 0).ok_or_else(|| {
            source.malformed(format!("it cannot hold {volumes} volumes; check the sizes in its header"))
        })?;
        if matches!(self.encoding, Encoding::Decimal) {
            layout.endian = Endian::Little;
        }
        let (bytes, offset): (VoxelBytes, usize) = match &self.files {
            Files::Attached(start) => self.part(source, *start, &layout, one, all)?,
            Files::Detached(names) if names.len() == 1 => {
                self.part(&source.sibling(&names[0])?, 0, &layout, one, all)?
            }
            Files::Detached(names) => (Arc::new(self.joined(source, names, &layout, one, all)?), 0),
        };
        layout.volume(source, bytes, offset)
    }

    /// The first `one` of `all` bytes, gathered from the files `names`.
    fn joined(
        &self,
        source: &Source,
        names: &[String],
        layout: &Layout,
        one: usize,
        all: usize,
    ) -> Result<Vec<u8>> {
        let each = all.checked_div(names.len()).unwrap_or(0);
        if each == 0 || each * names.len() != all || !each.is_multiple_of(layout.dtype.size()) {
            return Err(source.malformed(format!(
                "its {all} bytes do not divide among its {} data files; check the list of files",
                names.len()
            )));
        }
        let mut out = Vec::new();
        for name in names {
            let wanted = each.min(one - out.len());
            if wanted == 0 {
                break;
            }
            let (bytes, offset) = self.part(&source.sibling(name)?, 0, layout, wanted, each)?;
            out.extend_from_slice(&(*bytes).as_ref()[offset..offset + wanted]);
        }
        Ok(out)
    }

    /// Bytes that hold the first `wanted` of the `all` bytes of voxels in `file`, and where they begin.
    fn part(
        &self,
        file: &Source,
        start: usize,
        layout: &Layout,
        wanted: usize,
        all: usize,
    ) -> Result<(VoxelBytes, usize)> {
        let start = start + skipped_lines(file, start, self.line_skip)?;
        let data = &file.bytes()[start..];
        match self.encoding {
            Encoding::Bare => {
                let offset = start + self.byte_skip.offset(file, data.len(), wanted, all)?;
                Ok((file.shared(), offset))
            }
            Encoding::Compressed(compression) => {
                let bytes = match self.byte_skip {
                    Skip::Bytes(skip) => decompress(file, data, compression, skip.saturating_add(wanted))?,
                    Skip::UpToTheLast => {
                        decompress_all(file, data, compression, all.saturating_add(LONGEST_FOREIGN_HEADER))?
                    }
                };
                let offset = self.byte_skip.offset(file, bytes.len(), wanted, all)?;
                Ok((Arc::new(bytes), offset))
            }
            Encoding::Decimal => {
                let text = &data[self.byte_skip.within(data)..];
                let count = wanted / layout.dtype.size();
                Ok((Arc::new(numbers::decimal(file, text, layout.dtype, count)?), 0))
            }
            Encoding::Hexadecimal => {
                let text = &data[self.byte_skip.within(data)..];
                Ok((Arc::new(numbers::hexadecimal(file, text, wanted)?), 0))
            }
        }
    }
}

impl Skip {
    /// Where the voxels begin among `length` bytes that must hold `wanted` from there on.
    fn offset(self, file: &Source, length: usize, wanted: usize, all: usize) -> Result<usize> {
        let (offset, needed) = match self {
            Self::Bytes(skip) => (Some(skip), skip.saturating_add(wanted)),
            Self::UpToTheLast => (length.checked_sub(all), all),
        };
        offset.filter(|_| needed <= length).ok_or_else(|| {
            file.malformed(format!(
                "it ends after {length} of {needed} bytes of voxels; copy or download it again"
            ))
        })
    }

    /// The number of bytes of text to pass over.
    fn within(self, text: &[u8]) -> usize {
        match self {
            Self::Bytes(skip) => skip.min(text.len()),
            Self::UpToTheLast => 0,
        }
    }
}

/// The length of the first `lines` lines after `start`.
fn skipped_lines(file: &Source, start: usize, lines: usize) -> Result<usize> {
    if lines == 0 {
        return Ok(0);
    }
    let data = &file.bytes()[start..];
    let mut ends = data.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(at, _)| at + 1);
    ends.nth(lines - 1)
        .ok_or_else(|| file.malformed(format!("it has fewer than the {lines} lines to skip before its data")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Dtype;
    use std::path::Path;

    fn attached(encoding: Encoding, line_skip: usize, byte_skip: Skip) -> Payload {
        Payload { files: Files::Attached(0), encoding, line_skip, byte_skip }
    }

    fn read(payload: &Payload, bytes: &[u8], volumes: usize) -> Result<Volume> {
        let source = Source::from_bytes(Path::new("x"), bytes.to_vec());
        payload.volume(&source, Layout::new([2, 1, 1], Dtype::U16), volumes)
    }

    #[test]
    fn lines_and_bytes_are_skipped() {
        let payload = attached(Encoding::Bare, 1, Skip::Bytes(2));
        let volume = read(&payload, b"title\n..\x01\0\x02\0", 1).unwrap();
        assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [1.0, 2.0]);
        assert!(read(&attached(Encoding::Bare, 3, Skip::Bytes(0)), b"title\n", 1).is_err());
        assert!(read(&attached(Encoding::Bare, 0, Skip::Bytes(usize::MAX)), b"12345", 1).is_err());
    }

    #[test]
    fn the_last_bytes_are_found() {
        let payload = attached(Encoding::Bare, 0, Skip::UpToTheLast);
        let volume = read(&payload, b"header\x01\0\x02\0\x03\0\x04\0", 2).unwrap();
        assert_eq!(volume.value([0, 0, 0]), 1.0);
        assert!(read(&payload, b"abc", 1).unwrap_err().to_string().contains("it ends after 3 of 4"));
    }

    #[test]
    fn text_is_read_and_counted() {
        let volume = read(&attached(Encoding::Decimal, 0, Skip::Bytes(0)), b"7 8\n", 1).unwrap();
        assert_eq!(volume.value([1, 0, 0]), 8.0);
        let volume = read(&attached(Encoding::Hexadecimal, 0, Skip::Bytes(0)), b"0700 0800", 1).unwrap();
        assert_eq!(volume.value([1, 0, 0]), 8.0);
        assert!(read(&attached(Encoding::Decimal, 0, Skip::Bytes(0)), b"7", 1).is_err());
    }

    #[test]
    fn parts_of_many_files_are_joined() {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in [("a", b"\x01\0"), ("b", b"\x02\0")] {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let source = Source::from_bytes(&folder.path().join("x"), vec![]);
        let with = |names: &[&str]| {
            let files = Files::Detached(names.iter().map(|name| (*name).to_owned()).collect());
            let payload = Payload { files, ..attached(Encoding::Bare, 0, Skip::Bytes(0)) };
            payload.volume(&source, Layout::new([2, 1, 1], Dtype::U16), 1)
        };
        assert_eq!(with(&["a", "b"]).unwrap().value([1, 0, 0]), 2.0);
        assert!(with(&["a", "missing"]).unwrap_err().to_string().contains("missing"));
        assert!(with(&["a", "b", "a"]).unwrap_err().to_string().contains("divide"));
        assert!(with(&[]).is_err());
    }

    #[test]
    fn no_volumes_and_endless_ones_are_errors() {
        let payload = attached(Encoding::Bare, 0, Skip::Bytes(0));
        assert!(read(&payload, b"1234", 0).is_err());
        assert!(read(&payload, b"1234", usize::MAX).is_err());
    }
}
