//! Lines of text with blocks of binary data between them.

/// A place in a file.
#[derive(Debug, Clone, Copy)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Keywords and what follows them are shorter; of longer lines the start is seen.
const LONGEST_LINE: usize = 1 << 10;

impl<'a> Cursor<'a> {
    /// The start of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The number of bytes before this place.
    pub fn at(&self) -> usize {
        self.at
    }

    /// The words of the next line, empty or not; none at the end.
    pub fn line(&mut self) -> Option<Vec<String>> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |end| end + 1);
        self.at += length;
        let text = String::from_utf8_lossy(&rest[..length.min(LONGEST_LINE)]);
        Some(text.split_whitespace().map(str::to_owned).collect())
    }

    /// The words of the next line that has some; none at the end.
    pub fn words(&mut self) -> Option<Vec<String>> {
        loop {
            let words = self.line()?;
            if !words.is_empty() {
                return Some(words);
            }
        }
    }

    /// Passes over `count` bytes; none when there are fewer.
    pub fn skip_bytes(&mut self, count: usize) -> Option<()> {
        self.at = self.at.checked_add(count).filter(|&at| at <= self.bytes.len())?;
        Some(())
    }

    /// Passes over `count` values, binary ones of `size` bytes or words of text; none when there are fewer.
    pub fn skip_values(&mut self, count: usize, size: Option<usize>) -> Option<()> {
        match size {
            Some(size) => self.skip_bytes(count.saturating_mul(size)),
            None => self.skip_words(count),
        }
    }

    /// Passes over the lines of metadata; an empty line ends them.
    pub fn skip_metadata(&mut self) {
        while self.line().is_some_and(|words| !words.is_empty()) {}
    }

    /// The line before the values of an array in a field; none at the end.
    pub fn field_words(&mut self) -> Option<Vec<String>> {
        loop {
            let words = self.words()?;
            match words[0].as_str() {
                "METADATA" => self.skip_metadata(),
                _ => return Some(words),
            }
        }
    }

    /// Passes over `count` words; none when there are fewer.
    pub fn skip_words(&mut self, count: usize) -> Option<()> {
        for _ in 0..count {
            let rest = &self.bytes[self.at..];
            let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
            let length = rest[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            self.at += start + length;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_words_and_bytes() {
        let mut cursor = Cursor::new(b"A b\n\n  \r\nC\n\x00\n12 3\n4 end");
        assert_eq!(cursor.words().unwrap(), ["A", "b"]);
        assert_eq!(cursor.words().unwrap(), ["C"]);
        cursor.skip_bytes(2).unwrap();
        cursor.skip_words(3).unwrap();
        assert_eq!(cursor.words().unwrap(), ["end"]);
        assert!(cursor.words().is_none() && cursor.skip_words(1).is_none() && cursor.skip_bytes(1).is_none());
        assert!(cursor.skip_bytes(usize::MAX).is_none());
    }
}
