//! Run lengths (PS3.5, annex G): each byte of the samples is a segment, the highest byte first.

use super::decoded::Decoded;
use crate::volume::dicom::pixel_format::PixelFormat;

/// Length of the table of segments.
const TABLE: usize = 64;

/// Unpacks the frame in `bytes`.
///
/// # Errors
/// Segments that are missing or end early.
pub fn decode(bytes: &[u8], format: &PixelFormat) -> Result<Decoded, String> {
    let damaged = || "its run lengths are damaged; copy or download it again".to_owned();
    let size = format.sample_size();
    let segments = word(bytes, 0).ok_or_else(damaged)?;
    if segments != size * format.samples {
        return Err(damaged());
    }
    let mut out = vec![0; format.values() * size];
    let stride = size * format.samples;
    for segment in 0..segments {
        let start = word(bytes, 4 + 4 * segment).filter(|&start| start >= TABLE).ok_or_else(damaged)?;
        let end = if segment + 1 < segments { word(bytes, 8 + 4 * segment) } else { None };
        let packed = bytes.get(start..end.unwrap_or(bytes.len())).ok_or_else(damaged)?;
        let at = segment / size * size + size - 1 - segment % size;
        unpack(packed, out[at..].iter_mut().step_by(stride)).ok_or_else(damaged)?;
    }
    Ok(Decoded { bytes: out, is_rgb: false })
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let four = bytes.get(at..at + 4)?.try_into().ok()?;
    Some(u32::from_le_bytes(four) as usize)
}

/// Fills `out` from runs: a number of bytes that follow, or how often the next one comes.
fn unpack<'a>(packed: &[u8], mut out: impl Iterator<Item = &'a mut u8>) -> Option<()> {
    let mut at = 0;
    let mut next = out.next();
    while next.is_some() {
        let control = *packed.get(at)? as i8;
        at += 1;
        let count = match control {
            0.. => usize::from(control as u8) + 1,
            i8::MIN => 0,
            _ => 1 + usize::from(control.unsigned_abs()),
        };
        for i in 0..count {
            let Some(byte) = next else { break };
            *byte = *packed.get(if control >= 0 { at + i } else { at })?;
            next = out.next();
        }
        at += if control >= 0 { count } else { usize::from(control != i8::MIN) };
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::unpack;

    #[test]
    fn runs_and_literals() {
        let mut out = [0; 6];
        unpack(&[1, 7, 8, 0x80, 0xFD, 9], out.iter_mut()).unwrap();
        assert_eq!(out, [7, 8, 9, 9, 9, 9]);
        assert!(unpack(&[1, 7], out.iter_mut()).is_none());
    }
}
