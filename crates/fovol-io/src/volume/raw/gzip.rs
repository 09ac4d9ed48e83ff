//! Uncompressed length of gzip files.

/// Uncompressed length that the last four `bytes` state (`ISIZE`), in bytes.
///
/// It counts only the last member, modulo 4 GiB, so it never exceeds the true length.
pub fn length(bytes: &[u8]) -> usize {
    let last = bytes.last_chunk::<4>().copied().unwrap_or_default();
    u32::from_le_bytes(last) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands_at_the_end() {
        assert_eq!(length(&[9, 9, 2, 1, 0, 0]), 258);
        assert_eq!(length(&[1]), 0);
    }
}
