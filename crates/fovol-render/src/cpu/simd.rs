use super::lanes;
use std::fmt;
use std::str::FromStr;

/// The instruction set that rays are marched with.
///
/// Values other than [`Simd::Scalar`] and [`Simd::Portable`] can only be obtained where the processor
/// has the instructions: by [`Simd::best`], or by parsing, which checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Simd {
    /// Plain code: the specification.
    Scalar,
    /// 8 lanes without special instructions (NEON and others through the compiler).
    Portable,
    /// 8 lanes of AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 16 lanes of AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// The fastest one that this processor has.
    pub fn best() -> Self {
        *Self::available().last().expect("scalar is always there")
    }

    /// All that this processor has, slowest first.
    pub fn available() -> Vec<Self> {
        let mut all = vec![Self::Scalar, Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if lanes::avx2::available() {
                all.push(Self::Avx2);
            }
            if lanes::avx512::available() {
                all.push(Self::Avx512);
            }
        }
        all
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Simd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::best());
        }
        let available = Self::available();
        available.iter().copied().find(|s| s.name() == text).ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|s| s.name()).collect();
            format!(
                "`{text}` is no instruction set of this processor; use auto or one of {}",
                names.join(" ")
            )
        })
    }
}
