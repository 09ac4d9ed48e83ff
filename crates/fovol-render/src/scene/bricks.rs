use super::brick_layout::{BRICK, BrickLayout};
use super::raw_voxels::RawVoxels;
use bytemuck::Zeroable;
use fovol_core::memory::{self, SMALLER_VOLUME, Shortage};
use fovol_core::{Dtype, Interpolation, Rescale, Volume, Voxel, stop, with_voxel_type};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Up to this many voxels 8-bit values are stored as [`BrickData::Corners`]: 4.5 bytes a voxel.
const SMALL: usize = 1 << 26;

/// The voxels of a brick grid at the narrowest type that holds them exactly.
#[derive(Debug, Clone)]
pub enum BrickData {
    /// 8-bit voxels, four to a word: those at (y, z), (y+1, z), (y, z+1) and (y+1, z+1), lowest byte first.
    /// Values are offsets from the low end of the range. A word and the next one along x hold all corners of a cell.
    Corners(Vec<u32>),
    /// Integers spanning at most 255, as offsets from the low end of the range.
    U8(Vec<u8>),
    /// Integers spanning at most 65535, as offsets from the low end of the range.
    U16(Vec<u16>),
    /// Everything else, as display values 0…1.
    F32(Vec<f32>),
    /// Display values 0…1, of which some are NaN.
    Gaps(Vec<MaybeNan>),
}

/// A display value 0…1, or NaN.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct MaybeNan(pub f32);

/// A scalar field laid out for marching: 8³ cells to a brick, corners shared between bricks stored twice.
#[derive(Debug, Clone)]
pub struct Bricks {
    layout: BrickLayout,
    data: BrickData,
    /// Stored value to display value.
    scale: f32,
    interpolation: Interpolation,
}

impl Bricks {
    /// The bricks of `volume`, values clamped to its range, infinities at the low end.
    ///
    /// # Errors
    /// No memory for them.
    pub fn of_volume(volume: &Volume) -> Result<Self, Shortage> {
        let layout = BrickLayout::voxels(volume.grid().dims());
        let encoding = Encoding::of(volume);
        let (data, scale) = match encoding.span {
            Some(span) if span <= 255.0 && volume.grid().voxels() <= SMALL => {
                return Self::of_small_volume(volume, encoding, span);
            }
            Some(span) if span <= 255.0 => {
                (BrickData::U8(encoded(volume, &layout, |v| (v - encoding.low) as u8, encoding)?), span)
            }
            Some(span) if span <= 65535.0 => {
                (BrickData::U16(encoded(volume, &layout, |v| (v - encoding.low) as u16, encoding)?), span)
            }
            _ => {
                let inverse =
                    if encoding.high > encoding.low { 1.0 / (encoding.high - encoding.low) } else { 0.0 };
                let has_gaps = AtomicBool::new(false);
                let unit = |v: f64| {
                    if v.is_nan() {
                        has_gaps.store(true, Ordering::Relaxed);
                    }
                    ((v - encoding.low) * inverse) as f32
                };
                let values = encoded(volume, &layout, unit, encoding)?;
                if has_gaps.into_inner() {
                    (BrickData::Gaps(values.into_iter().map(MaybeNan).collect()), 1.0)
                } else {
                    (BrickData::F32(values), 1.0)
                }
            }
        };
        let scale = if scale > 0.0 { (1.0 / scale) as f32 } else { 0.0 };
        Ok(Self { layout, data, scale, interpolation: Interpolation::Linear })
    }

    /// The memory that the bricks of `volume` take, in bytes.
    pub fn bytes_of(volume: &Volume) -> u64 {
        let dims = volume.grid().dims();
        let (layout, size) = match Encoding::of(volume).span {
            Some(span) if span <= 255.0 && volume.grid().voxels() <= SMALL => (BrickLayout::corners(dims), 4),
            Some(span) if span <= 255.0 => (BrickLayout::voxels(dims), 1),
            Some(span) if span <= 65535.0 => (BrickLayout::voxels(dims), 2),
            _ => (BrickLayout::voxels(dims), 4),
        };
        layout.elements() as u64 * size
    }

    fn of_small_volume(volume: &Volume, encoding: Encoding, span: f64) -> Result<Self, Shortage> {
        let layout = BrickLayout::corners(volume.grid().dims());
        let data = with_voxel_type!(volume.dtype(), T => {
            let raw = RawVoxels::<'_, T>::new(volume);
            let byte = |voxel| (encoding.clamped(raw.get(voxel).to_f64()) - encoding.low) as u8;
            filled(&layout, corner_words(layout.dims, byte))?
        });
        let scale = if span > 0.0 { (1.0 / span) as f32 } else { 0.0 };
        Ok(Self { layout, data: BrickData::Corners(data), scale, interpolation: Interpolation::Linear })
    }

    /// Bricks of 8-bit display values on a grid of `dims`; 255 is 1. `put` writes a line of them along x, from a voxel on.
    ///
    /// # Errors
    /// Too little memory.
    pub(crate) fn of_bytes(
        dims: [usize; 3],
        put: impl Fn([usize; 3], &mut [u8]) + Sync,
    ) -> Result<Self, Shortage> {
        Self::of_lines(dims, BrickData::U8, 1.0 / 255.0, put)
    }

    /// Bricks of `data`, of which `scale` makes display values, on a grid of `dims`. `put` is that of [`Self::of_bytes`].
    ///
    /// # Errors
    /// Too little memory.
    pub(super) fn of_lines<S: Copy + Zeroable + Send + Sync>(
        dims: [usize; 3],
        data: impl FnOnce(Vec<S>) -> BrickData,
        scale: f32,
        put: impl Fn([usize; 3], &mut [S]) + Sync,
    ) -> Result<Self, Shortage> {
        let layout = BrickLayout::voxels(dims);
        let elements = filled_in_lines(&layout, |voxel, line: &mut [S]| {
            // Beyond the edge the last voxel repeats.
            let inside = line.len().min(dims[0] - voxel[0]);
            let (inside, beyond) = line.split_at_mut(inside);
            put(voxel, inside);
            beyond.fill(inside.last().copied().unwrap_or(S::zeroed()));
        })?;
        Ok(Self { layout, data: data(elements), scale, interpolation: Interpolation::Linear })
    }

    /// Where voxels lie.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// The stored values.
    pub fn data(&self) -> &BrickData {
        &self.data
    }

    /// How values between voxels are found.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Finds values between voxels so from now on; at first they are trilinear.
    pub fn set_interpolation(&mut self, interpolation: Interpolation) {
        self.interpolation = interpolation;
    }

    /// Whether some voxels are NaN.
    pub fn has_gaps(&self) -> bool {
        matches!(self.data, BrickData::Gaps(_))
    }

    /// The factor from a stored value to the display value 0…1.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// The display value of voxel (x, y, z); it may be NaN.
    #[inline]
    pub fn voxel(&self, voxel: [usize; 3]) -> f32 {
        self.stored(self.layout.index(voxel), [0, 0]) * self.scale
    }

    /// The stored value of voxel (x, y, z), [`Self::scale`] times which is its display value.
    #[cfg(feature = "gpu")]
    pub(crate) fn stored_voxel(&self, voxel: [usize; 3]) -> f32 {
        self.stored(self.layout.index(voxel), [0, 0])
    }

    /// The display value at `p`, continuous voxel-centre coordinates (voxel *i* at *i*), clamped to the edge.
    ///
    /// A trilinear value is NaN where one of the eight voxels around it is, whatever its weight.
    #[inline]
    pub fn sample(&self, p: [f32; 3]) -> f32 {
        let clamped: [f32; 3] = std::array::from_fn(|a| p[a].clamp(0.0, (self.layout.dims[a] - 1) as f32));
        if self.interpolation == Interpolation::Nearest {
            return self.voxel(clamped.map(|c| (c + 0.5) as usize));
        }
        let cell = clamped.map(|c| c as usize);
        let f: [f32; 3] = std::array::from_fn(|a| clamped[a] - cell[a] as f32);
        let at = self.layout.index(cell);
        let lerp = |a: f32, b: f32, f: f32| a + f * (b - a);
        let along_x = |y, z| lerp(self.stored(at, [y, z]), self.stored(at + 1, [y, z]), f[0]);
        let along_y = |z| lerp(along_x(0, z), along_x(1, z), f[1]);
        lerp(along_y(0), along_y(1), f[2]) * self.scale
    }

    /// The smallest and largest display value that interpolation gives in the cells `from`…`from + edge` (exclusive).
    ///
    /// Cells are clipped to the grid, and NaN is ignored. Where all values are NaN, the pair does not ascend.
    pub fn value_range(&self, from: [usize; 3], edge: usize) -> [f32; 2] {
        match &self.data {
            BrickData::Corners(words) => {
                self.extreme_bytes(words, from, edge).map(|v| f32::from(v) * self.scale)
            }
            BrickData::U8(v) => {
                self.extremes(v, from, edge, u8::MAX, u8::MIN).map(|v| f32::from(v) * self.scale)
            }
            BrickData::U16(v) => {
                self.extremes(v, from, edge, u16::MAX, u16::MIN).map(|v| f32::from(v) * self.scale)
            }
            BrickData::F32(v) => self.extremes(v, from, edge, f32::INFINITY, f32::NEG_INFINITY),
            BrickData::Gaps(v) => {
                let [top, bottom] = [f32::INFINITY, f32::NEG_INFINITY].map(MaybeNan);
                self.extremes(v, from, edge, top, bottom).map(|v| v.0)
            }
        }
    }

    /// Whether interpolation can give NaN in the cells `from`…`from + edge` (exclusive), clipped to the grid.
    pub fn has_gaps_in(&self, from: [usize; 3], edge: usize) -> bool {
        let BrickData::Gaps(values) = &self.data else { return false };
        let start = self.layout.index(from);
        let [_, uy, uz] = self.layout.unit;
        (0..=edge).any(|z| {
            (0..=edge).any(|y| {
                let row = start + y * uy + z * uz;
                values[row..=row + edge].iter().any(|v| v.0.is_nan())
            })
        })
    }

    fn extremes<T: Copy + PartialOrd>(
        &self,
        values: &[T],
        from: [usize; 3],
        edge: usize,
        top: T,
        bottom: T,
    ) -> [T; 2] {
        debug_assert!(from[0] % BRICK + edge <= BRICK, "a range may not cross bricks");
        let start = self.layout.index(from);
        let [_, uy, uz] = self.layout.unit;
        let (mut low, mut high) = (top, bottom);
        for z in 0..=edge {
            for y in 0..=edge {
                let row = start + y * uy + z * uz;
                for &v in &values[row..=row + edge] {
                    low = if v < low { v } else { low };
                    high = if v > high { v } else { high };
                }
            }
        }
        [low, high]
    }

    /// Minimum and maximum stored byte of the block of `edge`³ cells at `from`, for packed corners.
    ///
    /// Every word also holds its neighbours along y and z, so the loops stop one row and one slice earlier than in
    /// `extremes`.
    fn extreme_bytes(&self, words: &[u32], from: [usize; 3], edge: usize) -> [u8; 2] {
        let start = self.layout.index(from);
        let [_, uy, uz] = self.layout.unit;
        let (mut low, mut high) = (u8::MAX, u8::MIN);
        for z in 0..edge {
            for y in 0..edge {
                let row = start + y * uy + z * uz;
                for byte in words[row..=row + edge].iter().flat_map(|w| w.to_le_bytes()) {
                    low = low.min(byte);
                    high = high.max(byte);
                }
            }
        }
        [low, high]
    }

    /// The stored value `[y, z]` (0 or 1 each) after element `at`.
    #[inline]
    fn stored(&self, at: usize, [y, z]: [usize; 2]) -> f32 {
        let after = at + y * self.layout.unit[1] + z * self.layout.unit[2];
        match &self.data {
            BrickData::Corners(words) => f32::from(words[at].to_le_bytes()[y + 2 * z]),
            BrickData::U8(v) => f32::from(v[after]),
            BrickData::U16(v) => f32::from(v[after]),
            BrickData::F32(v) => v[after],
            BrickData::Gaps(v) => v[after].0,
        }
    }
}

/// Words of four neighbours, from the bytes of voxels; beyond the edge the last one repeats.
fn corner_words(
    dims: [usize; 3],
    byte: impl Fn([usize; 3]) -> u8 + Sync,
) -> impl Fn([usize; 3]) -> u32 + Sync {
    move |[x, y, z]| {
        let (y1, z1) = ((y + 1).min(dims[1] - 1), (z + 1).min(dims[2] - 1));
        u32::from_le_bytes([byte([x, y, z]), byte([x, y1, z]), byte([x, y, z1]), byte([x, y1, z1])])
    }
}

/// How raw values become stored ones.
#[derive(Clone, Copy)]
struct Encoding {
    low: f64,
    high: f64,
    /// high − low where every value in between is an integer offset from low.
    span: Option<f64>,
    rescale: Rescale,
}

impl Encoding {
    fn of(volume: &Volume) -> Self {
        let [low, high] = volume.range();
        let rescale = volume.rescale();
        let whole = volume.dtype().is_integer()
            && [low, high, rescale.slope, rescale.intercept].iter().all(|x| x.fract() == 0.0)
            && !matches!(volume.dtype(), Dtype::I64 | Dtype::U64);
        Self { low, high, span: whole.then_some(high - low), rescale }
    }

    #[inline]
    fn clamped(self, raw: f64) -> f64 {
        let value = self.rescale.apply(raw);
        if value.is_infinite() { self.low } else { value.clamp(self.low, self.high) }
    }
}

/// Stored elements made from raw voxels by clamping and `store`.
fn encoded<S>(
    volume: &Volume,
    layout: &BrickLayout,
    store: impl Fn(f64) -> S + Sync,
    encoding: Encoding,
) -> Result<Vec<S>, Shortage>
where
    S: Copy + Zeroable + Send + Sync,
{
    if volume.dtype().size() == 1 {
        // Narrow integers take few values: look the conversion up.
        let value = |byte: u8| match volume.dtype() {
            Dtype::I8 => f64::from(byte.cast_signed()),
            _ => f64::from(byte),
        };
        let table: Vec<S> = (0..=255u8).map(|byte| store(encoding.clamped(value(byte)))).collect();
        let raw = RawVoxels::<'_, u8>::new(volume);
        return filled(layout, |voxel| table[usize::from(raw.get(voxel))]);
    }
    with_voxel_type!(volume.dtype(), T => {
        let raw = RawVoxels::<'_, T>::new(volume);
        filled(layout, |voxel| store(encoding.clamped(raw.get(voxel).to_f64())))
    })
}

/// Fills all bricks in parallel; voxels beyond the edge repeat the last one.
fn filled<S: Copy + Zeroable + Send + Sync>(
    layout: &BrickLayout,
    value: impl Fn([usize; 3]) -> S + Sync,
) -> Result<Vec<S>, Shortage> {
    let last = layout.dims[0] - 1;
    filled_in_lines(layout, |[first, y, z], line: &mut [S]| {
        for (x, element) in line.iter_mut().enumerate() {
            *element = value([(first + x).min(last), y, z]);
        }
    })
}

/// Fills all bricks in parallel. `put` writes the elements along x from a voxel on, which may end beyond the edge; lines beyond
/// it repeat the last one.
fn filled_in_lines<S: Copy + Zeroable + Send + Sync>(
    layout: &BrickLayout,
    put: impl Fn([usize; 3], &mut [S]) + Sync,
) -> Result<Vec<S>, Shortage> {
    let mut data = memory::zeroed::<S>(layout.elements(), "the voxels in bricks", SMALLER_VOLUME)?;
    let [bx, by, bz] = layout.bricks();
    let [ex, ey, ez] = layout.edges;
    let last = layout.dims.map(|d| d - 1);
    for_each_brick(&mut data[..bx * by * bz * layout.stride], layout.stride, &|brick, out| {
        let corner = [brick % bx, brick / bx % by, brick / (bx * by)].map(|b| b * BRICK);
        for z in 0..ez {
            stop::point();
            for y in 0..ey {
                let line = &mut out[(z * ey + y) * ex..][..ex];
                put([corner[0], (corner[1] + y).min(last[1]), (corner[2] + z).min(last[2])], line);
            }
        }
    });
    Ok(data)
}

/// Calls `fill` in parallel with the number and the elements of each brick of `data`.
///
/// `fill` is a trait object: rayon's code would else be compiled for every type of voxel and every way to store it.
fn for_each_brick<S: Send>(data: &mut [S], stride: usize, fill: &(dyn Fn(usize, &mut [S]) + Sync)) {
    data.par_chunks_mut(stride).enumerate().for_each(|(brick, out)| fill(brick, out));
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;
    use proptest::prelude::*;

    fn volume(dims: [usize; 3], values: Vec<i16>) -> Volume {
        Volume::from_values(Grid::new(dims, [1.0; 3]).unwrap(), values).unwrap()
    }

    /// The memory of `bricks`.
    fn bytes(bricks: &Bricks) -> u64 {
        (match bricks.data() {
            BrickData::Corners(values) => size_of_val(&values[..]),
            BrickData::U8(values) => size_of_val(&values[..]),
            BrickData::U16(values) => size_of_val(&values[..]),
            BrickData::F32(values) => size_of_val(&values[..]),
            BrickData::Gaps(values) => size_of_val(&values[..]),
        }) as u64
    }

    proptest! {
        #[test]
        fn every_voxel_is_found_again(
            dims in prop::array::uniform3(1usize..21),
            seed in 0i32..1000,
        ) {
            let n: usize = dims.iter().product();
            let values: Vec<i16> = (0..n as i32).map(|i| (i.wrapping_mul(7919 + seed) % 5000 - 2500) as i16).collect();
            let volume = volume(dims, values);
            let bricks = Bricks::of_volume(&volume).unwrap();
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let expected = volume.normalised(volume.value([x, y, z])) as f32;
                        prop_assert!((bricks.voxel([x, y, z]) - expected).abs() < 1e-6);
                        let p = [x as f32, y as f32, z as f32];
                        prop_assert!((bricks.sample(p) - expected).abs() < 1e-6);
                    }
                }
            }
        }

        #[test]
        fn interpolation_is_between_its_corners_and_linear(
            x in 0.0f32..11.0, y in 0.0f32..11.0, z in 0.0f32..11.0,
        ) {
            // A field linear in x, y and z is met exactly everywhere, across bricks too.
            let dims = [12usize; 3];
            let values = (0..12i16).flat_map(|z| (0..12i16).flat_map(move |y| (0..12i16).map(move |x| x + 2 * y + 3 * z))).collect();
            let volume = volume(dims, values);
            let bricks = Bricks::of_volume(&volume).unwrap();
            prop_assert_eq!(Bricks::bytes_of(&volume), bytes(&bricks));
            let expected = (x + 2.0 * y + 3.0 * z) / 66.0;
            prop_assert!((bricks.sample([x, y, z]) - expected).abs() < 1e-5);
        }
    }

    #[test]
    fn values_are_clamped_before_interpolation() {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![0.0f32, 4.0]).unwrap().with_range([0.0, 1.0]).unwrap();
        assert_eq!(Bricks::of_volume(&volume).unwrap().sample([0.5, 0.0, 0.0]), 0.5);
    }

    #[test]
    fn the_narrowest_exact_type_is_stored() {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let narrow = Volume::from_values(grid, vec![-1000i16, -800]).unwrap();
        assert!(matches!(Bricks::of_volume(&narrow).unwrap().data(), BrickData::Corners(_)));
        let wide = Volume::from_values(grid, vec![-1000i16, 3000]).unwrap();
        assert!(matches!(Bricks::of_volume(&wide).unwrap().data(), BrickData::U16(_)));
        let odd_range = wide.with_range([0.5, 10.0]).unwrap();
        assert!(matches!(Bricks::of_volume(&odd_range).unwrap().data(), BrickData::F32(_)));
        let infinite =
            Bricks::of_volume(&Volume::from_values(grid, vec![f32::INFINITY, 2.0]).unwrap()).unwrap();
        assert!(matches!(infinite.data(), BrickData::F32(_)) && infinite.voxel([0, 0, 0]) == 0.0);
        let nan = Bricks::of_volume(&Volume::from_values(grid, vec![f32::NAN, 2.0]).unwrap()).unwrap();
        assert!(matches!(nan.data(), BrickData::Gaps(_)) && nan.voxel([0, 0, 0]).is_nan());
    }
}
