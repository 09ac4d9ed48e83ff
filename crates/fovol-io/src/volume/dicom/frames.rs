//! Frames of one file: where their bytes are, and their voxels.

use super::codec;
use super::colours::{self, Palette};
use super::data_set::{DataSet, PixelValue};
use super::elements::fragments;
use super::pixel_format::{Photometric, PixelFormat};
use super::samples;
use super::syntax::{Codec, Syntax};

/// Bytes that a compressed frame may unpack to, whatever its length.
const FREE_BYTES: usize = 1 << 20;

/// And for each of its bytes: empty slices compress well.
const BYTES_PER_BYTE: usize = 1100;

/// The frames of a file.
pub struct Frames<'a> {
    format: PixelFormat,
    syntax: Syntax,
    pixels: PixelValue<'a>,
    packed: Vec<Vec<&'a [u8]>>,
    palette: Option<Palette>,
}

impl<'a> Frames<'a> {
    /// The frames of `set`, of which there are `count`.
    ///
    /// # Errors
    /// Fewer bytes than the frames need, in words.
    pub fn of(set: &DataSet<'a>, syntax: Syntax, count: usize) -> Result<Self, String> {
        let format = PixelFormat::of(set)?;
        let pixels = set.pixels().ok_or("it has no pixels; ask for another copy")?;
        let palette = if format.is_palette() { Some(Palette::of(set)?) } else { None };
        let is_packed = pixels.is_encapsulated || syntax.codec != Codec::None;
        let packed = if is_packed { packed(pixels, count)? } else { Vec::new() };
        let frames = Self { format, syntax, pixels, packed, palette };
        frames.check_length(count)?;
        Ok(frames)
    }

    /// The layout of a frame.
    pub fn format(&self) -> &PixelFormat {
        &self.format
    }

    /// Refuses sizes that the bytes cannot hold, before memory is taken for them.
    fn check_length(&self, count: usize) -> Result<(), String> {
        let found = self.pixels.bytes.len();
        let (needed, have) = match (self.packed.is_empty(), self.format.allocated) {
            (true, 1) => ((count as u128 * self.format.values() as u128).div_ceil(8), found as u128),
            (true, _) => (count as u128 * self.format.bytes() as u128, found as u128),
            (false, _) => {
                let most = found.saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES);
                (count as u128 * (self.format.values() * self.format.sample_size()) as u128, most as u128)
            }
        };
        match needed <= have {
            true => Ok(()),
            false => Err(format!(
                "it ends after {found} bytes of pixels, too few for {count} frames; copy or download it again"
            )),
        }
    }

    /// Unpacks `frame` to `out`: little-endian components, interleaved.
    ///
    /// # Errors
    /// Damaged frames, in words.
    pub fn decode(&self, frame: usize, out: &mut [u8]) -> Result<(), String> {
        let (mut bytes, is_rgb) = match self.packed.get(frame) {
            Some(parts) => {
                let decoded = codec::decode(self.syntax.codec, &parts.concat(), &self.format)?;
                (decoded.bytes, decoded.is_rgb)
            }
            None => (self.bare(frame)?, false),
        };
        let is_native = self.syntax.codec == Codec::None;
        if is_native && self.format.photometric == Photometric::Ybr422 {
            bytes = colours::from_shared(&bytes, self.format.sample_size());
        }
        // Codecs but RLE and JPEG-LS, which follow the header, interleave by themselves.
        if self.format.is_planar && is_native {
            bytes = samples::interleaved(&bytes, self.format.samples, self.format.sample_size());
        }
        samples::mask(&mut bytes, &self.format);
        let is_ybr = matches!(self.format.photometric, Photometric::Ybr | Photometric::Ybr422);
        if is_ybr && !is_rgb {
            colours::to_rgb(&mut bytes, &self.format);
        }
        let voxels = match &self.palette {
            Some(palette) => palette.coloured(&bytes, &self.format),
            None => bytes,
        };
        let whole = voxels.get(..out.len()).ok_or("it has a frame that ends early; copy it again")?;
        out.copy_from_slice(whole);
        Ok(())
    }

    /// The samples of a frame without compression, little-endian.
    fn bare(&self, frame: usize) -> Result<Vec<u8>, String> {
        let early = || "it has a frame that ends early; copy or download it again".to_owned();
        if self.format.allocated == 1 {
            let values = self.format.values();
            return samples::bits(self.pixels.bytes, frame * values, values).ok_or_else(early);
        }
        let length = self.format.bytes();
        let range = frame * length..(frame + 1) * length;
        if self.syntax.encoding.is_big && self.format.allocated == 8 && self.pixels.are_words {
            // Two samples share a word, of which the upper byte comes first.
            let bytes: Option<Vec<u8>> = range.map(|at| self.pixels.bytes.get(at ^ 1).copied()).collect();
            return bytes.ok_or_else(early);
        }
        let mut bytes = self.pixels.bytes.get(range).ok_or_else(early)?.to_vec();
        let size = self.format.sample_size();
        if self.syntax.encoding.is_big && size > 1 {
            bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        Ok(bytes)
    }
}

/// The fragments of each of `count` compressed frames.
fn packed(pixels: PixelValue<'_>, count: usize) -> Result<Vec<Vec<&[u8]>>, String> {
    if !pixels.is_encapsulated {
        return Ok(vec![vec![pixels.bytes]]);
    }
    let all = fragments(pixels.bytes);
    let Some((table, parts)) = all.split_first() else {
        return Err("its compressed pixels are missing; copy or download it again".into());
    };
    if count == 1 {
        return Ok(vec![parts.to_vec()]);
    }
    if parts.len() == count {
        return Ok(parts.iter().map(|&part| vec![part]).collect());
    }
    let starts = frame_starts(table, parts);
    if starts.len() != count {
        return Err(format!(
            "it has {} compressed frames, not {count}; copy or download it again",
            starts.len()
        ));
    }
    let ends = starts.iter().skip(1).copied().chain([parts.len()]);
    Ok(starts.iter().zip(ends).map(|(&start, end)| parts[start..end.max(start)].to_vec()).collect())
}

/// Numbers of the fragments with which frames begin: by the table of offsets, else by the marks of JPEG.
fn frame_starts(table: &[u8], parts: &[&[u8]]) -> Vec<usize> {
    if table.len() < 4 {
        let is_start = |part: &[u8]| matches!(part, [0xFF, 0xD8 | 0x4F, 0xFF, ..]);
        return (0..parts.len()).filter(|&number| is_start(parts[number])).collect();
    }
    let mut offsets =
        table.chunks_exact(4).map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]));
    let mut wanted = offsets.next();
    let mut at = 0usize;
    let mut starts = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        if wanted.is_some_and(|wanted| wanted as usize == at) {
            starts.push(number);
            wanted = offsets.next();
        }
        at += part.len() + 8;
    }
    starts
}
