//! Colours: luminance and differences, and tables.

use super::data_set::DataSet;
use super::pixel_format::{Kind, PixelFormat};
use super::tags;

/// Pairs of pixels that share their differences (Y, Y, Cb, Cr) as whole pixels (Y, Cb, Cr, Y, Cb, Cr).
pub fn from_shared(pairs: &[u8], size: usize) -> Vec<u8> {
    let quads = pairs.chunks_exact(4 * size);
    quads
        .flat_map(|quad| [0, 2, 3, 1, 2, 3].map(|part| &quad[part * size..(part + 1) * size]).concat())
        .collect()
}

/// Turns luminance and differences of full range to red, green and blue (PS3.3 C.7.6.3.1.2).
pub fn to_rgb(samples: &mut [u8], format: &PixelFormat) {
    if format.sample_size() != 1 || format.samples != 3 {
        return;
    }
    for pixel in samples.chunks_exact_mut(3) {
        let [y, blue, red] = [f64::from(pixel[0]), f64::from(pixel[1]) - 128.0, f64::from(pixel[2]) - 128.0];
        let colours = [y + 1.402 * red, y - 0.344_136 * blue - 0.714_136 * red, y + 1.772 * blue];
        for (sample, colour) in pixel.iter_mut().zip(colours) {
            *sample = colour.round().clamp(0.0, 255.0) as u8;
        }
    }
}

/// A table of colours (PS3.3 C.7.6.3.1.5).
pub struct Palette {
    first: i64,
    entries: Vec<[u16; 3]>,
    is_deep: bool,
}

impl Palette {
    /// The table of `set`.
    ///
    /// # Errors
    /// A table that is missing, or written in segments, in words.
    pub fn of(set: &DataSet<'_>) -> Result<Self, String> {
        if set.has(tags::RED_SEGMENTS) {
            return Err("its table of colours is in segments, which are not read; convert it to RGB".into());
        }
        let missing = || "its table of colours is missing or damaged; ask for another copy".to_owned();
        let descriptor: [f64; 3] = set.vector(tags::RED_DESCRIPTOR).ok_or_else(missing)?;
        let [count, first, bits] = descriptor.map(|number| number as i64);
        let count = if count == 0 { 1 << 16 } else { usize::try_from(count).map_err(|_| missing())? };
        let is_signed = set.whole::<u16>(tags::PIXEL_REPRESENTATION) == Some(1);
        let first = if is_signed { i64::from(first as u16 as i16) } else { first };
        let is_deep = bits == 16;
        let table = |tag| {
            let bytes = set.value(tag)?;
            let is_big = set.encoding().is_big;
            let word = |two: &[u8]| {
                let two = [two[0], two[1]];
                if is_big { u16::from_be_bytes(two) } else { u16::from_le_bytes(two) }
            };
            // Entries of 8 bits lie in bytes, or in words of which the upper half is empty.
            let is_narrow = !is_deep && bytes.len() < 2 * count;
            let entries: Vec<u16> = match is_narrow {
                true => bytes.iter().map(|&byte| u16::from(byte)).collect(),
                false => bytes.chunks_exact(2).map(word).collect(),
            };
            (entries.len() >= count).then_some(entries)
        };
        let [red, green, blue] = [tags::RED_TABLE, tags::GREEN_TABLE, tags::BLUE_TABLE].map(table);
        let (Some(red), Some(green), Some(blue)) = (red, green, blue) else { return Err(missing()) };
        let entries = (0..count).map(|i| [red[i], green[i], blue[i]]).collect();
        Ok(Self { first, entries, is_deep })
    }

    /// The colours of little-endian `samples`.
    pub fn coloured(&self, samples: &[u8], format: &PixelFormat) -> Vec<u8> {
        let size = format.sample_size();
        let is_signed = format.kind == Kind::Whole { is_signed: true };
        let mut out = Vec::with_capacity(format.pixels() * if self.is_deep { 6 } else { 3 });
        for sample in samples.chunks_exact(size) {
            let mut word = [0; 8];
            word[..size].copy_from_slice(sample);
            let shift = 64 - 8 * size as u32;
            let raw = (u64::from_le_bytes(word) << shift) as i64;
            let index = if is_signed { raw >> shift } else { (raw as u64 >> shift) as i64 };
            let last = self.entries.len() as i64 - 1;
            let entry = self.entries[index.saturating_sub(self.first).clamp(0, last) as usize];
            match self.is_deep {
                true => out.extend(entry.iter().flat_map(|colour| colour.to_le_bytes())),
                false => out.extend(entry.map(|colour| colour as u8)),
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_share_their_differences() {
        assert_eq!(from_shared(&[1, 2, 8, 9], 1), [1, 8, 9, 2, 8, 9]);
    }
}
