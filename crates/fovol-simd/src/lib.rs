//! Vectors of f32 and i32 that are written once and run on every instruction set.
//!
//! A loop implements [`SimdF32Op`] and is generic over a vector type. [`Simd::in_vectors`] runs it with the vectors of
//! an instruction set that the processor has:
//!
//! ```
//! use fovol_simd::{Simd, SimdF32, SimdF32Op};
//!
//! struct Scaled<'a> {
//!     numbers: &'a mut [f32],
//!     factor: f32,
//! }
//!
//! impl SimdF32Op for Scaled<'_> {
//!     type Output = ();
//!
//!     #[inline(always)]
//!     fn run<V: SimdF32>(self, zero: V) {
//!         for numbers in self.numbers.chunks_exact_mut(V::N) {
//!             (zero.load(numbers) * zero.splat(self.factor)).store(numbers);
//!         }
//!     }
//! }
//!
//! let mut numbers = [1.0; 16];
//! Simd::best().in_vectors(Scaled { numbers: &mut numbers, factor: 3.0 });
//! assert_eq!(numbers, [3.0; 16]);
//! ```
//!
//! A vector exists only where its instructions do, so no operation but gathers from memory is unsafe. Loops that the
//! compiler vectorises by itself implement [`SimdOp`].

mod aligned_buf;
mod bf16;
mod dispatch;
mod gather_method;
mod portable;
mod prefetch;
mod simd;
mod vec4;
mod vector;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use aligned_buf::{AlignedBuf, WORDS_OF_LINE};
pub use bf16::Bf16;
pub use dispatch::{SimdF32Op, SimdOp};
pub use gather_method::GatherMethod;
pub use portable::{Portable, PortableI32, PortableMask};
pub use prefetch::prefetch;
pub use simd::Simd;
pub use vector::{Arithmetic, Gather, Integers, Lanes, MOST_LANES, Pixels, SimdF32, SimdI32, Storage};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
