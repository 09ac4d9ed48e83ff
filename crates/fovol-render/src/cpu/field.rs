//! A brick grid as the lanes read it.

use super::lanes::Lanes;
use crate::scene::{Bricks, MaybeNan};
use std::marker::PhantomData;

/// A stored voxel type, and how eight corners become one value.
pub trait Texel: Copy + Sync + 'static {
    /// The factor by which [`Self::trilinear`] scales stored values.
    const GAIN: f32 = 1.0;
    /// Whether values may be NaN.
    const GAPS: bool = false;

    /// The trilinear value in the cells whose low corners are at `index`, `f` of the way along each axis,
    /// times [`Self::GAIN`]; `offset` leads to the neighbours along y and z.
    ///
    /// # Safety
    /// As [`Lanes::gather`]; all corners, and the rest of the 32-bit words around them, must be readable.
    unsafe fn trilinear<L: Lanes>(base: *const Self, index: L::I, offset: [usize; 2], f: [L::F; 3]) -> L::F;
}

/// A type that is stored once a voxel and read two neighbours along x at a time.
trait PairTexel: Texel {
    /// The values at `index` and `index` + 1.
    unsafe fn pair<L: Lanes>(base: *const Self, index: L::I) -> (L::F, L::F);

    /// [`Texel::trilinear`] from four pairs.
    #[inline(always)]
    unsafe fn from_pairs<L: Lanes>(
        base: *const Self,
        index: L::I,
        [uy, uz]: [usize; 2],
        f: [L::F; 3],
    ) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let (a, b) = Self::pair::<L>(base, index);
            let v00 = L::fma(f[0], L::sub(b, a), a);
            let (a, b) = Self::pair::<L>(base.add(uy), index);
            let v10 = L::fma(f[0], L::sub(b, a), a);
            let (a, b) = Self::pair::<L>(base.add(uz), index);
            let v01 = L::fma(f[0], L::sub(b, a), a);
            let (a, b) = Self::pair::<L>(base.add(uy + uz), index);
            let v11 = L::fma(f[0], L::sub(b, a), a);
            let near = L::fma(f[1], L::sub(v10, v00), v00);
            let far = L::fma(f[1], L::sub(v11, v01), v01);
            L::fma(f[2], L::sub(far, near), near)
        }
    }
}

macro_rules! stored_once_a_voxel {
    ($($T:ty),*) => {$(
        impl Texel for $T {
            #[inline(always)]
            unsafe fn trilinear<L: Lanes>(base: *const Self, index: L::I, offset: [usize; 2], f: [L::F; 3]) -> L::F {
                // SAFETY: the caller's.
                unsafe { Self::from_pairs::<L>(base, index, offset, f) }
            }
        }
    )*};
}

stored_once_a_voxel!(u8, u16, f32);

impl PairTexel for u8 {
    #[inline(always)]
    unsafe fn pair<L: Lanes>(base: *const u8, index: L::I) -> (L::F, L::F) {
        // SAFETY: the caller's.
        unsafe {
            let words = L::gather::<1>(base, index);
            let byte = L::splat_i(0xFF);
            (L::to_f32(L::and_i(words, byte)), L::to_f32(L::and_i(L::shr_i::<8>(words), byte)))
        }
    }
}

impl PairTexel for u16 {
    #[inline(always)]
    unsafe fn pair<L: Lanes>(base: *const u16, index: L::I) -> (L::F, L::F) {
        // SAFETY: the caller's.
        unsafe {
            let words = L::gather::<2>(base.cast(), index);
            (L::to_f32(L::and_i(words, L::splat_i(0xFFFF))), L::to_f32(L::shr_i::<16>(words)))
        }
    }
}

impl PairTexel for f32 {
    #[inline(always)]
    unsafe fn pair<L: Lanes>(base: *const f32, index: L::I) -> (L::F, L::F) {
        // SAFETY: the caller's.
        unsafe { L::gather_pair(base.cast(), index) }
    }
}

impl Texel for MaybeNan {
    const GAPS: bool = true;

    #[inline(always)]
    unsafe fn trilinear<L: Lanes>(base: *const Self, index: L::I, offset: [usize; 2], f: [L::F; 3]) -> L::F {
        // SAFETY: the caller's; it is nothing but an f32.
        unsafe { f32::trilinear::<L>(base.cast(), index, offset, f) }
    }
}

/// Four bytes: the neighbours along y and z of one voxel. Interpolation along y is done on integers,
/// with weights of 14 bits.
impl Texel for u32 {
    const GAIN: f32 = 16384.0;

    #[inline(always)]
    unsafe fn trilinear<L: Lanes>(base: *const u32, index: L::I, _: [usize; 2], f: [L::F; 3]) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let (low, high) = L::gather_words(base, index);
            // 16384 − w in the low half, w in the high half.
            let w = L::truncate(L::fma(f[1], L::splat(Self::GAIN), L::splat(0.5)));
            let weights = L::add_i(L::mul_i(w, L::splat_i(0xFFFF)), L::splat_i(0x4000));
            let a0 = L::to_f32(L::weighted_bytes::<0>(low, weights));
            let a1 = L::to_f32(L::weighted_bytes::<1>(low, weights));
            let b0 = L::to_f32(L::weighted_bytes::<0>(high, weights));
            let b1 = L::to_f32(L::weighted_bytes::<1>(high, weights));
            let a = L::fma(f[2], L::sub(a1, a0), a0);
            let b = L::fma(f[2], L::sub(b1, b0), b0);
            L::fma(f[0], L::sub(b, a), a)
        }
    }
}

/// A brick grid of one voxel type, with 32-bit addressing.
#[derive(Clone, Copy)]
pub struct Field<'a, T> {
    base: *const T,
    last: [f32; 3],
    unit: [i32; 3],
    jump: [i32; 3],
    /// The factor from [`Texel::trilinear`] to the values that [`Self::sample`] returns.
    pub scale: f32,
    /// The value that [`Self::sample`] returns for NaN: one more than the largest value.
    pub missing: f32,
    bricks: PhantomData<&'a Bricks>,
}

// SAFETY: a field only reads the bricks it borrows.
unsafe impl<T: Sync> Sync for Field<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Sync> Send for Field<'_, T> {}

/// Whether 32-bit lanes can address every element of `bricks`.
pub fn addressable(bricks: &Bricks) -> bool {
    i32::try_from(bricks.layout().elements()).is_ok()
}

impl<'a, T: Texel> Field<'a, T> {
    /// The field of `values`, the stored values of `bricks`; a display value of 1 is read as `unit`.
    ///
    /// # Panics
    /// When the bricks are not [`addressable`] or `values` has another length than their layout.
    pub fn new(bricks: &'a Bricks, values: &'a [T], unit: f32) -> Self {
        assert!(addressable(bricks) && values.len() == bricks.layout().elements());
        let layout = bricks.layout();
        Self {
            base: values.as_ptr(),
            last: layout.dims.map(|d| (d - 1) as f32),
            unit: layout.unit.map(|u| u as i32),
            jump: layout.jump.map(|j| j as i32),
            scale: bricks.scale() * unit / T::GAIN,
            missing: unit + 1.0,
            bricks: PhantomData,
        }
    }

    /// The trilinear value at `p` (voxel-centre coordinates, clamped to the edge), scaled; [`Self::missing`] for NaN.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn sample<L: Lanes>(&self, p: [L::F; 3]) -> L::F {
        // SAFETY: positions are clamped to the grid, whose cells all have their eight corners stored,
        // and the layout ends in padding, so every gathered word lies inside the values.
        unsafe {
            let zero = L::splat(0.0);
            let mut f = [zero; 3];
            let mut index = L::splat_i(0);
            for a in 0..3 {
                // max first: it sends NaN to 0.
                let clamped = L::min(L::max(p[a], zero), L::splat(self.last[a]));
                let cell = L::truncate(clamped);
                f[a] = L::sub(clamped, L::to_f32(cell));
                let inside = if a == 0 { cell } else { L::mul_i(cell, L::splat_i(self.unit[a])) };
                let across = L::mul_i(L::shr_i::<3>(cell), L::splat_i(self.jump[a]));
                index = L::add_i(index, L::add_i(inside, across));
            }
            let [_, uy, uz] = self.unit.map(|u| u as usize);
            let value = L::mul(T::trilinear::<L>(self.base, index, [uy, uz], f), L::splat(self.scale));
            // In this order, `min` turns NaN into `missing`.
            if T::GAPS { L::min(value, L::splat(self.missing)) } else { value }
        }
    }
}

/// Calls `$body` with `$field` bound to the typed field of `$bricks`.
macro_rules! with_field {
    ($bricks:expr, $unit:expr, $field:ident => $body:expr) => {
        match $bricks.data() {
            $crate::scene::BrickData::Corners(values) => {
                let $field = Field::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::U8(values) => {
                let $field = Field::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::U16(values) => {
                let $field = Field::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::F32(values) => {
                let $field = Field::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::Gaps(values) => {
                let $field = Field::new($bricks, values, $unit);
                $body
            }
        }
    };
}
pub(crate) use with_field;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::lanes::portable::Portable;
    use fovol_core::{Grid, Volume};
    use proptest::prelude::*;

    /// Weights of 14 bits are off by half of the last one.
    const TOLERANCE: f32 = 0.5 / 16384.0 + 2e-6;

    fn agrees<L: Lanes>(bricks: &Bricks, points: &[[f32; 3]]) {
        for chunk in points.chunks_exact(L::N) {
            let axis = |a: usize| -> Vec<f32> { chunk.iter().map(|p| p[a]).collect() };
            let (x, y, z) = (axis(0), axis(1), axis(2));
            let mut out = vec![0.0f32; L::N];
            with_field!(bricks, 1.0, field => {
                // SAFETY: callers pass instruction sets that are available; the arrays hold N lanes.
                unsafe {
                    let p = [L::load(x.as_ptr()), L::load(y.as_ptr()), L::load(z.as_ptr())];
                    L::store(field.sample::<L>(p), out.as_mut_ptr());
                }
            });
            for (p, v) in chunk.iter().zip(out) {
                if bricks.sample(*p).is_nan() {
                    assert_eq!(v, 2.0, "{p:?}");
                    continue;
                }
                assert!((bricks.sample(*p) - v).abs() < TOLERANCE, "{p:?}: {} and {v}", bricks.sample(*p));
            }
        }
    }

    fn agrees_everywhere(bricks: &Bricks, points: &[[f32; 3]]) {
        agrees::<Portable>(bricks, points);
        #[cfg(target_arch = "x86_64")]
        {
            use crate::cpu::lanes::{avx2, avx512};
            if avx2::available() {
                agrees::<avx2::Avx2>(bricks, points);
            }
            if avx512::available() {
                agrees::<avx512::Avx512>(bricks, points);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn lanes_read_what_plain_code_reads(
            dims in prop::array::uniform3(1usize..20),
            points in prop::collection::vec(prop::array::uniform3(-2.0f32..22.0), 32),
            seed in 1i64..9999,
        ) {
            let n: usize = dims.iter().product();
            let grid = Grid::new(dims, [1.0; 3]).unwrap();
            let random = |i: usize| ((i as i64 + 3) * seed * 2_654_435_761) >> 7;
            let bytes = Volume::from_values(grid, (0..n).map(|i| random(i) as u8).collect()).unwrap();
            let shorts = Volume::from_values(grid, (0..n).map(|i| random(i) as i16).collect()).unwrap();
            let floats = Volume::from_values(grid, (0..n).map(|i| random(i) as i16 as f32 * 0.1).collect()).unwrap();
            let value = |i: usize| if random(i) % 5 == 0 { f32::NAN } else { random(i) as i16 as f32 };
            let gaps = Volume::from_values(grid, (0..n).map(value).collect()).unwrap();
            for volume in [bytes, shorts, floats, gaps] {
                agrees_everywhere(&Bricks::of_volume(&volume).unwrap(), &points);
            }
        }
    }
}
