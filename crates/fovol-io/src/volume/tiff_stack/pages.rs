//! The pages of one TIFF file, one after another.

use super::directories;
use crate::volume::Source;
use crate::{Error, Result};
use fovol_core::Dtype;
use std::fmt;
use std::io::Cursor;
use tiff::ColorType;
use tiff::decoder::{BufferLayoutPreference, Decoder, DecodingSampleType, Limits};
use tiff::tags::Tag;

/// Bound on the compression ratio: LZW packs constant pages best, 1310 bytes into one.
const BYTES_PER_BYTE: usize = 1400;

/// Bytes that any file may decode to, whatever its length.
const FREE_BYTES: usize = 64 << 10;

/// Format of the slices of a stack; it is the same for all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slice {
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// The type of one component.
    pub dtype: Dtype,
    /// Interleaved values per pixel.
    pub components: usize,
    /// Whether the values of a pixel are its colour.
    pub is_colour: bool,
    /// How many planes of one component the page has; only the first is read of several.
    pub planes: usize,
}

impl fmt::Display for Slice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size: [x, y], dtype, components, .. } = self;
        write!(f, "{x}x{y} pixels of {components} x {dtype}")
    }
}

/// An open TIFF file.
pub struct Pages<'a> {
    source: &'a Source,
    decoder: Decoder<Cursor<&'a [u8]>>,
    /// The number of pages that were begun.
    begun: usize,
    /// The decoded bytes that the size of the file still justifies.
    budget: usize,
}

impl<'a> Pages<'a> {
    /// Opens `source`.
    ///
    /// # Errors
    /// A file that is no TIFF file or has no sound first page.
    pub fn open(source: &'a Source) -> Result<Self> {
        directories::check(source)?;
        let decoder = Decoder::new(Cursor::new(source.bytes())).map_err(|e| broken(source, 1, &e))?;
        let budget = source.bytes().len().saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = budget;
        limits.intermediate_buffer_size = budget;
        limits.ifd_value_size = source.bytes().len();
        Ok(Self { source, decoder: decoder.with_limits(limits), begun: 0, budget })
    }

    /// The number of the page that was begun last, from 1 on.
    pub fn number(&self) -> usize {
        self.begun
    }

    /// Begins the next page that is no preview; false at the end.
    ///
    /// # Errors
    /// Damaged pages.
    pub fn begin(&mut self) -> Result<bool> {
        loop {
            if self.begun > 0 {
                if !self.decoder.more_images() {
                    return Ok(false);
                }
                self.decoder.next_image().map_err(|e| broken(self.source, self.begun + 1, &e))?;
            }
            self.begun += 1;
            if !self.is_preview() {
                return Ok(true);
            }
        }
    }

    /// Whether the page is a smaller version of another.
    fn is_preview(&mut self) -> bool {
        let kind = self.decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType);
        matches!(kind, Ok(Some(kind)) if kind & 1 == 1)
    }

    /// Appends the pixels of the page, in the byte order of this machine, to `out`.
    ///
    /// # Errors
    /// Damaged pages, and those that claim more pixels than the file can hold.
    pub fn decode(&mut self, out: &mut Vec<u8>) -> Result<()> {
        let length = self.layout()?.len;
        self.budget = self.budget.checked_sub(length).ok_or_else(|| {
            self.source.malformed(format!("page {} claims more pixels than the file can hold", self.begun))
        })?;
        let before = out.len();
        out.resize(before + length, 0);
        let decoded = self.decoder.read_image_bytes(&mut out[before..]);
        decoded.map_err(|e| broken(self.source, self.begun, &e))
    }

    /// The current page as a slice. Of separate planes the first is read.
    ///
    /// # Errors
    /// Damaged pages, types that are not read.
    pub fn slice(&mut self) -> Result<Slice> {
        let page = self.begun;
        let (width, height) = self.decoder.dimensions().map_err(|e| broken(self.source, page, &e))?;
        let size = [width as usize, height as usize];
        let colour = self.decoder.colortype().map_err(|e| broken(self.source, page, &e))?;
        let samples = samples(colour);
        let layout = self.layout()?;
        let dtype =
            layout.sample_type.map(dtype).filter(|dtype| usize::from(colour.bit_depth()) == 8 * dtype.size());
        let (Some(samples), Some(dtype)) = (samples, dtype) else {
            return Err(self.source.unsupported(format!(
                "page {page} has {colour:?} pixels, which are not read; convert it to grey of 8, 16 or 32 bits"
            )));
        };
        let components = if layout.planes > 1 { 1 } else { samples };
        let expected = [width as usize, height as usize, components, dtype.size()]
            .into_iter()
            .try_fold(1usize, |product, factor| product.checked_mul(factor));
        let is_colour = components > 2 && matches!(colour, ColorType::RGB(_) | ColorType::RGBA(_));
        match expected == Some(layout.len) && layout.len > 0 {
            true => Ok(Slice { size, dtype, components, is_colour, planes: layout.planes }),
            false => Err(self
                .source
                .malformed(format!("page {page} says {width}x{height} pixels, which cannot be"))),
        }
    }

    fn layout(&mut self) -> Result<BufferLayoutPreference> {
        self.decoder.image_buffer_layout().map_err(|e| broken(self.source, self.begun, &e))
    }
}

fn broken(source: &Source, page: usize, error: &tiff::TiffError) -> Error {
    let is_end = |e: &std::io::Error| {
        (e.kind() == std::io::ErrorKind::UnexpectedEof).then(|| e.to_string().contains("lzw"))
    };
    let end = if let tiff::TiffError::IoError(e) = error { is_end(e) } else { None };
    if end == Some(true) {
        return source.malformed(format!(
            "the LZW data of its page {page} do not end; copy it again, or save it uncompressed"
        ));
    }
    if end.is_some() {
        return source.malformed(format!("it is cut off within page {page}; copy or download it again"));
    }
    let problem: String =
        error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect();
    source.malformed(format!("page {page} cannot be read as TIFF: {problem}"))
}

/// Values per pixel of colours whose first value can be shown; indices into palettes count as values.
fn samples(colour: ColorType) -> Option<usize> {
    match colour {
        ColorType::Gray(_) | ColorType::Palette(_) => Some(1),
        ColorType::GrayA(_) => Some(2),
        ColorType::RGB(_) => Some(3),
        ColorType::RGBA(_) => Some(4),
        ColorType::Multiband { num_samples, .. } => Some(usize::from(num_samples)),
        _ => None,
    }
}

fn dtype(sample: DecodingSampleType) -> Dtype {
    match sample {
        DecodingSampleType::U8 => Dtype::U8,
        DecodingSampleType::U16 => Dtype::U16,
        DecodingSampleType::U32 => Dtype::U32,
        DecodingSampleType::U64 => Dtype::U64,
        DecodingSampleType::I8 => Dtype::I8,
        DecodingSampleType::I16 => Dtype::I16,
        DecodingSampleType::I32 => Dtype::I32,
        DecodingSampleType::I64 => Dtype::I64,
        DecodingSampleType::F16 => Dtype::F16,
        DecodingSampleType::F32 => Dtype::F32,
        DecodingSampleType::F64 => Dtype::F64,
    }
}
