//! A DICOM file (PS3.10): preamble, meta information, and the data set in its transfer syntax.

use super::data_set::DataSet;
use super::elements::{EXPLICIT_LITTLE, Encoding, IMPLICIT_LITTLE};
use super::syntax::{Codec, Syntax};
use super::tags;
use crate::Result;
use crate::volume::Source;
use std::borrow::Cow;
use std::io::Read;

/// Length of the preamble; the mark `DICM` follows.
const PREAMBLE: usize = 128;

/// The mark.
const MARK: &[u8] = b"DICM";

/// The class of a directory of files.
const DIRECTORY: &str = "1.2.840.10008.1.3.10";

/// Whether `bytes` have the mark of DICOM.
pub fn is_marked(bytes: &[u8]) -> bool {
    bytes.get(PREAMBLE..PREAMBLE + MARK.len()) == Some(MARK)
}

/// A file whose transfer syntax is known.
pub struct DicomFile<'a> {
    /// The transfer syntax.
    pub syntax: Syntax,
    /// Whether it is a directory of other files.
    pub is_directory: bool,
    bytes: Cow<'a, [u8]>,
    start: usize,
}

impl<'a> DicomFile<'a> {
    /// The file in `source`, with or without the preamble.
    ///
    /// # Errors
    /// Bytes that are no DICOM, and transfer syntaxes that are not known.
    pub fn open(source: &'a Source) -> Result<Self> {
        let bytes = source.bytes();
        let start = if is_marked(bytes) { PREAMBLE + MARK.len() } else { 0 };
        let meta = EXPLICIT_LITTLE.element(bytes, start).filter(|element| element.tag >> 16 == 2);
        if meta.is_none() {
            let encoding = guessed(bytes, start)
                .ok_or_else(|| source.malformed("it is no DICOM file; check how it was made or copied"))?;
            let syntax = Syntax { encoding, codec: Codec::None, is_deflated: false };
            return Ok(Self { syntax, is_directory: false, bytes: Cow::Borrowed(bytes), start });
        }
        Self::after_meta(source, start)
    }

    fn after_meta(source: &'a Source, first: usize) -> Result<Self> {
        let bytes = source.bytes();
        let start = meta_end(bytes, first);
        let meta = DataSet::new(bytes, (first, start), EXPLICIT_LITTLE);
        let is_directory = meta.text(tags::MEDIA_STORAGE_CLASS).as_deref() == Some(DIRECTORY);
        let syntax = match meta.text(tags::TRANSFER_SYNTAX) {
            Some(uid) => Syntax::of(&uid).map_err(|problem| source.unsupported(problem))?,
            None => {
                let encoding = guessed(bytes, start).unwrap_or(IMPLICIT_LITTLE);
                Syntax { encoding, codec: Codec::None, is_deflated: false }
            }
        };
        if !syntax.is_deflated {
            return Ok(Self { syntax, is_directory, bytes: Cow::Borrowed(bytes), start });
        }
        let mut inflated = Vec::new();
        flate2::read::DeflateDecoder::new(&bytes[start..]).read_to_end(&mut inflated).map_err(|e| {
            source.malformed(format!("its compressed data is damaged ({e}); copy or download it again"))
        })?;
        Ok(Self { syntax, is_directory, bytes: Cow::Owned(inflated), start: 0 })
    }

    /// The elements of the file.
    pub fn data_set(&self) -> DataSet<'_> {
        DataSet::new(&self.bytes, (self.start, self.bytes.len()), self.syntax.encoding)
    }
}

/// Where the elements of group 2 end, which begin at `start`.
fn meta_end(bytes: &[u8], start: usize) -> usize {
    let mut at = start;
    while let Some(element) = EXPLICIT_LITTLE.element(bytes, at) {
        if element.tag >> 16 != 2 {
            break;
        }
        at = element.next;
    }
    at
}

/// The encoding of elements that begin at `at`, if it looks like any: the first is of group 8.
fn guessed(bytes: &[u8], at: usize) -> Option<Encoding> {
    let first = bytes.get(at..at + 6)?;
    let is_explicit = first[4..6].iter().all(u8::is_ascii_uppercase);
    let is_big = match first {
        [8, 0, _, 0, ..] => false,
        [0, 8, 0, _, ..] => true,
        _ => return None,
    };
    let encoding = Encoding { is_explicit, is_big };
    // A second element behind the first, or the file is of another kind.
    let next = encoding.element(bytes, at)?.next;
    encoding.element(bytes, next).filter(|element| element.tag >> 16 >= 8).map(|_| encoding)
}
