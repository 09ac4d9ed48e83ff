//! PyTorch tensors: a storage of numbers, and the strides that give each element's place in it.

use half::{bf16, f16};
use std::fmt;

/// Upper limit of dimensions; no weights have more.
const MOST_DIMENSIONS: usize = 8;

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ByteOrder {
    /// Little endian: lowest byte first.
    Little,
    /// Big endian: highest byte first.
    Big,
}

/// Number type of a storage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    F64,
    F32,
    F16,
    BF16,
    /// A type that weights do not have, by the name of its storage.
    Other(&'static str),
}

impl Kind {
    /// Type of the storage class `torch.NAME`, if there is such a class.
    pub fn of_storage(name: &str) -> Option<Self> {
        const OTHERS: [&str; 13] = [
            "LongStorage",
            "IntStorage",
            "ShortStorage",
            "CharStorage",
            "ByteStorage",
            "BoolStorage",
            "ComplexFloatStorage",
            "ComplexDoubleStorage",
            "QUInt8Storage",
            "QInt8Storage",
            "QInt32Storage",
            "QUInt4x2Storage",
            "QUInt2x4Storage",
        ];
        Some(match name {
            "DoubleStorage" => Self::F64,
            "FloatStorage" => Self::F32,
            "HalfStorage" => Self::F16,
            "BFloat16Storage" => Self::BF16,
            other => Self::Other(OTHERS.into_iter().find(|known| *known == other)?),
        })
    }

    /// Size in bytes of a number; `None` for types that weights do not have.
    fn size(self) -> Option<usize> {
        match self {
            Self::F64 => Some(8),
            Self::F32 => Some(4),
            Self::F16 | Self::BF16 => Some(2),
            Self::Other(_) => None,
        }
    }

    /// Decodes one number. `bytes` has exactly its size, lowest byte first.
    fn number(self, bytes: &[u8]) -> Option<f32> {
        Some(match self {
            Self::F64 => f64::from_le_bytes(bytes.try_into().ok()?) as f32,
            Self::F32 => f32::from_le_bytes(bytes.try_into().ok()?),
            Self::F16 => f16::from_le_bytes(bytes.try_into().ok()?).to_f32(),
            Self::BF16 => bf16::from_le_bytes(bytes.try_into().ok()?).to_f32(),
            Self::Other(_) => return None,
        })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F64 => "DoubleStorage",
            Self::F32 => "FloatStorage",
            Self::F16 => "HalfStorage",
            Self::BF16 => "BFloat16Storage",
            Self::Other(name) => name,
        })
    }
}

/// An array of numbers of one type, in its own file of the archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Storage {
    /// Number type.
    pub kind: Kind,
    /// Name of its file.
    pub key: u64,
    /// Number of elements.
    pub length: usize,
}

impl Storage {
    /// Whether weights can have this number type.
    pub fn is_readable(&self) -> bool {
        self.kind.size().is_some()
    }

    /// Size in bytes. `None` for types that weights do not have, and on overflow.
    pub fn bytes(&self) -> Option<usize> {
        self.kind.size()?.checked_mul(self.length)
    }
}

/// A tensor: element \[i, j, …\] is number `offset` + i·strides\[0\] + j·strides\[1\] + … of its storage.
#[derive(Debug, Clone)]
pub struct View {
    /// Storage of the elements.
    pub storage: Storage,
    offset: usize,
    shape: Vec<usize>,
    strides: Vec<usize>,
}

impl View {
    /// Makes a tensor. `None` if it does not lie within its storage.
    pub fn new(storage: Storage, offset: usize, shape: Vec<usize>, strides: Vec<usize>) -> Option<Self> {
        if shape.len() != strides.len() || shape.len() > MOST_DIMENSIONS {
            return None;
        }
        shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n))?;
        if !shape.contains(&0) {
            let steps = shape.iter().zip(&strides).map(|(&n, &stride)| (n - 1).checked_mul(stride));
            let last = steps.into_iter().try_fold(offset, |at, step| at.checked_add(step?))?;
            if last >= storage.length {
                return None;
            }
        }
        Some(Self { storage, offset, shape, strides })
    }

    /// Lengths of the dimensions, slowest first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Collects the elements in row-major order from the `bytes` of the whole storage. `None` if `bytes` is too
    /// short, or if weights do not have the number type.
    pub fn gather(&self, bytes: &[u8], order: ByteOrder) -> Option<Vec<f32>> {
        let size = self.storage.kind.size()?;
        let count: usize = self.shape.iter().product();
        let number = |i| {
            let start = self.position(i) * size;
            let mut number = [0; 8];
            let number = number.get_mut(..size)?;
            number.copy_from_slice(bytes.get(start..start + size)?);
            if order == ByteOrder::Big {
                number.reverse();
            }
            self.storage.kind.number(number)
        };
        (0..count).map(number).collect()
    }

    /// Index in the storage of element `i` in row-major order.
    fn position(&self, mut i: usize) -> usize {
        let mut at = self.offset;
        for (&n, &stride) in self.shape.iter().zip(&self.strides).rev() {
            at += i % n * stride;
            i /= n;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(offset: usize, shape: &[usize], strides: &[usize]) -> Option<View> {
        let storage = Storage { kind: Kind::F32, key: 0, length: 24 };
        View::new(storage, offset, shape.into(), strides.into())
    }

    #[test]
    fn strides_and_offsets_are_followed() {
        let bytes: Vec<u8> = (0..24u8).flat_map(|i| f32::from(i).to_le_bytes()).collect();
        let values = |offset, shape: &[usize], strides: &[usize]| {
            view(offset, shape, strides).unwrap().gather(&bytes, ByteOrder::Little).unwrap()
        };
        assert_eq!(values(0, &[2, 3], &[3, 1]), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(values(0, &[3, 2], &[1, 3]), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
        assert_eq!(values(8, &[2, 2], &[14, 1]), [8.0, 9.0, 22.0, 23.0]);
        assert_eq!(values(23, &[], &[]), [23.0]);
        assert!(values(99, &[2, 0], &[1, 1]).is_empty());
        assert_eq!(values(5, &[3], &[0]), [5.0; 3]);
    }

    #[test]
    fn tensors_outside_their_storage_are_none() {
        assert!(view(23, &[1], &[usize::MAX]).is_some());
        for (offset, shape, strides) in [
            (24, &[][..], &[][..]),
            (9, &[2, 2], &[14, 1]),
            (0, &[2], &[24]),
            (0, &[2], &[1, 1]),
            (0, &[usize::MAX, 2], &[0, 0]),
            (1, &[3], &[usize::MAX]),
            (0, &[2, 2], &[usize::MAX, 1]),
            (0, &[1; 9], &[1; 9]),
        ] {
            assert!(view(offset, shape, strides).is_none(), "{offset} {shape:?} {strides:?}");
        }
    }

    #[test]
    fn numbers_of_every_kind_and_byte_order_are_read() {
        let read = |kind, bytes: &[u8], order| {
            let storage = Storage { kind, key: 0, length: 1 };
            View::new(storage, 0, vec![], vec![]).unwrap().gather(bytes, order)
        };
        for (kind, bytes) in [
            (Kind::F64, &(-1.5f64).to_be_bytes()[..]),
            (Kind::F32, &(-1.5f32).to_be_bytes()),
            (Kind::F16, &f16::from_f32(-1.5).to_be_bytes()),
            (Kind::BF16, &bf16::from_f32(-1.5).to_be_bytes()),
        ] {
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(read(kind, bytes, ByteOrder::Big), Some(vec![-1.5]));
            assert_eq!(read(kind, &reversed, ByteOrder::Little), Some(vec![-1.5]));
            assert_eq!(read(kind, &bytes[1..], ByteOrder::Big), None);
        }
        assert_eq!(read(Kind::Other("LongStorage"), &[0; 8], ByteOrder::Little), None);
    }
}
