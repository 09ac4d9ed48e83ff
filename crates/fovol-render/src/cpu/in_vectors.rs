//! Marching as an operation that runs in the vectors of any instruction set.

use super::field::Texel;
use super::fine::{FineKernel, FineScratch};
use super::kernel::{Kernel, Scratch};
use super::march::SampleCount;
use super::medium::Medium;
use super::modes::{IsosurfaceKernel, ProjectionKernel};
use super::packet::Packet;
use crate::scene::RayResult;
use fovol_core::{Pixel, RayBasis};
use fovol_simd::{SimdF32, SimdF32Op};

/// Rays to march in vectors, and where their results go.
pub struct InVectors<'a, K, S> {
    pub kernel: &'a K,
    pub rays: &'a RayBasis,
    pub pixels: &'a [Pixel],
    pub scratch: &'a mut S,
    pub out: &'a mut Vec<RayResult>,
}

macro_rules! in_vectors {
    ($Of:ident, $Kernel:ident, $Scratch:ident) => {
        impl<T: $Of> SimdF32Op for InVectors<'_, $Kernel<'_, T>, $Scratch> {
            type Output = SampleCount;

            #[inline(always)]
            fn run<V: SimdF32>(self, zero: V) -> SampleCount {
                self.kernel.march(zero, self.rays, self.pixels, self.scratch, self.out)
            }
        }
    };
}

in_vectors!(Medium, Kernel, Scratch);
in_vectors!(Texel, FineKernel, FineScratch);
in_vectors!(Texel, ProjectionKernel, Packet);
in_vectors!(Texel, IsosurfaceKernel, Packet);
