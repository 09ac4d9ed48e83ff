use crate::portable::Portable;
use crate::simd::Simd;
use crate::vector::SimdF32;
#[cfg(target_arch = "x86_64")]
use crate::x86::{Avx2, Avx512};

/// Loop that the compiler vectorises for each instruction set.
///
/// `run` and what it calls must be `#[inline(always)]`. A function that is not inlined is compiled for the baseline
/// processor. Keep loops small, or values spill out of registers.
pub trait SimdOp {
    /// Result of the loop.
    type Output;

    /// Runs the loop.
    fn run(self) -> Self::Output;
}

/// Loop in vectors. `run` and what it calls must be `#[inline(always)]`, as in [`SimdOp`].
///
/// Do not hand vectors to functions of the standard library that take closures, such as `array::map`: they are not
/// always inlined, and then work vector by vector on memory. Measured, one such call in a hot loop halves its speed.
pub trait SimdF32Op {
    /// Result of the loop.
    type Output;

    /// Runs the loop with vectors of the type of `zero`, whose lanes are 0.
    fn run<V: SimdF32>(self, zero: V) -> Self::Output;
}

impl Simd {
    /// Runs `work`, compiled with the instructions of this set.
    #[inline(always)]
    pub fn vectorised<W: SimdOp>(self, work: W) -> W::Output {
        struct InLanes<W>(W);

        impl<W: SimdOp> SimdF32Op for InLanes<W> {
            type Output = W::Output;

            #[inline(always)]
            fn run<V: SimdF32>(self, _: V) -> W::Output {
                self.0.run()
            }
        }

        self.in_vectors(InLanes(work))
    }

    /// Runs `work` with the longest vectors of this instruction set.
    #[inline(always)]
    pub fn in_vectors<W: SimdF32Op>(self, work: W) -> W::Output {
        match self.in_native_vectors(work) {
            Ok(output) => output,
            Err(work) => Self::in_portable_vectors(work),
        }
    }

    /// Runs `work` with vectors for which this set has instructions.
    ///
    /// # Errors
    /// [`Simd::Scalar`] and [`Simd::Portable`] have none: `work`, for [`Self::in_portable_vectors`].
    #[inline(always)]
    pub fn in_native_vectors<W: SimdF32Op>(self, work: W) -> Result<W::Output, W> {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
            fn avx512<W: SimdF32Op>(work: W) -> W::Output {
                work.run(Avx512::zero())
            }

            #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
            fn avx2<W: SimdF32Op>(work: W) -> W::Output {
                work.run(Avx2::zero())
            }

            match self {
                Self::Avx512 | Self::Amx => {
                    Avx512::choose_gathers();
                    // SAFETY: values of `Simd` exist only for instruction sets that the processor has.
                    return Ok(unsafe { avx512(work) });
                }
                Self::Avx2 => {
                    Avx2::choose_gathers();
                    // SAFETY: see above.
                    return Ok(unsafe { avx2(work) });
                }
                Self::Scalar | Self::Portable => {}
            }
        }
        Err(work)
    }

    /// Runs `work` with vectors that need no special instructions.
    // Compiled on its own: in a large function the compiler inlines less.
    #[inline(never)]
    pub fn in_portable_vectors<W: SimdF32Op>(work: W) -> W::Output {
        work.run(Portable::zero())
    }
}
