use super::conv::{self, Arithmetic, Kernel};
use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

/// Instruction set that networks run on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Simd {
    /// Plain code, vectorised by the compiler for the baseline processor.
    Portable,
    /// AVX2 and FMA: vectors of 256 bits.
    Avx2,
    /// AVX-512 (F, BW, DQ, VL): vectors of 512 bits.
    Avx512,
    /// AVX-512 and AMX, with tiles of bf16 and int8.
    Amx,
}

/// An inner loop that [`Simd::vectorised`] compiles for each instruction set.
///
/// `run` and its helpers must be `#[inline(always)]`. A function that is not inlined is compiled for the baseline
/// processor.
pub trait SimdOp {
    /// Runs the loop.
    fn run(self);
}

impl Simd {
    /// Lists the instruction sets of this processor, the fastest last.
    pub fn available() -> Vec<Self> {
        let mut found = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                found.push(Self::Avx2);
            }
            let has_avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl");
            if has_avx512 && found.len() == 2 {
                found.push(Self::Avx512);
            }
            if found.contains(&Self::Avx512)
                && is_x86_feature_detected!("avx512bf16")
                && conv::amx::is_granted()
            {
                found.push(Self::Amx);
            }
        }
        found
    }

    /// Returns the fastest instruction set of this processor.
    pub fn best() -> Self {
        static BEST: OnceLock<Simd> = OnceLock::new();
        *BEST.get_or_init(|| Self::available().pop().unwrap_or(Self::Portable))
    }

    /// Name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Amx => "amx",
        }
    }

    /// Runs `work`, compiled with the instructions of this set.
    #[inline(always)]
    pub fn vectorised(self, work: impl SimdOp) {
        #[cfg(target_arch = "x86_64")]
        {
            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]
            unsafe fn avx512(work: impl SimdOp) {
                work.run();
            }

            /// # Safety
            /// The instructions must be available.
            #[target_feature(enable = "avx2,fma")]
            unsafe fn avx2(work: impl SimdOp) {
                work.run();
            }

            match self {
                // SAFETY: values of `Simd` exist only for instruction sets that the processor has.
                Self::Avx512 | Self::Amx => return unsafe { avx512(work) },
                // SAFETY: see above.
                Self::Avx2 => return unsafe { avx2(work) },
                Self::Portable => {}
            }
        }
        work.run();
    }

    /// Whether this set multiplies `arithmetic` in AMX tiles.
    pub(super) fn multiplies_tiles(self, arithmetic: &Arithmetic) -> bool {
        self == Self::Amx && *arithmetic != Arithmetic::F32
    }

    /// Number of pixels that a convolution kernel computes at once.
    pub(super) fn group(self, arithmetic: &Arithmetic) -> usize {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Amx if self.multiplies_tiles(arithmetic) => conv::amx::GROUP,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 | Self::Amx => conv::avx512::GROUP,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => conv::avx2::GROUP,
            _ => conv::portable::GROUP,
        }
    }

    /// Number of words of a window's row that a convolution kernel multiplies at once.
    pub(super) fn run(self, arithmetic: &Arithmetic) -> usize {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Amx if self.multiplies_tiles(arithmetic) => conv::amx::RUN,
            _ => 1,
        }
    }

    /// Chooses a convolution kernel for the next channels, of which `left` remain. Returns the number of channels
    /// that it computes and the kernel; plain code where this set has none.
    pub(super) fn block(self, left: usize, arithmetic: &Arithmetic) -> (usize, Kernel) {
        #[cfg(target_arch = "x86_64")]
        if matches!(self, Self::Avx512 | Self::Amx) {
            use conv::{amx, avx512};
            let [wide, narrow]: [Kernel; 2] = match (arithmetic, self == Self::Amx) {
                (Arithmetic::F32, _) => [avx512::f32::thirty_two, avx512::f32::sixteen],
                (Arithmetic::Bf16 | Arithmetic::SplitBf16, true) => {
                    [amx::bf16::thirty_two, amx::bf16::sixteen]
                }
                (Arithmetic::Bf16 | Arithmetic::SplitBf16, false) => {
                    [avx512::bf16::thirty_two, avx512::bf16::sixteen]
                }
                (Arithmetic::Int8 { .. }, true) => [amx::int8::thirty_two, amx::int8::sixteen],
                (Arithmetic::Int8 { .. }, false) => [avx512::int8::thirty_two, avx512::int8::sixteen],
            };
            return if left > 16 { (32, wide) } else { (16, narrow) };
        }
        #[cfg(target_arch = "x86_64")]
        if self == Self::Avx2 {
            let kernel: Kernel = match arithmetic {
                Arithmetic::Int8 { .. } => conv::avx2::int8,
                _ => conv::avx2::f32,
            };
            return (16, kernel);
        }
        let kernel: Kernel = match arithmetic {
            Arithmetic::F32 => conv::portable::f32,
            Arithmetic::Bf16 | Arithmetic::SplitBf16 => conv::portable::bf16,
            Arithmetic::Int8 { .. } => conv::portable::int8,
        };
        (conv::portable::WIDTH, kernel)
    }

    /// Whether this set has instructions for products of bf16.
    pub fn has_bf16(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Amx => return true,
            Self::Avx512 => return is_x86_feature_detected!("avx512bf16"),
            _ => {}
        }
        false
    }

    /// Whether this set multiplies bf16 faster than f32. Intel processors without AMX do not: measured, `vdpbf16ps`
    /// gives half as many products per second as f32. On AMD processors it gives twice as many.
    pub fn gains_from_bf16(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        if self == Self::Avx512 {
            return self.has_bf16() && is_from_amd();
        }
        self.has_bf16()
    }

    /// Whether this set multiplies int8 faster than f32.
    pub fn has_int8(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Amx => return true,
            Self::Avx512 => return is_x86_feature_detected!("avx512vnni"),
            Self::Avx2 => return is_x86_feature_detected!("avxvnni"),
            Self::Portable => {}
        }
        false
    }
}

/// Whether AMD made this processor (CPUID leaf 0).
#[cfg(target_arch = "x86_64")]
fn is_from_amd() -> bool {
    let found = std::arch::x86_64::__cpuid(0);
    [found.ebx, found.edx, found.ecx].map(u32::to_le_bytes).concat() == b"AuthenticAMD"
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Simd {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match Self::available().into_iter().find(|simd| simd.name() == text) {
            Some(simd) => Ok(simd),
            None => Err(format!(
                "`{text}` is no instruction set of this processor; use {}",
                Self::available().iter().map(|simd| simd.name()).collect::<Vec<_>>().join(", ")
            )),
        }
    }
}
