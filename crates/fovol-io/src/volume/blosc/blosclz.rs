//! BloscLZ, the codec of Blosc itself, a relative of FastLZ.

/// Matches from farther away have their distance in two more bytes.
const FAR: usize = 8191;

/// Unpacks `packed` into `out`, and returns how many bytes there are; none if it is damaged.
///
/// A control byte below 32 precedes so many literal bytes and one more. Others have the length of a match in three bits
/// and the start of its distance in five.
pub fn unpack(mut packed: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut control = usize::from(next(&mut packed)?) & 31;
    let mut at = 0;
    loop {
        if control < 32 {
            let (literal, rest) = packed.split_at_checked(control + 1)?;
            out.get_mut(at..at + literal.len())?.copy_from_slice(literal);
            at += literal.len();
            packed = rest;
        } else {
            let (length, distance) = matched(control, &mut packed)?;
            let from = at.checked_sub(distance)?;
            out.get(at..at.checked_add(length)?)?;
            // Matches may overlap the bytes that they write.
            for i in 0..length {
                out[at + i] = out[from + i];
            }
            at += length;
        }
        match next(&mut packed) {
            Some(next) => control = usize::from(next),
            None => return Some(at),
        }
    }
}

/// Length and distance of the match that `control` begins.
fn matched(control: usize, packed: &mut &[u8]) -> Option<(usize, usize)> {
    let mut length = (control >> 5) + 2;
    let near = (control & 31) << 8;
    if control >> 5 == 7 {
        loop {
            let more = next(packed)?;
            length += usize::from(more);
            if more != 255 {
                break;
            }
        }
    }
    let low = next(packed)?;
    let distance = if low == 255 && near == 31 << 8 {
        usize::from(u16::from_be_bytes([next(packed)?, next(packed)?])) + FAR
    } else {
        near + usize::from(low)
    };
    Some((length, distance + 1))
}

fn next(packed: &mut &[u8]) -> Option<u8> {
    let (&first, rest) = packed.split_first()?;
    *packed = rest;
    Some(first)
}
