//! Colours and ranges of ImageJ's channels, in two tags of its own.
//!
//! Source: `ij/io/TiffDecoder.java` of ImageJ, `getMetaData`.

use super::directories::Reader;
use fovol_core::{ChannelDisplay, Endian};

/// The tag of the lengths of all parts, the first of which is a table of contents, and that of the parts.
const LENGTHS: usize = 50838;
const PARTS: usize = 50839;

/// Bytes of a table of colours: 256 of red, of green and of blue.
const TABLE: usize = 768;

/// Most channels that are listed.
const MOST: usize = 256;

/// How the channels of the file are shown, by the directory of its first page; empty where it does not say.
pub fn displays(reader: &Reader<'_>, first: usize) -> Vec<ChannelDisplay> {
    parts(reader, first).unwrap_or_default()
}

fn parts(reader: &Reader<'_>, first: usize) -> Option<Vec<ChannelDisplay>> {
    let (lengths, all) = (reader.raw(first, LENGTHS)?, reader.raw(first, PARTS)?);
    let number = |bytes: &[u8; 4]| match reader.endian() {
        Endian::Little => u32::from_le_bytes(*bytes),
        Endian::Big => u32::from_be_bytes(*bytes),
    };
    let mut lengths = lengths.as_chunks::<4>().0.iter().map(|length| number(length) as usize);
    let (table, mut rest) = all.split_at_checked(lengths.next()?)?;
    let mut found: Vec<ChannelDisplay> = Vec::new();
    // Behind four letters, each kind of part and how many there are.
    for entry in table.get(4..)?.as_chunks::<8>().0 {
        let [kind, count] = [entry.first_chunk()?, entry.last_chunk()?].map(number);
        for channel in 0..count as usize {
            let (part, after) = rest.split_at_checked(lengths.next()?)?;
            rest = after;
            match &kind.to_be_bytes() {
                b"rang" => add_ranges(&mut found, part, reader.endian()),
                b"luts" if part.len() == TABLE && channel < MOST => {
                    // The brightest colour of a table is that of the channel.
                    at(&mut found, channel).colour = Some([part[255], part[511], part[767]]);
                }
                _ => {}
            }
        }
    }
    Some(found)
}

/// The display of the channel `channel` of `found`.
fn at(found: &mut Vec<ChannelDisplay>, channel: usize) -> &mut ChannelDisplay {
    if found.len() <= channel {
        found.resize(channel + 1, ChannelDisplay::default());
    }
    &mut found[channel]
}

/// Takes over the darkest and brightest value of each channel.
fn add_ranges(found: &mut Vec<ChannelDisplay>, part: &[u8], endian: Endian) {
    let number = |bytes: &[u8; 8]| match endian {
        Endian::Little => f64::from_le_bytes(*bytes),
        Endian::Big => f64::from_be_bytes(*bytes),
    };
    let pairs = part.as_chunks::<8>().0.as_chunks::<2>().0;
    for (channel, pair) in pairs.iter().take(MOST).enumerate() {
        let [low, high] = pair.each_ref().map(number);
        if low.is_finite() && high.is_finite() && low < high {
            at(found, channel).window = Some([low, high]);
        }
    }
}
