//! The head of a file, and the list of its grids.

use super::cursor::Cursor;
use crate::Result;
use crate::volume::Source;

/// First bytes of a file: a number of 64 bits.
const MAGIC: &[u8] = b" BDV\0\0\0\0";

/// Versions of files that are read. Older ones are from before 2014.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=224;

/// A file has fewer grids.
const MOST_GRIDS: i32 = 1 << 16;

/// Between the name of a grid and a number that tells it from others of that name.
const SEPARATOR: char = '\x1e';

/// Whether `bytes` are those of an OpenVDB file.
pub fn is_vdb(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// The head of a file.
pub struct Head<'a> {
    /// Whether the list says where each grid is, so that others can be passed over.
    pub has_offsets: bool,
    /// How many grids follow.
    pub grids: usize,
    /// The place of the first entry.
    pub cursor: Cursor<'a>,
}

impl<'a> Head<'a> {
    /// Reads the head of `source`.
    ///
    /// # Errors
    /// A damaged head, a version that is not read.
    pub fn parse(source: &'a Source) -> Result<Self> {
        let bytes = source.bytes();
        let mut cursor = Cursor::at(bytes, MAGIC.len() as u64)
            .filter(|_| is_vdb(bytes))
            .ok_or_else(|| source.malformed("it does not begin like an OpenVDB file; is the name right?"))?;
        let version = cursor.u32().ok_or_else(|| source.damaged())?;
        if !VERSIONS.contains(&version) {
            return Err(source.unsupported(format!(
                "it has version {version} of OpenVDB's files; versions 222 to 224 are read, so load and save it with another OpenVDB"
            )));
        }
        Self::rest(cursor).ok_or_else(|| source.damaged())
    }

    fn rest(mut cursor: Cursor<'a>) -> Option<Self> {
        let (_major, _minor) = (cursor.u32()?, cursor.u32()?);
        let has_offsets = cursor.u8()? != 0;
        let _identifier = cursor.take(36)?;
        Metadata::parse(&mut cursor)?;
        let grids = cursor.i32().filter(|count| (0..MOST_GRIDS).contains(count))?;
        Some(Self { has_offsets, grids: usize::try_from(grids).ok()?, cursor })
    }
}

/// An entry of the list of grids.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its name, with a number if others have the same.
    pub unique_name: String,
    /// The type of its tree.
    pub kind: String,
    /// The unique name of the grid whose tree it shares; empty if it has its own.
    pub parent: String,
    /// Where the grid begins, and where its entry's follower is. Only files with offsets have them.
    pub start: u64,
    pub end: u64,
}

impl Entry {
    /// Reads the entry at `cursor`.
    pub fn parse(cursor: &mut Cursor<'_>) -> Option<Self> {
        let (unique_name, kind, parent) = (cursor.text()?, cursor.text()?, cursor.text()?);
        let [start, _blocks, end] = [cursor.i64()?, cursor.i64()?, cursor.i64()?];
        let [start, end] = [start, end].map(|place| u64::try_from(place).unwrap_or(u64::MAX));
        Some(Self { unique_name, kind, parent, start, end })
    }

    /// The name as OpenVDB shows it: with its number in brackets, if it has one.
    pub fn name(&self) -> String {
        match self.unique_name.split_once(SEPARATOR) {
            Some((name, number)) => format!("{name}[{number}]"),
            None => self.unique_name.clone(),
        }
    }
}

/// Metadata of a file or a grid, as far as it matters.
#[derive(Debug, Clone, Default)]
pub struct Metadata {
    /// The class of a grid, "level set" for one.
    pub class: String,
}

impl Metadata {
    /// Reads the metadata at `cursor`.
    pub fn parse(cursor: &mut Cursor<'_>) -> Option<Self> {
        let mut metadata = Self::default();
        for _ in 0..cursor.u32()? {
            let (name, kind) = (cursor.text()?, cursor.text()?);
            let length = cursor.u32()? as usize;
            let value = cursor.take(length)?;
            if name == "class" && kind == "string" {
                metadata.class = String::from_utf8_lossy(value).into_owned();
            }
        }
        Some(metadata)
    }
}
