//! BloscLZ: runs of literals, and repeats of what was written before, as in FastLZ.

/// Distances that two bytes hold; longer ones have two more.
const LONGEST_SHORT: usize = 8191;

/// Lengths of repeats that a control byte holds; longer ones have more bytes.
const LONGEST_IN_CONTROL: usize = 9;

/// Unpacks `packed` into `out`, and returns how many bytes it holds; none if it is damaged.
pub fn decode(packed: &[u8], out: &mut [u8]) -> Option<usize> {
    let (&first, mut rest) = packed.split_first()?;
    let (mut control, mut at) = (usize::from(first & 31), 0);
    loop {
        if control < 32 {
            let (literals, after) = rest.split_at_checked(control + 1)?;
            out.get_mut(at..at + literals.len())?.copy_from_slice(literals);
            at += literals.len();
            rest = after;
        } else {
            let mut length = (control >> 5) + 2;
            if length == LONGEST_IN_CONTROL {
                let mut more = u8::MAX;
                while more == u8::MAX {
                    more = next(&mut rest)?;
                    length += usize::from(more);
                }
            }
            let (high, low) = (control & 31, next(&mut rest)?);
            let distance = match (high, low) {
                (31, u8::MAX) => {
                    let far = u16::from_be_bytes([next(&mut rest)?, next(&mut rest)?]);
                    usize::from(far) + LONGEST_SHORT
                }
                _ => high << 8 | usize::from(low),
            };
            repeat(out, at, distance + 1, length)?;
            at += length;
        }
        match next(&mut rest) {
            Some(next) => control = usize::from(next),
            None => return Some(at),
        }
    }
}

/// The first byte of `rest`, which loses it.
fn next(rest: &mut &[u8]) -> Option<u8> {
    rest.split_off_first().copied()
}

/// Writes the `length` bytes that began `distance` bytes before `at` once more.
fn repeat(out: &mut [u8], at: usize, distance: usize, length: usize) -> Option<()> {
    let from = at.checked_sub(distance)?;
    if at.checked_add(length)? > out.len() {
        return None;
    }
    // A repeat may reach into itself: then the period doubles with each copy.
    let mut done = 0;
    while done < length {
        let count = (distance + done).min(length - done);
        out.copy_within(from..from + count, at + done);
        done += count;
    }
    Some(())
}
