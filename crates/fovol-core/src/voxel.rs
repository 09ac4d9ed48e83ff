use half::f16;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Type of one voxel component in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dtype {
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 16-bit integer.
    U16,
    /// Signed 16-bit integer.
    I16,
    /// Unsigned 32-bit integer.
    U32,
    /// Signed 32-bit integer.
    I32,
    /// Unsigned 64-bit integer.
    U64,
    /// Signed 64-bit integer.
    I64,
    /// IEEE half precision.
    F16,
    /// IEEE single precision.
    F32,
    /// IEEE double precision.
    F64,
}

impl Dtype {
    /// Every type, smallest first.
    pub const ALL: [Self; 11] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::F16,
        Self::U32,
        Self::I32,
        Self::F32,
        Self::U64,
        Self::I64,
        Self::F64,
    ];

    /// Bytes per component.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Whether values are integers.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// Short name: `u8` … `f64`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F16 => "f16",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

impl fmt::Display for Dtype {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Dtype {
    type Err = String;

    /// Parses `u8` … `f64` and common long names: `uint8`, `int16`, `float32`, `float`, `double`, `uchar`…
    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text.trim().to_ascii_lowercase().as_str() {
            "u8" | "uint8" | "uchar" | "byte" => Self::U8,
            "i8" | "int8" | "char" | "schar" => Self::I8,
            "u16" | "uint16" | "ushort" => Self::U16,
            "i16" | "int16" | "short" => Self::I16,
            "u32" | "uint32" | "uint" => Self::U32,
            "i32" | "int32" | "int" => Self::I32,
            "u64" | "uint64" => Self::U64,
            "i64" | "int64" => Self::I64,
            "f16" | "float16" | "half" => Self::F16,
            "f32" | "float32" | "float" => Self::F32,
            "f64" | "float64" | "double" => Self::F64,
            other => {
                return Err(format!(
                    "`{other}` is no voxel type; use one of u8 i8 u16 i16 u32 i32 u64 i64 f16 f32 f64"
                ));
            }
        })
    }
}

/// Byte order of multi-byte components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

impl FromStr for Endian {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().to_ascii_lowercase().as_str() {
            "little" | "lsb" => Ok(Self::Little),
            "big" | "msb" => Ok(Self::Big),
            other => Err(format!("`{other}` is no byte order; use little or big")),
        }
    }
}

/// Rust type of a voxel component.
pub trait Voxel: Copy + Send + Sync + 'static {
    /// Matching [`Dtype`].
    const DTYPE: Dtype;

    /// Decodes one component from exactly `DTYPE.size()` bytes.
    fn decode(bytes: &[u8], endian: Endian) -> Self;

    /// Converts to f64; 64-bit integers are rounded to nearest.
    fn to_f64(self) -> f64;

    /// Nearest representable value; saturates at the least and greatest.
    fn from_f64(value: f64) -> Self;
}

macro_rules! voxel {
    ($($rust:ty, $dtype:ident, |$v:ident| $to:expr, |$f:ident| $from:expr;)*) => {$(
        impl Voxel for $rust {
            const DTYPE: Dtype = Dtype::$dtype;

            #[inline(always)]
            fn decode(bytes: &[u8], endian: Endian) -> Self {
                let bytes = bytes.try_into().expect("callers pass exactly one component");
                match endian {
                    Endian::Little => <$rust>::from_le_bytes(bytes),
                    Endian::Big => <$rust>::from_be_bytes(bytes),
                }
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                let $v = self;
                $to
            }

            #[inline(always)]
            fn from_f64($f: f64) -> Self {
                $from
            }
        }
    )*};
}

voxel! {
    u8, U8, |v| f64::from(v), |f| f.round() as u8;
    i8, I8, |v| f64::from(v), |f| f.round() as i8;
    u16, U16, |v| f64::from(v), |f| f.round() as u16;
    i16, I16, |v| f64::from(v), |f| f.round() as i16;
    u32, U32, |v| f64::from(v), |f| f.round() as u32;
    i32, I32, |v| f64::from(v), |f| f.round() as i32;
    u64, U64, |v| v as f64, |f| f.round() as u64;
    i64, I64, |v| v as f64, |f| f.round() as i64;
    f16, F16, |v| v.to_f64(), |f| f16::from_f64(f);
    f32, F32, |v| f64::from(v), |f| f as f32;
    f64, F64, |v| v, |f| f;
}

/// Runs `$body` with `$T` bound to the Rust type of a [`Dtype`].
#[macro_export]
macro_rules! with_voxel_type {
    ($dtype:expr, $T:ident => $body:expr) => {
        match $dtype {
            $crate::Dtype::U8 => {
                type $T = u8;
                $body
            }
            $crate::Dtype::I8 => {
                type $T = i8;
                $body
            }
            $crate::Dtype::U16 => {
                type $T = u16;
                $body
            }
            $crate::Dtype::I16 => {
                type $T = i16;
                $body
            }
            $crate::Dtype::U32 => {
                type $T = u32;
                $body
            }
            $crate::Dtype::I32 => {
                type $T = i32;
                $body
            }
            $crate::Dtype::U64 => {
                type $T = u64;
                $body
            }
            $crate::Dtype::I64 => {
                type $T = i64;
                $body
            }
            $crate::Dtype::F16 => {
                type $T = $crate::f16;
                $body
            }
            $crate::Dtype::F32 => {
                type $T = f32;
                $body
            }
            $crate::Dtype::F64 => {
                type $T = f64;
                $body
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for dtype in Dtype::ALL {
            assert_eq!(dtype.name().parse(), Ok(dtype));
            let size = with_voxel_type!(dtype, T => size_of::<T>());
            assert_eq!(size, dtype.size());
        }
        assert!("complex".parse::<Dtype>().is_err());
    }

    #[test]
    fn byte_order_matters() {
        assert_eq!(i16::decode(&[0x01, 0x02], Endian::Little), 0x0201);
        assert_eq!(i16::decode(&[0x01, 0x02], Endian::Big), 0x0102);
        assert_eq!(f16::decode(&f16::from_f32(1.5).to_be_bytes(), Endian::Big).to_f64(), 1.5);
    }
}
