#[cfg(target_arch = "x86_64")]
use crate::x86::features;
use std::fmt;
use std::sync::OnceLock;

/// Instruction set that vectors are compiled for.
///
/// Values other than [`Simd::Scalar`] and [`Simd::Portable`] exist only where the processor has the instructions: other
/// crates obtain them from [`Simd::best`] and [`Simd::available`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Simd {
    /// One value at a time, in plain code. For renderers this is the specification; vectors run as
    /// [`Simd::Portable`].
    Scalar,
    /// Eight lanes without special instructions, vectorised by the compiler for the baseline processor.
    Portable,
    /// AVX2 and FMA: eight lanes.
    #[non_exhaustive]
    Avx2,
    /// AVX-512 (F, BW, DQ, VL): sixteen lanes.
    #[non_exhaustive]
    Avx512,
    /// AVX-512, and AMX with tiles of bf16 and int8. Vectors run as [`Simd::Avx512`].
    #[non_exhaustive]
    Amx,
}

static CHOSEN: OnceLock<Simd> = OnceLock::new();

impl Simd {
    /// Vector instruction sets of this processor, the fastest last. [`Simd::Scalar`] is none of them.
    pub fn available() -> Vec<Self> {
        [Self::Portable, Self::Avx2, Self::Avx512, Self::Amx]
            .into_iter()
            .filter(|set| set.is_available())
            .collect()
    }

    /// Whether this processor has the instructions.
    fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::Scalar | Self::Portable => true,
            Self::Avx2 => features::has_avx2(),
            Self::Avx512 => features::has_avx512(),
            Self::Amx => features::has_amx(),
        };
        #[cfg(not(target_arch = "x86_64"))]
        matches!(self, Self::Scalar | Self::Portable)
    }

    /// Instruction set for everything in this process that is not told another: the [`Simd::chosen`] one, or the fastest of
    /// this processor.
    pub fn best() -> Self {
        static FASTEST: OnceLock<Simd> = OnceLock::new();
        Self::chosen()
            .unwrap_or_else(|| *FASTEST.get_or_init(|| Self::available().pop().unwrap_or(Self::Portable)))
    }

    /// Makes this set [`Simd::best`] for the whole process, as `--simd` does. The first choice stays; choose before anything
    /// is rendered, because what exists keeps its instructions.
    pub fn choose(self) {
        let _ = CHOSEN.set(self);
    }

    /// Set that was chosen for this process, if any.
    pub fn chosen() -> Option<Self> {
        CHOSEN.get().copied()
    }

    /// Sets that a process can choose: [`Simd::Scalar`], and those of [`Simd::available`].
    pub fn choices() -> Vec<Self> {
        [Self::Scalar].into_iter().chain(Self::available()).collect()
    }

    /// Name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Amx => "amx",
        }
    }

    /// Finds the instruction set with the name `text` in `sets`.
    ///
    /// # Errors
    /// Another name: a message that lists those of `sets`.
    pub fn named(text: &str, sets: &[Self]) -> Result<Self, String> {
        sets.iter().copied().find(|set| set.name() == text).ok_or_else(|| {
            let names: Vec<&str> = sets.iter().map(|set| set.name()).collect();
            format!("`{text}` is no instruction set of this processor; use one of {}", names.join(", "))
        })
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
            return self.has_bf16() && features::is_from_amd();
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
            Self::Scalar | Self::Portable => {}
        }
        false
    }
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_found_by_their_names() {
        let sets = Simd::available();
        for set in &sets {
            assert_eq!(Simd::named(set.name(), &sets), Ok(*set));
        }
        assert_eq!(sets.last(), Some(&Simd::best()));
        let error = Simd::named("mmx", &sets).unwrap_err();
        assert!(error.contains("`mmx`") && error.contains("portable"), "{error}");
    }
}
