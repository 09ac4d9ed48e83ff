//! Types of values and the value of chunks that are not stored.

use fovol_core::{Dtype, Endian, f16};
use serde_json::Value;

/// The type of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    /// The type.
    pub dtype: Dtype,
    /// The byte order.
    pub endian: Endian,
}

impl Element {
    /// A little-endian element.
    pub fn little(dtype: Dtype) -> Self {
        Self { dtype, endian: Endian::Little }
    }

    /// Bytes of a value.
    pub fn size(self) -> usize {
        self.dtype.size()
    }
}

/// The type that version 2 calls `name`, such as `<u2`.
pub fn of_v2(name: &Value) -> Result<Element, String> {
    let text = name.as_str().unwrap_or("a structure");
    let unknown = || format!("has values of type {text}, which are not read; write numbers");
    if !text.is_ascii() || text.len() < 3 {
        return Err(unknown());
    }
    let endian = if text.starts_with('>') { Endian::Big } else { Endian::Little };
    let dtype = match &text[1..] {
        "b1" | "u1" => Dtype::U8,
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
        _ => return Err(unknown()),
    };
    Ok(Element { dtype, endian })
}

/// The type that version 3 calls `name`, such as `uint16`.
pub fn of_v3(name: &Value) -> Result<Dtype, String> {
    let text = name.as_str().or_else(|| name.get("name")?.as_str()).unwrap_or("a structure");
    Ok(match text {
        "bool" | "uint8" => Dtype::U8,
        "int8" => Dtype::I8,
        "uint16" => Dtype::U16,
        "int16" => Dtype::I16,
        "uint32" => Dtype::U32,
        "int32" => Dtype::I32,
        "uint64" => Dtype::U64,
        "int64" => Dtype::I64,
        "float16" => Dtype::F16,
        "float32" => Dtype::F32,
        "float64" => Dtype::F64,
        _ => return Err(format!("has values of type {text}, which are not read; write numbers")),
    })
}

/// The type that numcodecs calls `name`: in the words of NumPy, `<u2` or `uint16`.
pub fn of_numpy(name: &Value) -> Result<Element, String> {
    of_v2(name).or_else(|problem| of_v3(name).map(Element::little).map_err(|_| problem))
}

/// The bytes of the fill value `value`; zero where there is none.
pub fn fill(value: Option<&Value>, element: Element) -> Result<Vec<u8>, String> {
    let mut bytes = match value {
        None | Some(Value::Null) => vec![0; element.size()],
        Some(value) => encoded(value, element.dtype).ok_or_else(|| {
            format!("has the fill value {value}, which is no {}; write it again", element.dtype)
        })?,
    };
    if element.endian == Endian::Big {
        bytes.reverse();
    }
    Ok(bytes)
}

/// The little-endian bytes of `value`.
fn encoded(value: &Value, dtype: Dtype) -> Option<Vec<u8>> {
    macro_rules! integer {
        ($type:ty) => {
            <$type>::try_from(whole(value)?).ok()?.to_le_bytes().to_vec()
        };
    }
    // Version 3 may write the bits of a float, most significant digit first.
    if let Some(digits) = value.as_str().and_then(|text| text.strip_prefix("0x")) {
        let bits = u64::from_str_radix(digits, 16).ok()?;
        let fits = digits.len() == 2 * dtype.size();
        return fits.then(|| bits.to_le_bytes()[..dtype.size()].to_vec());
    }
    Some(match dtype {
        Dtype::U8 => integer!(u8),
        Dtype::I8 => integer!(i8),
        Dtype::U16 => integer!(u16),
        Dtype::I16 => integer!(i16),
        Dtype::U32 => integer!(u32),
        Dtype::I32 => integer!(i32),
        Dtype::U64 => integer!(u64),
        Dtype::I64 => integer!(i64),
        Dtype::F16 => f16::from_f64(real(value)?).to_le_bytes().to_vec(),
        Dtype::F32 => (real(value)? as f32).to_le_bytes().to_vec(),
        Dtype::F64 => real(value)?.to_le_bytes().to_vec(),
    })
}

fn whole(value: &Value) -> Option<i128> {
    match value {
        Value::Bool(is_set) => Some(i128::from(*is_set)),
        Value::Number(number) => {
            let exact = number.as_u64().map(i128::from).or_else(|| number.as_i64().map(i128::from));
            exact.or_else(|| number.as_f64().filter(|real| real.fract() == 0.0).map(|real| real as i128))
        }
        _ => None,
    }
}

fn real(value: &Value) -> Option<f64> {
    match value.as_str() {
        Some("NaN") => Some(f64::NAN),
        Some("Infinity") => Some(f64::INFINITY),
        Some("-Infinity") => Some(f64::NEG_INFINITY),
        Some(_) => None,
        None => value.as_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn filled(value: &Value, dtype: Dtype, endian: Endian) -> Result<Vec<u8>, String> {
        fill(Some(value), Element { dtype, endian })
    }

    #[test]
    fn fill_values_of_all_kinds() {
        for (value, dtype, endian, expected) in [
            (json!(-2), Dtype::I16, Endian::Big, &[0xFF, 0xFE][..]),
            (json!(7.0), Dtype::U16, Endian::Little, &[7, 0]),
            (json!(null), Dtype::F32, Endian::Little, &[0; 4]),
            (json!("0x7fc00001"), Dtype::F32, Endian::Little, &[1, 0, 0xC0, 0x7F]),
            (json!("-Infinity"), Dtype::F16, Endian::Big, &[0xFC, 0]),
            (json!(true), Dtype::U8, Endian::Little, &[1]),
            (json!(u64::MAX), Dtype::U64, Endian::Little, &[0xFF; 8]),
        ] {
            assert_eq!(filled(&value, dtype, endian).unwrap(), expected, "{value}");
        }
        for (value, dtype) in [(json!(300), Dtype::U8), (json!("x"), Dtype::F32), (json!([1]), Dtype::I8)] {
            assert!(filled(&value, dtype, Endian::Little).is_err(), "{value}");
        }
    }

    #[test]
    fn types_that_are_no_numbers_are_named() {
        for name in [json!("<c8"), json!("|S4"), json!([["a", "<f4"]]), json!("µµ"), json!("<")] {
            assert!(of_v2(&name).unwrap_err().contains("which are not read"), "{name}");
        }
        assert!(of_v3(&json!({"name": "numpy.datetime64"})).unwrap_err().contains("datetime64"));
    }
}
