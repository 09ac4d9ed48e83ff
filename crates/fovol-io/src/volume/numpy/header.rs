//! The header of a `.npy` file: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use fovol_core::{Dtype, Endian};

/// First bytes of a `.npy` file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest header that is read. NumPy itself refuses to parse more than 10,000 bytes.
const LONGEST: usize = 1 << 20;

/// Description of the values of a `.npy` file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// The type of one value.
    pub dtype: Dtype,
    /// The byte order.
    pub endian: Endian,
    /// Whether the first axis is the fastest.
    pub is_fortran: bool,
    /// Lengths of the axes.
    pub shape: Vec<usize>,
    /// Position of the first value in the file.
    pub offset: usize,
}

/// Number of bytes from the start of the file to the first value, which the first ten or twelve `bytes` state.
///
/// # Errors
/// No `.npy` file, or an unknown version, as a remark that follows "it".
pub fn length(bytes: &[u8]) -> Result<usize, String> {
    let short = || "ends in its NumPy header; copy or download it again".to_owned();
    if !bytes.starts_with(MAGIC) {
        return Err("does not begin like a .npy file; save it again with numpy.save".into());
    }
    let (before, stated) = match *bytes.get(6).ok_or_else(short)? {
        1 => (10, bytes.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))),
        2 | 3 => (12, bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)),
        version => {
            return Err(format!("has version {version} of the .npy format; save it with NumPy 1 or 2"));
        }
    };
    let stated = stated.ok_or_else(short)?;
    if stated > LONGEST {
        return Err(format!("states a NumPy header of {stated} bytes; is it damaged?"));
    }
    Ok(before + stated)
}

/// Parses the header at the start of `bytes`.
///
/// # Errors
/// Damage, and types that are no single number, as a remark that follows "it".
pub fn parse(bytes: &[u8]) -> Result<Header, String> {
    let offset = length(bytes)?;
    let start = if bytes[6] == 1 { 10 } else { 12 };
    let text = bytes
        .get(start..offset)
        .ok_or_else(|| "ends in its NumPy header; copy or download it again".to_owned())?;
    let text = String::from_utf8_lossy(text);
    let (dtype, endian) = scalar(value(&text, "descr")?)?;
    let order = value(&text, "fortran_order")?;
    let is_fortran = match order {
        _ if order.starts_with("True") => true,
        _ if order.starts_with("False") => false,
        _ => return Err("has a header without True or False for fortran_order; is it damaged?".into()),
    };
    Ok(Header { dtype, endian, is_fortran, shape: shape(value(&text, "shape")?)?, offset })
}

/// The text after `'key':` in the dictionary `text`.
fn value<'a>(text: &'a str, key: &str) -> Result<&'a str, String> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let after = quoted.iter().find_map(|key| text.split_once(key.as_str()).map(|(_, after)| after));
    let after = after.and_then(|after| after.trim_start().strip_prefix(':'));
    after.map(str::trim_start).ok_or_else(|| format!("has a header without `{key}`; is it damaged?"))
}

/// The type that begins `text`, a quoted code such as `'<f4'`.
fn scalar(text: &str) -> Result<(Dtype, Endian), String> {
    if text.starts_with('[') {
        return Err("holds records of several fields, which are not read; save one field: a['name']".into());
    }
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    let code = quote.and_then(|quote| text[1..].split_once(quote)).map(|(code, _)| code);
    let code = code.ok_or("has a header without a type in quotes; is it damaged?")?;
    let (endian, kind) = match code.split_at_checked(1) {
        Some((">", kind)) => (Endian::Big, kind),
        Some(("<" | "|" | "=", kind)) => (Endian::Little, kind),
        _ => (Endian::Little, code),
    };
    let dtype = match kind {
        "b1" | "?" | "u1" => Dtype::U8,
        "i1" => Dtype::I8,
        "u2" => Dtype::U16,
        "i2" => Dtype::I16,
        "u4" => Dtype::U32,
        "i4" => Dtype::I32,
        "u8" => Dtype::U64,
        "i8" => Dtype::I64,
        "f2" => Dtype::F16,
        "f4" => Dtype::F32,
        "f8" => Dtype::F64,
        _ => return Err(refusal(kind)),
    };
    Ok((dtype, endian))
}

/// Advice for a type that is not read.
fn refusal(kind: &str) -> String {
    let shown: String = kind.chars().take(20).collect();
    match kind.as_bytes().first() {
        Some(b'c') => "holds complex numbers, which are not read; save abs(a), a.real or a.imag".into(),
        Some(b'f') => format!("holds {shown} numbers, which are not read; save a.astype('f8')"),
        Some(b'O') => {
            "holds Python objects, which are not read; save a.astype('f4') or another number".into()
        }
        _ => format!("holds `{shown}` values, which are no numbers; save a.astype('f4') or another number"),
    }
}

/// The tuple of lengths that begins `text`.
fn shape(text: &str) -> Result<Vec<usize>, String> {
    let inside = text.strip_prefix('(').and_then(|text| text.split_once(')')).map(|(inside, _)| inside);
    let inside = inside.ok_or("has a header without a shape in brackets; is it damaged?")?;
    let words = inside.split(',').map(str::trim).filter(|word| !word.is_empty());
    words
        .map(|word| {
            // Python 2 marks long numbers so.
            word.trim_end_matches('L').parse().map_err(|_| {
                let shown: String = word.chars().take(20).collect();
                format!("has `{shown}` in the shape of its header; is it damaged?")
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, header: &str) -> Vec<u8> {
        let length = header.len() as u32;
        let width = if version == 1 { 2 } else { 4 };
        [MAGIC, &[version, 0], &length.to_le_bytes()[..width], header.as_bytes()].concat()
    }

    #[test]
    fn headers_of_every_version() {
        let text = "{'descr': '>i2', 'fortran_order': True, 'shape': (3, 4L, 5), }   \n";
        for version in 1..=3 {
            let header = parse(&file(version, text)).unwrap();
            assert_eq!((header.dtype, header.endian), (Dtype::I16, Endian::Big));
            assert_eq!((header.is_fortran, header.shape), (true, vec![3, 4, 5]));
        }
        assert!(parse(&file(4, text)).unwrap_err().contains("version 4"));
    }

    #[test]
    fn kinds_that_are_no_number_get_advice() {
        for (descr, advice) in [
            ("'<c16'", "abs(a)"),
            ("'|O'", "objects"),
            ("'<f16'", "astype('f8')"),
            ("'<U3'", "no numbers"),
            ("[('a', '<f4'), ('b', '<i4')]", "fields"),
        ] {
            let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (3,), }}\n");
            let problem = parse(&file(1, &text)).unwrap_err();
            assert!(problem.contains(advice), "{problem}");
        }
    }

    #[test]
    fn damaged_headers_are_errors() {
        for text in [
            "",
            "{}",
            "{'descr': '<f4'}",
            "{'descr': <f4, 'fortran_order': False, 'shape': (3,)}",
            "{'descr': '<f4', 'fortran_order': 1, 'shape': (3,)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3, -1)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': 3}",
        ] {
            assert!(parse(&file(1, text)).is_err(), "{text}");
        }
        assert!(parse(MAGIC).is_err());
        assert!(parse(&[MAGIC, &[2, 0, 255, 255, 255, 255]].concat()).is_err());
    }
}
