//! A brick grid as the lanes read it.

use crate::scene::{BrickData, Bricks};
use bytemuck::cast_slice;
use fovol_core::Interpolation;
use fovol_simd::{Simd, SimdF32, SimdF32Op, SimdI32};

/// A kind of stored voxels: how eight corners become one value.
pub trait Texel: Copy + 'static {
    /// The stored values.
    type Values<'a>: Copy + Sync;

    /// Whether values can be NaN.
    const CAN_BE_NAN: bool = false;

    /// The number of `values`.
    fn len(values: Self::Values<'_>) -> usize;

    /// The factor by which [`Self::trilinear`] scales `values`.
    fn gain(_values: Self::Values<'_>) -> f32 {
        1.0
    }

    /// The trilinear value in the cells whose low corners are at `index`, `f` of the way along each axis,
    /// times [`Self::gain`]; `offset` leads to the neighbours along y and z.
    ///
    /// # Safety
    /// All eight corners, and the rest of the 32-bit words that begin with them, must lie in `values`.
    unsafe fn trilinear<V: SimdF32>(
        values: Self::Values<'_>,
        index: V::I32,
        offset: [usize; 2],
        f: [V; 3],
    ) -> V;

    /// Runs `work` on these voxels with vectors of `simd`.
    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        match simd.in_native_vectors(work) {
            Ok(output) => output,
            Err(_) => unreachable!("portable vectors read voxels of `AnyType`"),
        }
    }
}

/// A type that is stored once a voxel and read two neighbours along x at a time.
trait PairTexel: Copy {
    /// The values at `index` and `index` + 1 of each of four slices.
    ///
    /// # Safety
    /// The 32-bit words that begin at `index` must lie in all of them; for f32, those at `index` + 1 too.
    unsafe fn pairs<V: SimdF32>(values: [&[Self]; 4], index: V::I32) -> [[V; 2]; 4];
}

/// Interpolates along x, y and z in turn.
///
/// # Safety
/// That of [`Texel::trilinear`].
#[inline(always)]
unsafe fn from_pairs<T: PairTexel, V: SimdF32>(
    values: &[T],
    index: V::I32,
    [uy, uz]: [usize; 2],
    f: [V; 3],
) -> V {
    // SAFETY: the caller's.
    let [[a0, a1], [b0, b1], [c0, c1], [d0, d1]] = unsafe {
        let rows =
            [values, values.get_unchecked(uy..), values.get_unchecked(uz..), values.get_unchecked(uy + uz..)];
        T::pairs::<V>(rows, index)
    };
    let (v00, v10) = (f[0].mul_add(a1 - a0, a0), f[0].mul_add(b1 - b0, b0));
    let (v01, v11) = (f[0].mul_add(c1 - c0, c0), f[0].mul_add(d1 - d0, d0));
    let near = f[1].mul_add(v10 - v00, v00);
    let far = f[1].mul_add(v11 - v01, v01);
    f[2].mul_add(far - near, near)
}

macro_rules! stored_once_a_voxel {
    ($($T:ty: $can_be_nan:literal),*) => {$(
        impl Texel for $T {
            type Values<'a> = &'a [$T];

            const CAN_BE_NAN: bool = $can_be_nan;

            fn len(values: &[$T]) -> usize {
                values.len()
            }

            #[inline(always)]
            unsafe fn trilinear<V: SimdF32>(values: &[$T], index: V::I32, offset: [usize; 2], f: [V; 3]) -> V {
                // SAFETY: the caller's.
                unsafe { from_pairs(values, index, offset, f) }
            }
        }
    )*};
}

stored_once_a_voxel!(u8: false, u16: false, f32: true);

impl PairTexel for u8 {
    #[inline(always)]
    unsafe fn pairs<V: SimdF32>(values: [&[u8]; 4], index: V::I32) -> [[V; 2]; 4] {
        #[inline(always)]
        fn both<V: SimdF32>(words: V::I32) -> [V; 2] {
            let byte = words.splat(0xFF);
            [V::from_i32(words & byte), V::from_i32(words.shr::<8>() & byte)]
        }
        // SAFETY: the caller's.
        let [a, b, c, d] = unsafe { V::gather_bytes_of_4::<1>(values, index) };
        [both(a), both(b), both(c), both(d)]
    }
}

impl PairTexel for u16 {
    #[inline(always)]
    unsafe fn pairs<V: SimdF32>(values: [&[u16]; 4], index: V::I32) -> [[V; 2]; 4] {
        #[inline(always)]
        fn both<V: SimdF32>(words: V::I32) -> [V; 2] {
            [V::from_i32(words & words.splat(0xFFFF)), V::from_i32(words.shr::<16>())]
        }
        let [a, b, c, d] = values;
        let values = [cast_slice(a), cast_slice(b), cast_slice(c), cast_slice(d)];
        // SAFETY: the caller's.
        let [a, b, c, d] = unsafe { V::gather_bytes_of_4::<2>(values, index) };
        [both(a), both(b), both(c), both(d)]
    }
}

impl PairTexel for f32 {
    #[inline(always)]
    unsafe fn pairs<V: SimdF32>(values: [&[f32]; 4], index: V::I32) -> [[V; 2]; 4] {
        // SAFETY: the caller's.
        unsafe { V::gather_pairs_of_4(values, index) }
    }
}

/// The factor of [`BrickData::Corners`], whose interpolation along y has weights of 14 bits.
const CORNER_GAIN: f32 = 16384.0;

/// Four bytes: the neighbours along y and z of one voxel. Interpolation along y is done on integers,
/// with weights of 14 bits.
impl Texel for u32 {
    type Values<'a> = &'a [u32];

    fn len(values: &[u32]) -> usize {
        values.len()
    }

    fn gain(_: &[u32]) -> f32 {
        CORNER_GAIN
    }

    #[inline(always)]
    unsafe fn trilinear<V: SimdF32>(values: &[u32], index: V::I32, _: [usize; 2], f: [V; 3]) -> V {
        // SAFETY: the caller's.
        let [low, high] = unsafe { V::load_word_pairs(values, index) };
        // 16384 − w in the low half, w in the high half.
        let w = f[1].mul_add(f[1].splat(CORNER_GAIN), f[1].splat(0.5)).to_i32();
        let weights = w * w.splat(0xFFFF) + w.splat(0x4000);
        let a0 = V::from_i32(low.weighted_bytes::<0>(weights));
        let a1 = V::from_i32(low.weighted_bytes::<1>(weights));
        let b0 = V::from_i32(high.weighted_bytes::<0>(weights));
        let b1 = V::from_i32(high.weighted_bytes::<1>(weights));
        let a = f[2].mul_add(a1 - a0, a0);
        let b = f[2].mul_add(b1 - b0, b0);
        f[0].mul_add(b - a, a)
    }
}

/// Voxels of a type that is known at run time only.
///
/// Vectors of the processor's own instructions have compiled code for each type. Portable ones share this code: it
/// takes as long, and compiling it for each type would take most of the compiler's time.
#[derive(Debug, Clone, Copy)]
pub struct AnyType;

/// Voxels of one of the types of [`BrickData`].
#[derive(Clone, Copy)]
pub enum AnyValues<'a> {
    Corners(&'a [u32]),
    U8(&'a [u8]),
    U16(&'a [u16]),
    F32(&'a [f32]),
}

impl<'a> AnyValues<'a> {
    /// The voxels of `bricks`.
    pub fn new(bricks: &'a Bricks) -> Self {
        match bricks.data() {
            BrickData::Corners(values) => Self::Corners(values),
            BrickData::U8(values) => Self::U8(values),
            BrickData::U16(values) => Self::U16(values),
            BrickData::F32(values) => Self::F32(values),
            BrickData::Gaps(values) => Self::F32(cast_slice(values)),
        }
    }

    /// [`Texel::trilinear`] of the type that the voxels have.
    ///
    /// # Safety
    /// That of [`Texel::trilinear`].
    #[inline(always)]
    unsafe fn trilinear<V: SimdF32>(self, index: V::I32, offset: [usize; 2], f: [V; 3]) -> V {
        // SAFETY: the caller's.
        unsafe {
            match self {
                Self::Corners(values) => u32::trilinear(values, index, offset, f),
                Self::U8(values) => u8::trilinear(values, index, offset, f),
                Self::U16(values) => u16::trilinear(values, index, offset, f),
                Self::F32(values) => f32::trilinear(values, index, offset, f),
            }
        }
    }
}

impl Texel for AnyType {
    type Values<'a> = AnyValues<'a>;

    const CAN_BE_NAN: bool = true;

    fn len(values: AnyValues<'_>) -> usize {
        match values {
            AnyValues::Corners(values) => values.len(),
            AnyValues::U8(values) => values.len(),
            AnyValues::U16(values) => values.len(),
            AnyValues::F32(values) => values.len(),
        }
    }

    fn gain(values: AnyValues<'_>) -> f32 {
        if matches!(values, AnyValues::Corners(_)) { CORNER_GAIN } else { 1.0 }
    }

    /// Compiled on its own, once for all callers.
    #[inline(never)]
    unsafe fn trilinear<V: SimdF32>(
        values: AnyValues<'_>,
        index: V::I32,
        offset: [usize; 2],
        f: [V; 3],
    ) -> V {
        // SAFETY: the caller's.
        unsafe { values.trilinear(index, offset, f) }
    }

    fn in_vectors<W: SimdF32Op>(_: Simd, work: W) -> W::Output {
        Simd::in_portable_vectors(work)
    }
}

/// Voxels of a type that is known at run time only, for vectors of any instruction set.
#[derive(Debug, Clone, Copy)]
pub struct InlinedAnyType;

impl Texel for InlinedAnyType {
    type Values<'a> = AnyValues<'a>;

    const CAN_BE_NAN: bool = true;

    fn len(values: AnyValues<'_>) -> usize {
        AnyType::len(values)
    }

    fn gain(values: AnyValues<'_>) -> f32 {
        AnyType::gain(values)
    }

    #[inline(always)]
    unsafe fn trilinear<V: SimdF32>(
        values: AnyValues<'_>,
        index: V::I32,
        offset: [usize; 2],
        f: [V; 3],
    ) -> V {
        // SAFETY: the caller's.
        unsafe { values.trilinear(index, offset, f) }
    }

    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        simd.in_vectors(work)
    }
}

/// A brick grid of one voxel type, with 32-bit addressing.
#[derive(Clone, Copy)]
pub struct Field<'a, T: Texel> {
    values: T::Values<'a>,
    last: [f32; 3],
    unit: [i32; 3],
    jump: [i32; 3],
    /// The factor from [`Texel::trilinear`] to the values that [`Self::sample`] returns.
    pub scale: f32,
    /// The value that [`Self::sample`] returns for NaN: one more than the largest value.
    pub missing: f32,
    has_gaps: bool,
    is_nearest: bool,
}

/// Whether 32-bit lanes can address every element of `bricks`.
pub fn addressable(bricks: &Bricks) -> bool {
    i32::try_from(bricks.layout().elements()).is_ok()
}

/// Whether lanes give the values of `bricks`: they are addressable, and no voxel of weight 0 is NaN.
pub fn readable(bricks: &Bricks) -> bool {
    addressable(bricks) && !(bricks.has_gaps() && bricks.interpolation() == Interpolation::Nearest)
}

impl<'a, T: Texel> Field<'a, T> {
    /// The field of `values`, the stored values of `bricks`; a display value of 1 is read as `unit`.
    ///
    /// # Panics
    /// When the bricks are not [`addressable`] or `values` has another length than their layout.
    pub fn new(bricks: &'a Bricks, values: T::Values<'a>, unit: f32) -> Self {
        assert!(addressable(bricks) && T::len(values) == bricks.layout().elements());
        let layout = bricks.layout();
        Self {
            values,
            last: layout.dims.map(|d| (d - 1) as f32),
            unit: layout.unit.map(|u| u as i32),
            jump: layout.jump.map(|j| j as i32),
            scale: bricks.scale() * unit / T::gain(values),
            missing: unit + 1.0,
            has_gaps: bricks.has_gaps(),
            is_nearest: bricks.interpolation() == Interpolation::Nearest,
        }
    }

    /// Whether some values are NaN.
    #[inline(always)]
    pub fn has_gaps(&self) -> bool {
        T::CAN_BE_NAN && self.has_gaps
    }

    /// The value at `p` (voxel-centre coordinates, clamped to the edge), scaled; [`Self::missing`] for NaN.
    ///
    /// Trilinear values at the centres of voxels are those of the nearest voxels, unless some are NaN: that needs plain code.
    #[inline(always)]
    pub fn sample<V: SimdF32>(&self, p: [V; 3]) -> V {
        self.value(self.place(p))
    }

    /// The values at `p` and `q`; see [`Self::sample`].
    ///
    /// Both addresses come before all loads, so that the loads overlap.
    #[inline(always)]
    pub fn sample_pair<V: SimdF32>(&self, p: [V; 3], q: [V; 3]) -> [V; 2] {
        let (p, q) = (self.place(p), self.place(q));
        [self.value(p), self.value(q)]
    }

    /// The value in the cell whose low corner is at `index`, `f` of the way along each axis.
    #[inline(always)]
    fn value<V: SimdF32>(&self, (index, f): (V::I32, [V; 3])) -> V {
        let [_, uy, uz] = self.unit.map(|u| u as usize);
        let scale = f[0].splat(self.scale);
        // SAFETY: positions are clamped to the grid, whose cells all have their eight corners stored, and the layout ends
        // in padding, so every word lies inside the values.
        let value = unsafe { T::trilinear(self.values, index, [uy, uz], f) } * scale;
        // In this order, `min` turns NaN into `missing`.
        if self.has_gaps() { value.min(scale.splat(self.missing)) } else { value }
    }

    /// The index of the low corner of the cell around `p`, and how far along each axis `p` lies in it.
    #[inline(always)]
    fn place<V: SimdF32>(&self, p: [V; 3]) -> (V::I32, [V; 3]) {
        let zero = p[0].splat(0.0);
        let mut clamped = p;
        for a in 0..3 {
            // max first: it sends NaN to 0.
            clamped[a] = p[a].max(zero).min(zero.splat(self.last[a]));
        }
        if self.is_nearest {
            for c in &mut clamped {
                *c = V::from_i32((*c + zero.splat(0.5)).to_i32());
            }
        }
        let mut f = [zero; 3];
        let mut index = zero.splat_i32(0);
        for a in 0..3 {
            let cell = clamped[a].to_i32();
            f[a] = clamped[a] - V::from_i32(cell);
            let inside = if a == 0 { cell } else { cell * zero.splat_i32(self.unit[a]) };
            let across = cell.shr::<3>() * zero.splat_i32(self.jump[a]);
            index = index + (inside + across);
        }
        (index, f)
    }
}

/// Calls `$body` with `$field` bound to the typed field of `$bricks`.
macro_rules! with_field {
    ($bricks:expr, $unit:expr, $field:ident => $body:expr) => {
        match $bricks.data() {
            $crate::scene::BrickData::Corners(values) => {
                let $field = Field::<u32>::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::U8(values) => {
                let $field = Field::<u8>::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::U16(values) => {
                let $field = Field::<u16>::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::F32(values) => {
                let $field = Field::<f32>::new($bricks, values, $unit);
                $body
            }
            $crate::scene::BrickData::Gaps(values) => {
                let $field = Field::<f32>::new($bricks, ::bytemuck::cast_slice(values), $unit);
                $body
            }
        }
    };
}
pub(crate) use with_field;

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Grid, Volume};
    use proptest::prelude::*;

    /// Weights of 14 bits are off by half of the last one.
    const TOLERANCE: f32 = 0.5 / 16384.0 + 2e-6;

    struct Agrees<'a> {
        bricks: &'a Bricks,
        points: &'a [[f32; 3]],
    }

    impl SimdF32Op for Agrees<'_> {
        type Output = ();

        fn run<V: SimdF32>(self, zero: V) {
            for chunk in self.points.chunks_exact(V::N) {
                let p = [0, 1, 2].map(|a| zero.load(&chunk.iter().map(|p| p[a]).collect::<Vec<f32>>()));
                let mut out = vec![0.0f32; V::N];
                with_field!(self.bricks, 1.0, field => field.sample(p).store(&mut out));
                for (p, v) in chunk.iter().zip(out) {
                    let expected = self.bricks.sample(*p);
                    if expected.is_nan() {
                        assert_eq!(v, 2.0, "{p:?}");
                        continue;
                    }
                    assert!((expected - v).abs() < TOLERANCE, "{p:?}: {expected} and {v}");
                }
            }
        }
    }

    fn agrees_everywhere(bricks: &Bricks, points: &[[f32; 3]]) {
        Simd::available().into_iter().for_each(|simd| simd.in_vectors(Agrees { bricks, points }));
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
