//! The type of the values of a dataset.

use fovol_core::{Dtype, Endian};
use hdf5_reader::Datatype;
use hdf5_reader::error::ByteOrder;

/// Values of a dataset: numbers, or short arrays of numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    /// The type of one number.
    pub dtype: Dtype,
    /// The byte order.
    pub endian: Endian,
    /// Lengths of the axes that one value has by itself.
    pub inner: Vec<usize>,
}

impl Element {
    /// The values of type `datatype`.
    ///
    /// # Errors
    /// Types that are no number, as a remark that follows "its values are".
    pub fn of(datatype: &Datatype) -> Result<Self, String> {
        let (dtype, order) = match datatype {
            Datatype::FixedPoint { size, signed, byte_order } => {
                let dtype = match (size, signed) {
                    (1, false) => Dtype::U8,
                    (1, true) => Dtype::I8,
                    (2, false) => Dtype::U16,
                    (2, true) => Dtype::I16,
                    (4, false) => Dtype::U32,
                    (4, true) => Dtype::I32,
                    (8, false) => Dtype::U64,
                    (8, true) => Dtype::I64,
                    _ => {
                        return Err(format!(
                            "integers of {size} bytes, which are not read; save them with 4"
                        ));
                    }
                };
                (dtype, byte_order)
            }
            Datatype::FloatingPoint { size, byte_order } => {
                let dtype = match size {
                    2 => Dtype::F16,
                    4 => Dtype::F32,
                    8 => Dtype::F64,
                    _ => {
                        return Err(format!(
                            "floats of {size} bytes, which are not read; save them as float64"
                        ));
                    }
                };
                (dtype, byte_order)
            }
            Datatype::Bitfield { size, byte_order } => {
                let dtype = match size {
                    1 => Dtype::U8,
                    2 => Dtype::U16,
                    4 => Dtype::U32,
                    8 => Dtype::U64,
                    _ => {
                        return Err(format!("bit fields of {size} bytes, which are not read; save integers"));
                    }
                };
                (dtype, byte_order)
            }
            Datatype::Enum { base, .. } => return Self::of(base),
            Datatype::Array { base, dims } => {
                let mut element = Self::of(base)?;
                let outer = dims.iter().map(|&length| usize::try_from(length).unwrap_or(usize::MAX));
                element.inner = outer.chain(element.inner).collect();
                return Ok(element);
            }
            Datatype::Compound { fields, .. } if is_complex(fields) => {
                return Err("complex numbers, which are not read; save their magnitude".into());
            }
            Datatype::Compound { .. } => {
                return Err("records of several fields, which are not read; save one field alone".into());
            }
            Datatype::String { .. } | Datatype::VarLen { .. } => {
                return Err("texts or lists, no numbers".into());
            }
            Datatype::Opaque { .. } | Datatype::Reference { .. } => return Err("no numbers".into()),
        };
        let endian = match order {
            ByteOrder::LittleEndian => Endian::Little,
            ByteOrder::BigEndian => Endian::Big,
        };
        Ok(Self { dtype, endian, inner: Vec::new() })
    }

    /// Bytes of one value.
    pub fn size(&self) -> usize {
        self.inner.iter().fold(self.dtype.size(), |size, &length| size.saturating_mul(length))
    }
}

/// Whether a record is a complex number, as h5py writes it.
fn is_complex(fields: &[hdf5_reader::CompoundField]) -> bool {
    matches!(fields, [real, imaginary] if real.name == "r" && imaginary.name == "i")
}

/// Whether the encoded datatype `raw` has the usual bits: IEEE floats, integers without padding.
///
/// # Errors
/// Other encodings, as a remark that follows "its values are".
pub fn check_bits(raw: &[u8], dtype: Dtype) -> Result<(), String> {
    let (Some(&[class, low, _, _]), Some(properties)) = (raw.first_chunk(), raw.get(8..)) else {
        return Ok(());
    };
    let word = |at: usize| properties.get(at..at + 2).map(|b| u16::from_le_bytes([b[0], b[1]]));
    let bits = 8 * dtype.size() as u16;
    let is_usual = match class & 0xF {
        0 | 4 => {
            let is_signed = class & 0xF == 0 && low & 8 != 0;
            word(0) == Some(0) && (!is_signed || word(2) == Some(bits))
        }
        1 => {
            let exponent = match dtype {
                Dtype::F16 => 5,
                Dtype::F32 => 8,
                _ => 11,
            };
            low & 0x40 == 0 && properties.get(5) == Some(&exponent)
        }
        _ => true,
    };
    if is_usual {
        Ok(())
    } else {
        Err("numbers in an unusual encoding, which is not read; save them as float32".into())
    }
}

/// The unsigned integer of the size of `dtype`.
pub fn unsigned(dtype: Dtype) -> Dtype {
    match dtype {
        Dtype::I8 => Dtype::U8,
        Dtype::I16 => Dtype::U16,
        Dtype::I32 => Dtype::U32,
        Dtype::I64 => Dtype::U64,
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_values_are_axes() {
        let number = Datatype::FloatingPoint { size: 4, byte_order: ByteOrder::BigEndian };
        let pair = Datatype::Array { base: Box::new(number), dims: vec![2] };
        let element = Element::of(&Datatype::Array { base: Box::new(pair), dims: vec![5] }).unwrap();
        assert_eq!(
            (element.inner.as_slice(), element.size(), element.endian),
            (&[5, 2][..], 40, Endian::Big)
        );
    }

    #[test]
    fn padded_integers_and_foreign_floats_are_refused() {
        let integer = |offset: u8, precision: u8| [0x10, 8, 0, 0, 2, 0, 0, 0, offset, 0, precision, 0];
        assert!(check_bits(&integer(0, 16), Dtype::I16).is_ok());
        assert!(check_bits(&integer(0, 12), Dtype::I16).is_err());
        assert!(check_bits(&integer(4, 16), Dtype::I16).is_err());
        let float =
            |exponent: u8| [0x11, 32, 15, 0, 2, 0, 0, 0, 0, 0, 16, 0, 10, exponent, 0, 10, 15, 0, 0, 0];
        assert!(check_bits(&float(5), Dtype::F16).is_ok());
        assert!(check_bits(&float(8), Dtype::F16).is_err());
    }
}
