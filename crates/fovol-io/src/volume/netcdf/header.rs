//! The header of a classic NetCDF file: dimensions, attributes and variables.
//!
//! Source: <https://docs.unidata.ucar.edu/nug/current/file_format_specifications.html>.

use crate::volume::cf::{Attribute, Attributes};
use crate::volume::reals;
use fovol_core::{Dtype, Endian};
use std::collections::BTreeMap;

/// Names, attributes and axes that are read at most.
const MOST: usize = 1 << 16;

/// A dimension.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dimension {
    /// Its name.
    pub name: String,
    /// Its length; none for the one along which records are added.
    pub length: Option<usize>,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its dimensions, slowest first, as indices.
    pub dimensions: Vec<usize>,
    /// Its attributes.
    pub attributes: Attributes,
    /// The type of its values; none for text.
    pub dtype: Option<Dtype>,
    /// Where its first value lies in the file.
    pub begin: usize,
}

/// All that the header says.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// The version: 1, 2 or 5.
    pub version: u8,
    /// The number of records; none if nobody counted them.
    pub records: Option<usize>,
    /// The dimensions.
    pub dimensions: Vec<Dimension>,
    /// The variables.
    pub variables: Vec<Variable>,
}

/// Whether `bytes` begin as classic files do.
pub fn is_classic(bytes: &[u8]) -> bool {
    matches!(bytes, [b'C', b'D', b'F', 1 | 2 | 5, ..])
}

impl Header {
    /// Parses the header at the start of `bytes`; none where it is damaged.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let version = *bytes.get(3).filter(|_| is_classic(bytes))?;
        let mut fields = Fields { bytes: &bytes[4..], is_wide: version == 5, has_wide_offsets: version != 1 };
        let records = fields.count()?;
        let uncounted = if version == 5 { u64::MAX } else { u64::from(u32::MAX) };
        let dimensions = fields.list(10, |fields| {
            let (name, length) = (fields.name()?, usize::try_from(fields.count()?).ok()?);
            Some(Dimension { name, length: Some(length).filter(|&length| length > 0) })
        })?;
        fields.attributes()?;
        let variables = fields.list(11, Fields::variable)?;
        let is_sound =
            |variable: &Variable| variable.dimensions.iter().all(|&index| index < dimensions.len());
        let records = if records == uncounted { None } else { Some(usize::try_from(records).ok()?) };
        variables.iter().all(is_sound).then_some(Self { version, records, dimensions, variables })
    }
}

/// The rest of a header.
struct Fields<'a> {
    bytes: &'a [u8],
    is_wide: bool,
    has_wide_offsets: bool,
}

impl<'a> Fields<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(length)?;
        self.bytes = rest;
        Some(taken)
    }

    fn word(&mut self) -> Option<u32> {
        Some(u32::from_be_bytes(self.take(4)?.try_into().ok()?))
    }

    fn long(&mut self) -> Option<u64> {
        Some(u64::from_be_bytes(self.take(8)?.try_into().ok()?))
    }

    /// A number of elements, or the length of a dimension.
    fn count(&mut self) -> Option<u64> {
        if self.is_wide { self.long() } else { self.word().map(u64::from) }
    }

    /// A list of `tag`, or its absence.
    fn list<T>(&mut self, tag: u32, one: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let (found, count) = (self.word()?, self.count()?);
        match (found, count) {
            (0, 0) => Some(Vec::new()),
            (found, count) if found == tag && count <= MOST as u64 => (0..count).map(|_| one(self)).collect(),
            _ => None,
        }
    }

    /// Bytes that are filled up to a multiple of four.
    fn padded(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.take(length)?;
        self.take(length.next_multiple_of(4) - length)?;
        Some(taken)
    }

    fn name(&mut self) -> Option<String> {
        let length = usize::try_from(self.count()?).ok().filter(|&length| length <= MOST)?;
        Some(String::from_utf8_lossy(self.padded(length)?).into_owned())
    }

    fn attributes(&mut self) -> Option<Attributes> {
        let found: BTreeMap<String, Attribute> = self.list(12, Self::attribute)?.into_iter().collect();
        Some(Attributes(found))
    }

    fn attribute(&mut self) -> Option<(String, Attribute)> {
        let (name, kind, count) = (self.name()?, self.word()?, usize::try_from(self.count()?).ok()?);
        let dtype = dtype(kind)?;
        let size = dtype.map_or(1, Dtype::size);
        let bytes = self.padded(count.checked_mul(size).filter(|&length| length <= self.bytes.len())?)?;
        Some((
            name,
            match dtype {
                None => Attribute::Text(String::from_utf8_lossy(bytes).trim_end_matches('\0').to_owned()),
                Some(dtype) => Attribute::Numbers(decoded(bytes, dtype)),
            },
        ))
    }

    fn variable(&mut self) -> Option<Variable> {
        let (name, count) = (self.name()?, self.count()?);
        if count > MOST as u64 {
            return None;
        }
        let dimensions =
            (0..count).map(|_| usize::try_from(self.count()?).ok()).collect::<Option<Vec<usize>>>()?;
        let attributes = self.attributes()?;
        let dtype = dtype(self.word()?)?;
        // The size follows from the dimensions; what is written overflows for large variables.
        self.count()?;
        let begin = if self.has_wide_offsets { self.long()? } else { u64::from(self.word()?) };
        Some(Variable { name, dimensions, attributes, dtype, begin: usize::try_from(begin).ok()? })
    }
}

/// The type of number `kind`; none inside for text.
fn dtype(kind: u32) -> Option<Option<Dtype>> {
    Some(Some(match kind {
        1 => Dtype::I8,
        2 => return Some(None),
        3 => Dtype::I16,
        4 => Dtype::I32,
        5 => Dtype::F32,
        6 => Dtype::F64,
        7 => Dtype::U8,
        8 => Dtype::U16,
        9 => Dtype::U32,
        10 => Dtype::I64,
        11 => Dtype::U64,
        _ => return None,
    }))
}

/// The big-endian numbers in `bytes`.
pub fn decoded(bytes: &[u8], dtype: Dtype) -> Vec<f64> {
    reals::decoded(bytes, dtype, Endian::Big)
}
