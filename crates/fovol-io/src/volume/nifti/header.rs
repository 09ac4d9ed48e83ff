//! The binary headers of NIfTI-1 (348 bytes), NIfTI-2 (540 bytes) and ANALYZE 7.5, their ancestor.

use super::forms::{Forms, Quaternion};
use crate::Result;
use crate::volume::Source;
use fovol_core::{Dtype, Endian, Rescale, Voxel};

/// Fields of an Analyze or NIfTI header.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Which standard it follows.
    pub kind: Kind,
    /// The byte order of header and voxels.
    pub endian: Endian,
    /// Whether the voxels follow in the same file.
    pub is_single: bool,
    /// Where the voxels begin.
    pub offset: usize,
    /// The size of each axis that is in use.
    pub sizes: Vec<usize>,
    /// The spacing of these axes, at least three; NaN where the file has 0.
    pub spacings: Vec<f64>,
    /// The type of one component.
    pub dtype: Dtype,
    /// Interleaved values per voxel.
    pub components: usize,
    /// Whether the values of each voxel are colours.
    pub are_colours: bool,
    /// Whether the values are labels.
    pub are_labels: bool,
    /// The scaling of the voxels.
    pub rescale: Rescale,
    /// Where the voxels lie in space.
    pub forms: Forms,
    /// The unit of the spacings, by its symbol.
    pub units: Option<&'static str>,
}

/// The standards, oldest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// ANALYZE 7.5: no scaling, no orientation.
    Analyze,
    /// NIfTI-1.
    One,
    /// NIfTI-2.
    Two,
}

impl Kind {
    /// The name of the standard.
    pub fn name(self) -> &'static str {
        match self {
            Self::Analyze => "ANALYZE 7.5",
            Self::One => "NIfTI-1",
            Self::Two => "NIfTI-2",
        }
    }

    /// The length of its header.
    pub fn length(self) -> usize {
        match self {
            Self::Analyze | Self::One => LENGTH_1,
            Self::Two => LENGTH_2,
        }
    }
}

/// The length of a NIfTI-1 header.
pub const LENGTH_1: usize = 348;
/// The length of a NIfTI-2 header.
pub const LENGTH_2: usize = 540;

/// Whether `bytes` begin with a NIfTI header.
pub fn is_nifti(bytes: &[u8]) -> bool {
    matches!(bytes.get(344..348), Some(b"n+1\0" | b"ni1\0"))
        || matches!(bytes.get(4..8), Some(b"n+2\0" | b"ni2\0"))
}

/// The length of the header that begins with `bytes`, from its first field.
///
/// # Errors
/// Bytes that begin no such header.
pub fn length(source: &Source, bytes: &[u8]) -> Result<usize> {
    length_and_endian(source, bytes).map(|(length, _)| length)
}

fn length_and_endian(source: &Source, bytes: &[u8]) -> Result<(usize, Endian)> {
    let first = bytes.first_chunk::<4>().copied().unwrap_or_default();
    [Endian::Little, Endian::Big]
        .into_iter()
        .map(|endian| (u32::decode(&first, endian) as usize, endian))
        .find(|(length, _)| [LENGTH_1, LENGTH_2].contains(length))
        .ok_or_else(|| source.malformed("it does not begin with a NIfTI header; is the name right?"))
}

impl Header {
    /// Reads the header at the start of `bytes`, which are those of `source`, decompressed.
    ///
    /// # Errors
    /// Too few bytes, values that no header has, types that are not read.
    pub fn parse(source: &Source, bytes: &[u8]) -> Result<Self> {
        let (length, endian) = length_and_endian(source, bytes)?;
        let bytes = bytes.get(..length).ok_or_else(|| {
            let found = bytes.len();
            source.malformed(format!(
                "it ends after {found} of {length} bytes of its NIfTI header; copy it again"
            ))
        })?;
        let (kind, is_single) = match length {
            LENGTH_2 => match &bytes[4..8] {
                b"n+2\0" => (Kind::Two, true),
                b"ni2\0" => (Kind::Two, false),
                _ => return Err(source.malformed("its header lacks the NIfTI-2 mark n+2; is it damaged?")),
            },
            _ => match &bytes[344..348] {
                b"n+1\0" => (Kind::One, true),
                b"ni1\0" => (Kind::One, false),
                _ => (Kind::Analyze, false),
            },
        };
        Fields { source, bytes, endian, kind }.header(is_single)
    }
}

/// The fields of a header, by their places in it.
struct Fields<'a> {
    source: &'a Source,
    bytes: &'a [u8],
    endian: Endian,
    kind: Kind,
}

impl Fields<'_> {
    fn header(&self, is_single: bool) -> Result<Header> {
        let sizes = self.sizes()?;
        let (dtype, components) = self.types()?;
        Ok(Header {
            kind: self.kind,
            endian: self.endian,
            is_single,
            offset: self.offset(is_single)?,
            // A flat image may say how thick it is.
            spacings: (1..=sizes.len().max(3)).map(|axis| self.spacing(axis)).collect(),
            sizes,
            dtype,
            components,
            are_colours: components > 1 || matches!(self.intent(), 2003 | 2004),
            are_labels: self.intent() == 1002,
            rescale: self.rescale(components)?,
            forms: self.forms(),
            units: self.units(),
        })
    }

    /// The field at byte `at`; all offsets are constants below [`Kind::length`].
    fn at<T: Voxel>(&self, at: usize) -> T {
        T::decode(&self.bytes[at..at + size_of::<T>()], self.endian)
    }

    /// A number that NIfTI-1 has as f32 and NIfTI-2 as f64: the `index`th of those at these places.
    fn float(&self, one: usize, two: usize, index: usize) -> f64 {
        match self.kind {
            Kind::Two => self.at::<f64>(two + 8 * index),
            _ => f64::from(self.at::<f32>(one + 4 * index)),
        }
    }

    /// A number that NIfTI-1 has as i16 and NIfTI-2 as i64.
    fn dim(&self, index: usize) -> i64 {
        match self.kind {
            Kind::Two => self.at::<i64>(16 + 8 * index),
            _ => i64::from(self.at::<i16>(40 + 2 * index)),
        }
    }

    fn sizes(&self) -> Result<Vec<usize>> {
        let count = self.dim(0);
        if !(1..=7).contains(&count) {
            return Err(self.source.malformed(format!("its header says {count} axes; 1 to 7 are possible")));
        }
        (1..=count as usize)
            .map(|axis| {
                let size = self.dim(axis);
                // Writers leave 0 in the sizes of axes beyond the third.
                let size = if axis > 3 { size.max(1) } else { size };
                usize::try_from(size).map_err(|_| {
                    self.source.malformed(format!("its header says {size} voxels along axis {axis}"))
                })
            })
            .collect()
    }

    fn spacing(&self, axis: usize) -> f64 {
        match self.float(76, 104, axis) {
            0.0 => f64::NAN,
            spacing => spacing,
        }
    }

    fn types(&self) -> Result<(Dtype, usize)> {
        let code = match self.kind {
            Kind::Two => self.at::<i16>(12),
            _ => self.at::<i16>(70),
        };
        Ok(match code {
            2 => (Dtype::U8, 1),
            4 => (Dtype::I16, 1),
            8 => (Dtype::I32, 1),
            16 => (Dtype::F32, 1),
            64 => (Dtype::F64, 1),
            128 => (Dtype::U8, 3),
            256 => (Dtype::I8, 1),
            512 => (Dtype::U16, 1),
            768 => (Dtype::U32, 1),
            1024 => (Dtype::I64, 1),
            1280 => (Dtype::U64, 1),
            2304 => (Dtype::U8, 4),
            _ => return Err(self.source.unsupported(refusal(code))),
        })
    }

    /// The code of what the values mean.
    fn intent(&self) -> i32 {
        match self.kind {
            Kind::Analyze => 0,
            Kind::One => i32::from(self.at::<i16>(68)),
            Kind::Two => self.at::<i32>(504),
        }
    }

    fn offset(&self, is_single: bool) -> Result<usize> {
        let length = self.kind.length();
        let said = match self.kind {
            Kind::Two => self.at::<i64>(168),
            // The cast saturates; what is too large for the file is found later.
            _ => f64::from(self.at::<f32>(108)) as i64,
        };
        match usize::try_from(said) {
            // 4 bytes that announce extensions follow the header.
            Ok(0) if is_single => Ok(length + 4),
            Ok(offset) if !is_single || offset >= length => Ok(offset),
            _ => Err(self.source.malformed(format!(
                "its header says that voxels begin at byte {said}, but its header is {length} bytes long"
            ))),
        }
    }

    fn rescale(&self, components: usize) -> Result<Rescale> {
        let slope = self.float(112, 176, 0);
        // The standard forbids scaled colours.
        if self.kind == Kind::Analyze || components > 1 || slope == 0.0 || !slope.is_finite() {
            return Ok(Rescale::IDENTITY);
        }
        let intercept = self.float(116, 184, 0);
        match intercept.is_finite() {
            true => Ok(Rescale { slope, intercept }),
            false => Err(self.source.malformed(format!(
                "its scl_inter is {intercept}; write a finite number there, or scl_slope 0 for no scaling"
            ))),
        }
    }

    /// The codes and numbers that place voxels in space.
    fn forms(&self) -> Forms {
        let (qform, sform) = match self.kind {
            Kind::Analyze => return Forms::default(),
            Kind::One => (i32::from(self.at::<i16>(252)), i32::from(self.at::<i16>(254))),
            Kind::Two => (self.at::<i32>(344), self.at::<i32>(348)),
        };
        let row = |row: usize| std::array::from_fn(|i| self.float(280 + 16 * row, 400 + 32 * row, i));
        let quaternion = || Quaternion {
            imaginary: std::array::from_fn(|i| self.float(256, 352, i)),
            offset: std::array::from_fn(|i| self.float(268, 376, i)),
            is_flipped: self.float(76, 104, 0) < 0.0,
        };
        Forms { sform: (sform > 0).then(|| [row(0), row(1), row(2)]), qform: (qform > 0).then(quaternion) }
    }

    /// The unit of the spacing, by its symbol.
    fn units(&self) -> Option<&'static str> {
        let code = match self.kind {
            Kind::Analyze => return None,
            Kind::One => i32::from(self.at::<u8>(123)),
            Kind::Two => self.at::<i32>(500),
        };
        match code & 7 {
            1 => Some("m"),
            2 => Some("mm"),
            3 => Some("µm"),
            _ => None,
        }
    }
}

/// Why a type is not read.
fn refusal(code: i16) -> String {
    let name = match code {
        1 => "single bits",
        32 | 1792 | 2048 => "complex numbers",
        1536 => "128-bit floats",
        _ => return format!("its header has the unknown voxel type {code}"),
    };
    format!("it holds {name}, which are not read; convert it to float32, with nibabel for one")
}
