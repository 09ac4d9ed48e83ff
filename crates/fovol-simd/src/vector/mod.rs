//! Operations of a vector, grouped by what they do. [`SimdF32`] has them all.

mod arithmetic;
mod gather;
mod integers;
mod lanes;
mod pixels;
mod storage;

pub use arithmetic::{Arithmetic, MOST_LANES};
pub use gather::Gather;
pub use integers::{Integers, SimdI32};
pub use lanes::Lanes;
pub use pixels::Pixels;
pub use storage::Storage;

/// Vector of f32: one type per instruction set.
///
/// Code that is generic over it is written once and compiled for every instruction set by
/// [`Simd::in_vectors`](crate::Simd::in_vectors). Mark such functions `#[inline(always)]`: a function that is not
/// inlined is compiled for the baseline processor, where each operation becomes a call.
pub trait SimdF32: Arithmetic + Lanes + Integers + Gather + Pixels + Storage {}

impl<V: Arithmetic + Lanes + Integers + Gather + Pixels + Storage> SimdF32 for V {}
