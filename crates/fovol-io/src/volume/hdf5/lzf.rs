//! LZF, the compression that h5py has of its own: <https://docs.h5py.org/en/stable/high/dataset.html#lossless-compression-filters>.

use hdf5_reader::error::{Error, Result};
use hdf5_reader::messages::filter_pipeline::FilterDescription;

/// Its number among HDF5's filters.
pub const FILTER: u16 = 32000;

/// One byte of LZF stands for so many at most.
const BYTES_PER_BYTE: usize = 264;

/// Unpacks one chunk, whose length stands among the parameters of `filter`.
///
/// # Errors
/// Damaged data.
pub fn unpacked(filter: &FilterDescription, data: &[u8]) -> Result<Vec<u8>> {
    let length = filter.client_data.get(2).map_or(0, |&length| length as usize);
    if length > data.len().saturating_mul(BYTES_PER_BYTE) {
        return Err(damaged());
    }
    decompress(data, length).ok_or_else(damaged)
}

fn damaged() -> Error {
    Error::DecompressionError("LZF data".into())
}

/// Unpacks `data`, which must give `length` bytes.
fn decompress(mut data: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(length);
    while let [control, rest @ ..] = data {
        let control = usize::from(*control);
        data = rest;
        if control < 32 {
            let (plain, rest) = data.split_at_checked(control + 1)?;
            out.extend_from_slice(plain);
            data = rest;
        } else {
            let mut count = control >> 5;
            if count == 7 {
                count += usize::from(*data.split_off_first()?);
            }
            let back = (control & 31) << 8 | usize::from(*data.split_off_first()?);
            let from = out.len().checked_sub(back + 1)?;
            // The copy may read bytes that it has just written.
            (from..from + count + 2).for_each(|at| out.push(out[at]));
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_and_plain_bytes() {
        assert_eq!(decompress(b"\x02abc\x20\x02", 6).unwrap(), b"abcabc");
        assert_eq!(decompress(b"\x00x\xe0\x01\x00", 11).unwrap(), b"xxxxxxxxxxx");
    }

    #[test]
    fn damage_is_noticed() {
        for (data, length) in [(&b"\x02ab"[..], 3), (b"\x00x\x20\x05", 4), (b"\x00x\xe0", 9), (b"\x00x", 2)] {
            assert_eq!(decompress(data, length), None);
        }
    }
}
