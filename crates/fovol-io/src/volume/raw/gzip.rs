//! What a gzip file says of its length.

/// The length of what is packed in `bytes`, as far as their last four bytes say: of its last member, modulo 4 GiB, so never more
/// than there is.
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
