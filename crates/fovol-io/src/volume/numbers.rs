//! Voxels written as text: decimal numbers or hexadecimal bytes.

use super::Source;
use crate::{Error, Result};
use fovol_core::{Dtype, f16, memory};

/// Reads `count` decimal numbers, parted by white space or commas, as little-endian `dtype`.
///
/// # Errors
/// A word that is no such number, or too few of them.
pub fn decimal(source: &Source, text: &[u8], dtype: Dtype, count: usize) -> Result<Vec<u8>> {
    // The shortest number is one digit and a blank, so the text justifies the memory.
    if count > text.len() / 2 + 1 {
        return Err(too_few(source, count, "numbers"));
    }
    let mut words =
        text.split(|byte| byte.is_ascii_whitespace() || *byte == b',').filter(|word| !word.is_empty());
    let mut out = Vec::new();
    reserve(source, &mut out, count.saturating_mul(dtype.size()))?;
    for _ in 0..count {
        let word = words.next().ok_or_else(|| too_few(source, count, "numbers"))?;
        let word = String::from_utf8_lossy(word);
        encode(&word, dtype, &mut out).ok_or_else(|| {
            let shown: String = word.chars().take(40).collect();
            source.malformed(format!("`{}` in its data is no {dtype} number", shown.escape_debug()))
        })?;
    }
    Ok(out)
}

/// Reads `count` bytes written as two hexadecimal digits each; white space does not matter.
///
/// # Errors
/// Something else than digits, or too few of them.
pub fn hexadecimal(source: &Source, text: &[u8], count: usize) -> Result<Vec<u8>> {
    if count > text.len() / 2 {
        return Err(too_few(source, count, "hexadecimal bytes"));
    }
    let mut digits = text.iter().filter(|byte| !byte.is_ascii_whitespace()).map(|&byte| {
        char::from(byte).to_digit(16).ok_or_else(|| {
            let shown = char::from(byte).escape_debug();
            source.malformed(format!("`{shown}` in its data is no hexadecimal digit"))
        })
    });
    let mut out = Vec::new();
    reserve(source, &mut out, count)?;
    for _ in 0..count {
        let mut digit = || digits.next().unwrap_or_else(|| Err(too_few(source, count, "hexadecimal bytes")));
        out.push((digit()? * 16 + digit()?) as u8);
    }
    Ok(out)
}

/// Makes room for the `count` bytes of the numbers of `source`.
fn reserve(source: &Source, out: &mut Vec<u8>, count: usize) -> Result<()> {
    let advice = "written as binary numbers, it needs no memory until it is rendered";
    memory::reserve(out, count, "its numbers", advice)
        .map_err(|shortage| Error::memory(source.path(), shortage))
}

fn too_few(source: &Source, count: usize, what: &str) -> Error {
    source.malformed(format!(
        "it holds fewer than the {count} {what} that its header promises; copy or download it again"
    ))
}

/// Appends the little-endian bytes of `word`; none when it is no number of that type.
fn encode(word: &str, dtype: Dtype, out: &mut Vec<u8>) -> Option<()> {
    macro_rules! integer {
        ($type:ty) => {{
            let value: $type = word.parse().ok().or_else(|| whole(word)?.try_into().ok())?;
            out.extend(value.to_le_bytes());
        }};
    }
    match dtype {
        Dtype::U8 => integer!(u8),
        Dtype::I8 => integer!(i8),
        Dtype::U16 => integer!(u16),
        Dtype::I16 => integer!(i16),
        Dtype::U32 => integer!(u32),
        Dtype::I32 => integer!(i32),
        Dtype::U64 => integer!(u64),
        Dtype::I64 => integer!(i64),
        Dtype::F16 => out.extend(f16::from_f64(word.parse().ok()?).to_le_bytes()),
        Dtype::F32 => out.extend(word.parse::<f32>().ok()?.to_le_bytes()),
        Dtype::F64 => out.extend(word.parse::<f64>().ok()?.to_le_bytes()),
    }
    Some(())
}

/// An integer that is written like `12.0` or `1e3`.
fn whole(word: &str) -> Option<i64> {
    let value: f64 = word.parse().ok()?;
    (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn source() -> Source {
        Source::from_bytes(Path::new("x"), vec![])
    }

    #[test]
    fn decimals_of_every_type() {
        for dtype in Dtype::ALL {
            let bytes = decimal(&source(), b" 1\n2.0,\t3e0 4", dtype, 4).unwrap();
            assert_eq!(bytes.len(), 4 * dtype.size());
        }
        assert_eq!(decimal(&source(), b"-2 7", Dtype::I16, 2).unwrap(), [0xFE, 0xFF, 7, 0]);
        assert_eq!(
            decimal(&source(), b"18446744073709551615", Dtype::U64, 1).unwrap(),
            u64::MAX.to_le_bytes()
        );
    }

    #[test]
    fn wrong_words_and_missing_ones_are_errors() {
        for (text, dtype, count) in
            [("1 300", Dtype::U8, 2), ("1 x", Dtype::F32, 2), ("1 2", Dtype::U8, 3), ("1.5", Dtype::I8, 1)]
        {
            assert!(decimal(&source(), text.as_bytes(), dtype, count).is_err(), "{text}");
        }
        assert!(decimal(&source(), b"1", Dtype::F64, usize::MAX / 8).is_err());
    }

    #[test]
    fn hexadecimal_bytes() {
        assert_eq!(hexadecimal(&source(), b"00fF\n1 0", 3).unwrap(), [0, 255, 16]);
        assert!(hexadecimal(&source(), b"0g", 1).is_err());
        assert!(hexadecimal(&source(), b"0  ", 1).is_err());
        assert!(hexadecimal(&source(), b"00", usize::MAX).is_err());
    }
}
