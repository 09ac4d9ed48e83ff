//! Voxels that a text header refers to: in the same file or in others, raw or encoded.

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

/// Encoding of the voxels in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Encoding {
    /// Raw binary.
    Bare,
    /// Compressed binary.
    Compressed(Compression),
    /// Decimal text.
    Decimal,
    /// Hexadecimal text: two digits per byte.
    Hexadecimal,
}

/// Bytes between the start of the data and the first voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Skip {
    /// This many bytes.
    Bytes(usize),
    /// All bytes before the voxels, which are the last bytes.
    UpToTheLast,
}

/// Volumes of one layout that follow each other, one of which is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocks {
    /// How many there are.
    pub count: usize,
    /// Which is read.
    pub index: usize,
}

impl Blocks {
    /// One volume alone.
    pub const ONE: Self = Self { count: 1, index: 0 };
}

/// Bytes that are read of a file, after those that are passed over.
#[derive(Clone, Copy)]
struct Wanted {
    /// Bytes of voxels before the wanted ones.
    from: usize,
    /// The number of wanted bytes.
    length: usize,
    /// All bytes of voxels in the file.
    all: usize,
}

impl Wanted {
    fn end(self) -> usize {
        self.from + self.length
    }
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
    /// One of the `blocks` of `layout`. Bare voxels of one file are mapped, not copied.
    ///
    /// # Errors
    /// Missing files, too few bytes, damaged data.
    pub fn volume(&self, source: &Source, mut layout: Layout, blocks: Blocks) -> Result<Volume> {
        let one = layout.length(source)?;
        let all = one.checked_mul(blocks.count).filter(|&all| all > 0).ok_or_else(|| {
            source
                .malformed(format!("it cannot hold {} volumes; check the sizes in its header", blocks.count))
        })?;
        if matches!(self.encoding, Encoding::Decimal) {
            layout.endian = Endian::Little;
        }
        let wanted = Wanted { from: one * blocks.index, length: one, all };
        let (bytes, offset): (VoxelBytes, usize) = match &self.files {
            Files::Attached(start) => self.part(source, *start, &layout, wanted)?,
            Files::Detached(names) if names.len() == 1 => {
                self.part(&source.sibling(&names[0])?, 0, &layout, wanted)?
            }
            Files::Detached(names) => (Arc::new(self.joined(source, names, &layout, wanted)?), 0),
        };
        layout.volume(source, bytes, offset)
    }

    /// The `wanted` bytes, gathered from the files `names`.
    fn joined(&self, source: &Source, names: &[String], layout: &Layout, wanted: Wanted) -> Result<Vec<u8>> {
        let all = wanted.all;
        let each = all.checked_div(names.len()).unwrap_or(0);
        if each == 0 || each * names.len() != all || !each.is_multiple_of(layout.dtype.size()) {
            return Err(source.malformed(format!(
                "its {all} bytes do not divide among its {} data files; check the list of files",
                names.len()
            )));
        }
        let mut out = Vec::new();
        for (name, start) in names.iter().zip((0..).step_by(each)) {
            let from = wanted.from.max(start);
            let end = wanted.end().min(start + each);
            if from >= end {
                continue;
            }
            let part = Wanted { from: from - start, length: end - from, all: each };
            let (bytes, offset) = self.part(&source.sibling(name)?, 0, layout, part)?;
            out.extend_from_slice(&(*bytes).as_ref()[offset..offset + part.length]);
        }
        Ok(out)
    }

    /// Bytes that hold the `wanted` ones of `file`, and where these begin.
    fn part(
        &self,
        file: &Source,
        start: usize,
        layout: &Layout,
        wanted: Wanted,
    ) -> Result<(VoxelBytes, usize)> {
        let start = start + skipped_lines(file, start, self.line_skip)?;
        let data = &file.bytes()[start..];
        match self.encoding {
            Encoding::Bare => {
                let offset = start + self.byte_skip.offset(file, data.len(), wanted)?;
                Ok((file.shared(), offset))
            }
            Encoding::Compressed(compression) => {
                let bytes = match self.byte_skip {
                    Skip::Bytes(skip) => {
                        decompress(file, data, compression, skip.saturating_add(wanted.end()))?
                    }
                    Skip::UpToTheLast => {
                        let limit = wanted.all.saturating_add(LONGEST_FOREIGN_HEADER);
                        decompress_all(file, data, compression, limit)?
                    }
                };
                let offset = self.byte_skip.offset(file, bytes.len(), wanted)?;
                Ok((Arc::new(bytes), offset))
            }
            Encoding::Decimal => {
                let text = &data[self.byte_skip.within(data)..];
                let count = wanted.end() / layout.dtype.size();
                Ok((Arc::new(numbers::decimal(file, text, layout.dtype, count)?), wanted.from))
            }
            Encoding::Hexadecimal => {
                let text = &data[self.byte_skip.within(data)..];
                Ok((Arc::new(numbers::hexadecimal(file, text, wanted.end())?), wanted.from))
            }
        }
    }
}

impl Skip {
    /// Where the wanted voxels begin among `length` bytes.
    fn offset(self, file: &Source, length: usize, wanted: Wanted) -> Result<usize> {
        let (offset, needed) = match self {
            Self::Bytes(skip) => (Some(skip), skip.saturating_add(wanted.end())),
            Self::UpToTheLast => (length.checked_sub(wanted.all), wanted.all),
        };
        offset.filter(|_| needed <= length).map(|offset| offset + wanted.from).ok_or_else(|| {
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

    fn read(payload: &Payload, bytes: &[u8], count: usize) -> Result<Volume> {
        read_block(payload, bytes, Blocks { count, index: 0 })
    }

    fn read_block(payload: &Payload, bytes: &[u8], blocks: Blocks) -> Result<Volume> {
        let source = Source::from_bytes(Path::new("x"), bytes.to_vec());
        payload.volume(&source, Layout::new([2, 1, 1], Dtype::U16), blocks)
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
    fn later_blocks_are_found_in_every_encoding() {
        let blocks = Blocks { count: 2, index: 1 };
        let bare = b"\x01\0\x02\0\x03\0\x04\0";
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut packed, bare).unwrap();
        let packed = packed.finish().unwrap();
        for (encoding, bytes) in [
            (Encoding::Bare, &bare[..]),
            (Encoding::Compressed(Compression::Zlib), &packed),
            (Encoding::Decimal, b"1 2 3 4"),
            (Encoding::Hexadecimal, b"0100 0200 0300 0400"),
        ] {
            let volume = read_block(&attached(encoding, 0, Skip::Bytes(0)), bytes, blocks).unwrap();
            assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [3.0, 4.0], "{encoding:?}");
        }
        let volume = read_block(&attached(Encoding::Bare, 0, Skip::UpToTheLast), bare, blocks).unwrap();
        assert_eq!(volume.value([0, 0, 0]), 3.0);
        assert!(read_block(&attached(Encoding::Bare, 0, Skip::Bytes(0)), &bare[..7], blocks).is_err());
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
            payload.volume(&source, Layout::new([2, 1, 1], Dtype::U16), Blocks::ONE)
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
