//! Base64 as VTK writes it: several padded pieces behind one another, white space between.

use std::io::{self, Read};

/// Decodes text as it is read; ends where the text or the base64 ends.
pub struct Base64<'a> {
    text: &'a [u8],
    /// Decoded bytes that are not read yet: the last `left` of `group`.
    group: [u8; 3],
    left: usize,
}

impl<'a> Base64<'a> {
    /// Decodes `text`.
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, group: [0; 3], left: 0 }
    }

    /// Decodes the next four characters; false at the end.
    fn refill(&mut self) -> io::Result<bool> {
        let mut digits = [0u8; 4];
        let mut count = 0;
        let mut padding = 0;
        while count + padding < 4 {
            let Some((&character, rest)) = self.text.split_first() else { break };
            // What follows the base64 of appended data is XML.
            if character == b'<' {
                break;
            }
            self.text = rest;
            match (character, DIGITS[usize::from(character)]) {
                (b'=', _) if count >= 2 => padding += 1,
                (_, digit) if digit < 64 && padding == 0 => {
                    digits[count] = digit;
                    count += 1;
                }
                _ if character.is_ascii_whitespace() => {}
                _ => return Err(io::Error::new(io::ErrorKind::InvalidData, "no base64")),
            }
        }
        let bits = digits.iter().fold(0u32, |bits, &digit| bits << 6 | u32::from(digit));
        let bytes = &bits.to_be_bytes()[1..];
        // Two digits are one byte, four are three; padding may be missing at the very end.
        let length = (count * 3) / 4;
        self.group[3 - length..].copy_from_slice(&bytes[..length]);
        self.left = length;
        Ok(length > 0)
    }
}

impl Read for Base64<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut written = 0;
        while written < out.len() {
            if self.left == 0 && !self.refill()? {
                break;
            }
            let count = self.left.min(out.len() - written);
            let from = 3 - self.left;
            out[written..written + count].copy_from_slice(&self.group[from..from + count]);
            written += count;
            self.left -= count;
        }
        Ok(written)
    }
}

/// The value of each character; 64 for those that are no digits.
const DIGITS: [u8; 256] = {
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut digits = [64; 256];
    let mut i = 0;
    while i < 64 {
        digits[alphabet[i] as usize] = i as u8;
        i += 1;
    }
    digits
};

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(text: &str) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        Base64::new(text.as_bytes()).read_to_end(&mut out).map(|_| out)
    }

    #[test]
    fn pieces_padding_and_blanks() {
        assert_eq!(decoded("aGVsbG8=").unwrap(), b"hello");
        assert_eq!(decoded(" aGVs\nbG8").unwrap(), b"hello");
        assert_eq!(decoded("aGVsbA==IQ==aGVs</A>").unwrap(), b"hell!hel");
        assert_eq!(decoded("").unwrap(), b"");
        assert_eq!(decoded("//+/").unwrap(), [0xFF, 0xFF, 0xBF]);
    }

    #[test]
    fn other_characters_are_errors() {
        for text in ["a*bc", "=abc", "a=bc", "ab=c", "\u{e9}abc"] {
            assert!(decoded(text).is_err(), "{text}");
        }
    }
}
