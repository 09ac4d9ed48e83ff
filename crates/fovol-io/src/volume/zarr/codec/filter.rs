//! Changes of values before they are packed, by the names of numcodecs.
//! <https://numcodecs.readthedocs.io/en/stable/>.

use crate::volume::reals;
use crate::volume::zarr::element::Element;
use fovol_core::{Dtype, Endian};
use serde_json::Value;

/// A change of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// Values were rounded, and are taken as they are.
    Rounded(Element),
    /// Differences to the value before.
    Delta { stored: Element, values: Element },
    /// (value − offset) · scale, rounded.
    Scaled { stored: Element, values: Element, scale: f64, offset: f64 },
    /// Eight truth values in a byte, behind the number of unused bits.
    Bits,
}

/// Parses the name of a type.
type Parse = fn(&Value) -> Result<Element, String>;

impl Filter {
    /// The filter `name`; none if it is no filter of values.
    ///
    /// # Errors
    /// A configuration that makes no sense.
    pub fn of(name: &str, said: &Value, element: Element, parse: Parse) -> Result<Option<Self>, String> {
        let number = |key: &str| said.get(key).and_then(Value::as_f64);
        let values = said.get("dtype").map_or(Ok(element), parse);
        let stored =
            |values: Element| said.get("astype").filter(|name| !name.is_null()).map_or(Ok(values), parse);
        Ok(Some(match name {
            "quantize" | "bitround" => Self::Rounded(element),
            "delta" => Self::Delta { stored: stored(values.clone()?)?, values: values? },
            "fixedscaleoffset" => Self::Scaled {
                stored: stored(values.clone()?)?,
                values: values?,
                scale: number("scale").filter(|scale| *scale != 0.0).ok_or("has a filter without a scale")?,
                offset: number("offset").unwrap_or(0.0),
            },
            "packbits" => Self::Bits,
            _ => return Ok(None),
        }))
    }

    /// Values in `length` decoded bytes.
    pub fn values(self, length: usize) -> usize {
        match self {
            Self::Bits => length,
            Self::Rounded(values) | Self::Delta { values, .. } | Self::Scaled { values, .. } => {
                length / values.size()
            }
        }
    }

    /// Bytes from which `length` bytes are decoded.
    pub fn stored_length(self, length: usize) -> usize {
        match self {
            Self::Rounded(_) => length,
            Self::Delta { stored, values } | Self::Scaled { stored, values, .. } => {
                length / values.size() * stored.size()
            }
            Self::Bits => length.div_ceil(8) + 1,
        }
    }

    /// Replaces `out` by the values that `bytes` were made from.
    ///
    /// # Errors
    /// What is wrong with `bytes`.
    pub fn decode(self, bytes: &[u8], out: &mut Vec<u8>) -> Result<(), String> {
        out.clear();
        match self {
            Self::Rounded(_) => out.extend_from_slice(bytes),
            Self::Delta { stored, values } => match stored.dtype {
                Dtype::F16 | Dtype::F32 | Dtype::F64 => summed_reals(bytes, stored, values, out),
                _ => summed_integers(bytes, stored, values, out),
            },
            Self::Scaled { stored, values, scale, offset } => {
                // numcodecs computes in single precision if the stored values have it.
                let is_single = matches!(stored.dtype, Dtype::F16 | Dtype::F32);
                reals::for_each(bytes, stored.dtype, stored.endian, |value| {
                    let value = match is_single {
                        true => f64::from(value as f32 / scale as f32 + offset as f32),
                        false => value / scale + offset,
                    };
                    write_real(value, values, out);
                });
            }
            Self::Bits => {
                let (&unused, packed) = bytes.split_first().ok_or("it is too short")?;
                let bits = packed.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
                let count = (8 * packed.len()).saturating_sub(usize::from(unused));
                out.extend(bits.take(count));
            }
        }
        Ok(())
    }
}

/// Appends `value`, cut to a whole number where `element` is one, and wrapped around as NumPy does.
fn write_real(value: f64, element: Element, out: &mut Vec<u8>) {
    match element.dtype {
        Dtype::F16 => write(&fovol_core::f16::from_f64(value).to_le_bytes(), element, out),
        Dtype::F32 => write(&(value as f32).to_le_bytes(), element, out),
        Dtype::F64 => write(&value.to_le_bytes(), element, out),
        _ => write(&(value as i128).to_le_bytes()[..element.size()], element, out),
    }
}

/// Appends the little-endian `bytes` of a value in the order of `element`.
fn write(bytes: &[u8], element: Element, out: &mut Vec<u8>) {
    match element.endian {
        Endian::Little => out.extend_from_slice(bytes),
        Endian::Big => out.extend(bytes.iter().rev()),
    }
}

fn summed_reals(bytes: &[u8], stored: Element, values: Element, out: &mut Vec<u8>) {
    let mut sum = 0.0;
    reals::for_each(bytes, stored.dtype, stored.endian, |difference| {
        sum += difference;
        // The sum is rounded at each step.
        sum = match values.dtype {
            Dtype::F16 => fovol_core::f16::from_f64(sum).to_f64(),
            Dtype::F32 => f64::from(sum as f32),
            _ => sum,
        };
        write_real(sum, values, out);
    });
}

fn summed_integers(bytes: &[u8], stored: Element, values: Element, out: &mut Vec<u8>) {
    let mut sum = 0u64;
    for value in bytes.chunks_exact(stored.size()) {
        sum = sum.wrapping_add(wide(value, stored));
        match values.dtype {
            Dtype::F16 | Dtype::F32 | Dtype::F64 => write_real(sum as i64 as f64, values, out),
            _ => write(&sum.to_le_bytes()[..values.size()], values, out),
        }
    }
}

/// The integer in `bytes`, its sign kept.
fn wide(bytes: &[u8], element: Element) -> u64 {
    let ordered = |place: usize| match element.endian {
        Endian::Little => bytes[place],
        Endian::Big => bytes[bytes.len() - 1 - place],
    };
    let is_signed = matches!(element.dtype, Dtype::I8 | Dtype::I16 | Dtype::I32 | Dtype::I64);
    let is_negative = is_signed && ordered(bytes.len() - 1) >= 0x80;
    let filled = if is_negative { u8::MAX } else { 0 };
    u64::from_le_bytes(std::array::from_fn(|place| if place < bytes.len() { ordered(place) } else { filled }))
}
