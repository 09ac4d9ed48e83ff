//! Layout of pixels: size, bits, and how colours are written.

use super::data_set::DataSet;
use super::tags;
use fovol_core::Dtype;

/// How samples make colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometric {
    /// Grey, 0 is black.
    Grey,
    /// Grey, 0 is white.
    InvertedGrey,
    /// Indices into a table of colours.
    Palette {
        /// Whether the colours have 16 bits rather than 8.
        is_deep: bool,
    },
    /// Red, green and blue.
    Rgb,
    /// Luminance and two differences, full range.
    Ybr,
    /// [`Self::Ybr`] where two neighbours share the differences.
    Ybr422,
    /// Luminance and differences that the codec of JPEG 2000 turns to red, green and blue by itself.
    YbrOfJpeg2000,
}

/// Type of the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers, signed or not.
    Whole {
        /// Whether they are signed.
        is_signed: bool,
    },
    /// 32-bit floats.
    Float,
    /// 64-bit floats.
    Double,
}

/// Layout of the pixels of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelFormat {
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// Samples per pixel.
    pub samples: usize,
    /// Whether all red samples come first, then all green ones, then all blue ones.
    pub is_planar: bool,
    /// Bits that a sample takes.
    pub allocated: u32,
    /// Bits of it that are used.
    pub stored: u32,
    /// Number of its highest used bit.
    pub high: u32,
    /// The type.
    pub kind: Kind,
    /// The meaning of samples.
    pub photometric: Photometric,
}

impl PixelFormat {
    /// The format that `set` describes.
    ///
    /// # Errors
    /// Attributes that are missing, contradict each other or are of no known kind, in words.
    pub fn of(set: &DataSet<'_>) -> Result<Self, String> {
        let whole = |tag, name: &str| {
            let missing = || format!("it does not say its {name}; ask for another copy");
            set.whole::<u32>(tag).ok_or_else(missing)
        };
        let size = [whole(tags::COLUMNS, "columns")? as usize, whole(tags::ROWS, "rows")? as usize];
        let samples = set.whole::<u32>(tags::SAMPLES_PER_PIXEL).unwrap_or(1) as usize;
        let pixels = set.pixels().map_or(tags::PIXELS, |pixels| pixels.tag);
        let is_signed = set.whole::<u16>(tags::PIXEL_REPRESENTATION) == Some(1);
        let (kind, allocated) = match pixels {
            tags::FLOAT_PIXELS => (Kind::Float, 32),
            tags::DOUBLE_PIXELS => (Kind::Double, 64),
            _ => (Kind::Whole { is_signed }, whole(tags::BITS_ALLOCATED, "allocated bits")?),
        };
        if !matches!(allocated, 1 | 8 | 16 | 32 | 64) {
            return Err(format!("it has {allocated} bits a sample; convert it to 8, 16, 32 or 64"));
        }
        let is_float = !matches!(kind, Kind::Whole { .. });
        let stored = if is_float { None } else { set.whole::<u32>(tags::BITS_STORED) }.unwrap_or(allocated);
        let high = if is_float { None } else { set.whole::<u32>(tags::HIGH_BIT) };
        let high = high.unwrap_or(stored.saturating_sub(1));
        if stored == 0 || stored > allocated || high >= allocated || high + 1 < stored {
            return Err(format!(
                "it says that {stored} bits up to number {high} are used of {allocated}; mend its header"
            ));
        }
        let photometric = photometric(set, samples)?;
        let is_planar = set.whole::<u16>(tags::PLANAR) == Some(1) && samples > 1;
        if size.contains(&0) || size.iter().any(|&side| side > 1 << 16) {
            return Err(format!("its {}x{} pixels are no picture; mend its header", size[0], size[1]));
        }
        Ok(Self { size, samples, is_planar, allocated, stored, high, kind, photometric })
    }

    /// Pixels of one frame.
    pub fn pixels(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Samples of one frame.
    pub fn values(&self) -> usize {
        self.pixels() * self.samples
    }

    /// Bytes of one frame, without compression. Frames of single bits begin anywhere in a byte.
    pub fn bytes(&self) -> usize {
        match (self.allocated, self.photometric) {
            (1, _) => self.values().div_ceil(8),
            (_, Photometric::Ybr422) => self.pixels() * 2 * self.sample_size(),
            _ => self.values() * self.sample_size(),
        }
    }

    /// Bytes of one sample once it is unpacked.
    pub fn sample_size(&self) -> usize {
        (self.allocated as usize).div_ceil(8)
    }

    /// The type of one component of a voxel.
    pub fn dtype(&self) -> Dtype {
        if let Photometric::Palette { is_deep } = self.photometric {
            return if is_deep { Dtype::U16 } else { Dtype::U8 };
        }
        match (self.kind, self.allocated) {
            (Kind::Float, _) => Dtype::F32,
            (Kind::Double, _) => Dtype::F64,
            (Kind::Whole { is_signed: false }, 1 | 8) => Dtype::U8,
            (Kind::Whole { is_signed: true }, 1 | 8) => Dtype::I8,
            (Kind::Whole { is_signed: false }, 16) => Dtype::U16,
            (Kind::Whole { is_signed: true }, 16) => Dtype::I16,
            (Kind::Whole { is_signed: false }, 32) => Dtype::U32,
            (Kind::Whole { is_signed: true }, 32) => Dtype::I32,
            (Kind::Whole { is_signed: false }, _) => Dtype::U64,
            (Kind::Whole { is_signed: true }, _) => Dtype::I64,
        }
    }

    /// Components of a voxel: colours of a palette have three.
    pub fn components(&self) -> usize {
        if self.is_palette() { 3 } else { self.samples }
    }

    /// Whether pixels are indices into a table of colours.
    pub fn is_palette(&self) -> bool {
        matches!(self.photometric, Photometric::Palette { .. })
    }

    /// Whether voxels are colours.
    pub fn is_coloured(&self) -> bool {
        self.components() > 1
    }

    /// Whether bits beside the used ones have to be taken out.
    pub fn is_padded(&self) -> bool {
        self.allocated > 1 && (self.stored, self.high + 1) != (self.allocated, self.allocated)
    }
}

fn photometric(set: &DataSet<'_>, samples: usize) -> Result<Photometric, String> {
    let name = set.text(tags::PHOTOMETRIC).unwrap_or_default();
    let found = match name.as_str() {
        "MONOCHROME1" => Photometric::InvertedGrey,
        // The numbers of segments are wanted, not the colours that they are shown in.
        "PALETTE COLOR" if set.has(tags::SEGMENTS) => Photometric::Grey,
        "PALETTE COLOR" => {
            // Number of entries, first index, bits of an entry.
            Photometric::Palette { is_deep: set.numbers(tags::RED_DESCRIPTOR, 3).get(2) == Some(&16.0) }
        }
        "RGB" => Photometric::Rgb,
        "YBR_FULL" => Photometric::Ybr,
        "YBR_FULL_422" => Photometric::Ybr422,
        "YBR_ICT" | "YBR_RCT" => Photometric::YbrOfJpeg2000,
        "MONOCHROME2" | "" if samples == 1 => Photometric::Grey,
        "" if samples == 3 => Photometric::Rgb,
        _ => {
            let name = name.escape_debug();
            return Err(format!("its colours are `{name}`, which are not read; convert it to RGB or grey"));
        }
    };
    let expected = match found {
        Photometric::Grey | Photometric::InvertedGrey | Photometric::Palette { .. } => 1,
        _ => 3,
    };
    match samples == expected {
        true => Ok(found),
        false => {
            Err(format!("it has {samples} samples a pixel, but its colours need {expected}; mend its header"))
        }
    }
}
