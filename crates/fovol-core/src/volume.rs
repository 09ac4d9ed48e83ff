use crate::{Contents, Dtype, Endian, Error, Grid, Placement, Result, Statistics, Voxel, with_voxel_type};
use glam::DVec3;
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::sync::{Arc, OnceLock};

/// The bytes behind a volume: a heap buffer or a memory map, shared, never copied.
pub type VoxelBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// The scaling that a file declares: value = slope · raw + intercept (NIfTI `scl_slope`, DICOM rescale).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rescale {
    /// Factor; finite and not zero.
    pub slope: f64,
    /// Offset; finite.
    pub intercept: f64,
}

impl Rescale {
    /// No scaling.
    pub const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// The scaled value of `raw`.
    #[inline]
    pub fn apply(self, raw: f64) -> f64 {
        self.slope * raw + self.intercept
    }
}

/// A scalar field on a regular [`Grid`], as it lies in memory or in a file: x fastest, then y, then z,
/// components interleaved. Only the first component is shown.
#[derive(Clone)]
pub struct Volume {
    grid: Grid,
    dtype: Dtype,
    endian: Endian,
    components: usize,
    bytes: VoxelBytes,
    offset: usize,
    rescale: Rescale,
    range: Option<[f64; 2]>,
    format: String,
    placement: Option<Placement>,
    units: Option<String>,
    contents: Contents,
    no_data: Option<f64>,
    notes: Vec<String>,
    statistics: Arc<OnceLock<Statistics>>,
}

impl Volume {
    /// A volume over `bytes`, which hold at least dims × components × `dtype` of native-endian data.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] when they do not.
    pub fn new(grid: Grid, dtype: Dtype, bytes: VoxelBytes) -> Result<Self> {
        let endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };
        Self::with_layout(grid, dtype, endian, 1, bytes, 0)
    }

    /// A volume whose first component lies `offset` bytes into `bytes`, in the given order,
    /// with `components` interleaved values per voxel.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] when `bytes` end early; [`Error::Extent`] for zero components.
    pub fn with_layout(
        grid: Grid,
        dtype: Dtype,
        endian: Endian,
        components: usize,
        bytes: VoxelBytes,
        offset: usize,
    ) -> Result<Self> {
        if components == 0 {
            return Err(Error::Extent {
                what: "number of components".into(),
                found: "0".into(),
                expected: "1 or more".into(),
            });
        }
        let needed = (grid.voxels() as u128) * (components as u128) * (dtype.size() as u128);
        let found = (*bytes).as_ref().len().saturating_sub(offset) as u64;
        if needed > u128::from(found) {
            return Err(Error::TooFewBytes { needed: u64::try_from(needed).unwrap_or(u64::MAX), found });
        }
        Ok(Self {
            grid,
            dtype,
            endian,
            components,
            bytes,
            offset,
            rescale: Rescale::IDENTITY,
            range: None,
            format: "memory".into(),
            placement: None,
            units: None,
            contents: Contents { components, ..Contents::default() },
            no_data: None,
            notes: Vec::new(),
            statistics: Arc::default(),
        })
    }

    /// A one-component volume from typed values, x fastest.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] when there are fewer values than voxels.
    pub fn from_values<T: Voxel + bytes::Plain>(grid: Grid, values: Vec<T>) -> Result<Self> {
        Self::new(grid, T::DTYPE, Arc::new(bytes::Owned(values)))
    }

    /// The same volume with the scaling that its file declares.
    ///
    /// # Errors
    /// A slope that is zero or not finite, an intercept that is not finite.
    pub fn with_rescale(mut self, rescale: Rescale) -> Result<Self> {
        crate::checked("scale slope", rescale.slope, "a finite number other than 0", rescale.slope != 0.0)?;
        crate::checked("scale intercept", rescale.intercept, "a finite number", true)?;
        self.rescale = rescale;
        self.statistics = Arc::default();
        Ok(self)
    }

    /// The same volume shown over `range` (scaled values) instead of its own range.
    ///
    /// # Errors
    /// Bounds that are not finite and rising.
    pub fn with_range(mut self, range: [f64; 2]) -> Result<Self> {
        crate::checked("range low end", range[0], "a finite number", true)?;
        crate::checked("range high end", range[1], "a finite number above the low end", range[1] > range[0])?;
        self.range = Some(range);
        Ok(self)
    }

    /// The same volume with another spacing.
    ///
    /// # Errors
    /// A spacing that is not finite and positive.
    pub fn with_spacing(mut self, spacing: [f64; 3]) -> Result<Self> {
        self.grid = Grid::new(self.grid.dims(), spacing)?;
        Ok(self)
    }

    /// The same volume with the name of the format it was read from.
    #[must_use]
    pub fn with_format(mut self, format: impl Into<String>) -> Self {
        self.format = format.into();
        self
    }

    /// The same volume where its file places it.
    #[must_use]
    pub fn with_placement(mut self, placement: Placement) -> Self {
        self.placement = Some(placement);
        self
    }

    /// The same volume with the unit of its spacing, by its symbol: `mm`, `µm`, `m`.
    #[must_use]
    pub fn with_units(mut self, units: impl Into<String>) -> Self {
        self.units = Some(units.into());
        self
    }

    /// The same volume as a part of what its file holds.
    #[must_use]
    pub fn with_contents(mut self, contents: Contents) -> Self {
        self.contents = contents;
        self
    }

    /// The same volume, in which the scaled value `no_data` stands for voxels without one: the range leaves it out.
    #[must_use]
    pub fn with_no_data(mut self, no_data: f64) -> Self {
        self.no_data = Some(no_data);
        self.statistics = Arc::default();
        self
    }

    /// Component `index` of each voxel alone; component 0 is shown where it lies, others are copied.
    ///
    /// # Errors
    /// [`Error::Extent`] when there is no such component.
    pub fn with_component(mut self, index: usize) -> Result<Self> {
        if index >= self.components {
            return Err(Error::Extent {
                what: "component".into(),
                found: index.to_string(),
                expected: format!("0 to {}", self.components - 1),
            });
        }
        if index > 0 {
            let size = self.dtype.size();
            let voxels = self.data().chunks_exact(self.components * size);
            let bytes: Vec<u8> =
                voxels.flat_map(|voxel| &voxel[index * size..(index + 1) * size]).copied().collect();
            (self.bytes, self.offset, self.components) = (Arc::new(bytes), 0, 1);
            self.contents.component = index;
            self.statistics = Arc::default();
        }
        Ok(self)
    }

    /// This volume with one more thing that was doubtful when it was read: one line, in which control characters are escaped.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
        self.notes.push(note.into().chars().map(shown).collect());
        self
    }

    /// This volume, made of the bytes of `other`, with what the reading of `other` had to say.
    #[must_use]
    pub fn with_notes_of(mut self, other: &Self) -> Self {
        self.contents.clone_from(&other.contents);
        self.no_data = other.no_data;
        self.notes.clone_from(&other.notes);
        self
    }

    /// The voxels of `part` along x, y and z alone, shown over the same range of values.
    ///
    /// # Errors
    /// A part that is empty or reaches beyond the volume.
    pub fn part(&self, part: &[Range<usize>; 3]) -> Result<Self> {
        let dims = self.grid.dims();
        for (axis, (range, dim)) in part.iter().zip(dims).enumerate() {
            if range.is_empty() || range.end > dim {
                return Err(Error::Extent {
                    what: format!("part along {}", ["x", "y", "z"][axis]),
                    found: format!("{}..{}", range.start, range.end),
                    expected: format!("at least one voxel of 0..{dim}"),
                });
            }
        }
        let first = DVec3::from_array(part.each_ref().map(|range| range.start as f64));
        let placement = self.placement.map(|placement| placement.moved_to(first, &self.grid));
        let [along_x, along_y, along_z] = part.clone();
        let voxel = self.components * self.dtype.size();
        let mut bytes = Vec::with_capacity(along_x.len() * along_y.len() * along_z.len() * voxel);
        for z in along_z {
            for y in along_y.clone() {
                let row = (z * dims[1] + y) * dims[0];
                bytes.extend_from_slice(
                    &self.data()[(row + along_x.start) * voxel..(row + along_x.end) * voxel],
                );
            }
        }
        Ok(Self {
            grid: Grid::new(part.each_ref().map(Range::len), self.grid.spacing())?,
            placement,
            bytes: Arc::new(bytes),
            offset: 0,
            range: self.lasting_range(),
            statistics: Arc::default(),
            ..self.clone()
        })
    }

    /// `other`, which averages voxels of this volume, with what else this volume says of them.
    pub(crate) fn dressed(&self, other: Self) -> Self {
        let [coarse, fine] = [&other, self].map(|volume| DVec3::from_array(volume.grid.spacing()));
        let first = (coarse / fine - 1.0) * 0.5;
        Self {
            rescale: self.rescale,
            range: self.lasting_range(),
            format: self.format.clone(),
            placement: self.placement.map(|placement| placement.moved_to(first, &self.grid)),
            units: self.units.clone(),
            statistics: Arc::default(),
            ..other.with_notes_of(self)
        }
    }

    /// The range of a volume that is made of this one: colours stay, whatever values are in it.
    fn lasting_range(&self) -> Option<[f64; 2]> {
        let is_usual = self.dtype == Dtype::U8 && self.rescale == Rescale::IDENTITY;
        self.range.or((!is_usual).then(|| self.range()))
    }

    /// Size and spacing.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The type of one component.
    pub fn dtype(&self) -> Dtype {
        self.dtype
    }

    /// The byte order of [`Self::data`].
    pub fn endian(&self) -> Endian {
        self.endian
    }

    /// Interleaved values per voxel.
    pub fn components(&self) -> usize {
        self.components
    }

    /// The scaling that the file declares.
    pub fn rescale(&self) -> Rescale {
        self.rescale
    }

    /// The name of the format it was read from, for `info`.
    pub fn format(&self) -> &str {
        &self.format
    }

    /// Where its file places it, if the file says so.
    pub fn placement(&self) -> Option<&Placement> {
        self.placement.as_ref()
    }

    /// The unit of its spacing, by its symbol, if the file says so.
    pub fn units(&self) -> Option<&str> {
        self.units.as_deref()
    }

    /// What its file holds, and which part of it this is.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// The scaled value that stands for voxels without one, where the file declares it.
    pub fn no_data(&self) -> Option<f64> {
        self.no_data
    }

    /// What was doubtful when it was read, one line each: bytes that were left over, sizes that contradict each other.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All voxels as bytes: dims × components × dtype, in [`Self::endian`] order.
    pub fn data(&self) -> &[u8] {
        let length = self.grid.voxels() * self.components * self.dtype.size();
        &(*self.bytes).as_ref()[self.offset..self.offset + length]
    }

    /// The interval that maps to v = 0…1, in scaled values: what was asked for, else 0…255 for
    /// unscaled u8, else the finite minimum…maximum without values far outside all others
    /// ([`Statistics::shown`]).
    pub fn range(&self) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        if self.dtype == Dtype::U8 && self.rescale == Rescale::IDENTITY {
            return [0.0, 255.0];
        }
        self.statistics().shown
    }

    /// Whether [`Self::range`] was asked for rather than found.
    pub fn range_is_chosen(&self) -> bool {
        self.range.is_some()
    }

    /// Minimum, maximum, mean and the number of non-finite values; computed once.
    pub fn statistics(&self) -> &Statistics {
        self.statistics.get_or_init(|| Statistics::of(self))
    }

    /// The value of voxel `[x, y, z]` after scaling.
    ///
    /// # Panics
    /// When the voxel lies outside the grid.
    pub fn value(&self, voxel: [usize; 3]) -> f64 {
        let [nx, ny, nz] = self.grid.dims();
        let [x, y, z] = voxel;
        assert!(x < nx && y < ny && z < nz, "voxel {voxel:?} outside the grid {nx}x{ny}x{nz}");
        let at = ((z * ny + y) * nx + x) * self.components * self.dtype.size();
        let bytes = &self.data()[at..at + self.dtype.size()];
        let raw = with_voxel_type!(self.dtype, T => T::decode(bytes, self.endian).to_f64());
        self.rescale.apply(raw)
    }

    /// The display value of a scaled value: clamp((value − lo)/(hi − lo), 0, 1); non-finite values are 0.
    pub fn normalised(&self, value: f64) -> f64 {
        let [lo, hi] = self.range();
        if value.is_finite() && hi > lo { ((value - lo) / (hi - lo)).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Calls `visit` with each raw first component (before scaling) of the voxels in `range`
    /// (positions in x-fastest order), as `T`, which must be the type of [`Self::dtype`].
    ///
    /// # Panics
    /// When `T` is another type.
    #[inline]
    pub fn for_each_raw<T: Voxel>(&self, range: RangeInclusive<usize>, mut visit: impl FnMut(T)) {
        assert_eq!(T::DTYPE, self.dtype, "for_each_raw wants the volume's own type");
        let stride = self.components * self.dtype.size();
        let bytes = &self.data()[range.start() * stride..(range.end() + 1) * stride];
        let endian = self.endian;
        for voxel in bytes.chunks_exact(stride) {
            visit(T::decode(&voxel[..size_of::<T>()], endian));
        }
    }
}

impl fmt::Debug for Volume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Volume")
            .field("grid", &self.grid)
            .field("dtype", &self.dtype)
            .field("components", &self.components)
            .field("format", &self.format)
            .finish_non_exhaustive()
    }
}

/// Owned typed values seen as bytes.
pub(crate) mod bytes {
    use half::f16;

    /// Types without padding, every bit pattern of which is a value.
    pub trait Plain: Copy {}
    impl Plain for u8 {}
    impl Plain for i8 {}
    impl Plain for u16 {}
    impl Plain for i16 {}
    impl Plain for u32 {}
    impl Plain for i32 {}
    impl Plain for u64 {}
    impl Plain for i64 {}
    impl Plain for f16 {}
    impl Plain for f32 {}
    impl Plain for f64 {}

    pub struct Owned<T>(pub Vec<T>);

    impl<T: Plain> AsRef<[u8]> for Owned<T> {
        fn as_ref(&self) -> &[u8] {
            // SAFETY: `Plain` types have no padding, and a byte has no alignment to respect.
            unsafe { std::slice::from_raw_parts(self.0.as_ptr().cast(), size_of_val(self.0.as_slice())) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dims: [usize; 3]) -> Grid {
        Grid::new(dims, [1.0; 3]).unwrap()
    }

    #[test]
    fn x_is_fastest() {
        let volume = Volume::from_values(grid([2, 3, 4]), (0u16..24).collect()).unwrap();
        assert_eq!(volume.value([1, 0, 0]), 1.0);
        assert_eq!(volume.value([0, 1, 0]), 2.0);
        assert_eq!(volume.value([0, 0, 1]), 6.0);
        assert_eq!(volume.range(), [0.0, 23.0]);
    }

    #[test]
    fn only_the_first_component_is_read() {
        let bytes: VoxelBytes = Arc::new(vec![9u8, 1, 2, 3, 4, 5, 6]);
        let volume = Volume::with_layout(grid([2, 1, 1]), Dtype::U8, Endian::Big, 3, bytes, 1).unwrap();
        assert_eq!([volume.value([0, 0, 0]), volume.value([1, 0, 0])], [1.0, 4.0]);
        assert_eq!(volume.statistics().max, 4.0);
    }

    #[test]
    fn too_few_bytes_are_an_error() {
        let bytes: VoxelBytes = Arc::new(vec![0u8; 15]);
        let error = Volume::new(grid([2, 2, 2]), Dtype::U16, bytes).unwrap_err();
        assert_eq!(error, Error::TooFewBytes { needed: 16, found: 15 });
    }

    #[test]
    fn u8_spans_its_type_others_their_data() {
        let volume = Volume::from_values(grid([2, 1, 1]), vec![10u8, 20]).unwrap();
        assert_eq!(volume.range(), [0.0, 255.0]);
        let volume = Volume::from_values(grid([3, 1, 1]), vec![-4.0f32, f32::NAN, 2.0]).unwrap();
        assert_eq!(volume.range(), [-4.0, 2.0]);
        assert_eq!(volume.statistics().non_finite, 1);
        assert_eq!(volume.normalised(f64::NAN), 0.0);
        assert_eq!(volume.normalised(-1.0), 0.5);
    }

    #[test]
    fn scaling_shows_in_values_and_range() {
        let volume = Volume::from_values(grid([2, 1, 1]), vec![0i16, 10]).unwrap();
        let volume = volume.with_rescale(Rescale { slope: 2.0, intercept: -1.0 }).unwrap();
        assert_eq!(volume.value([1, 0, 0]), 19.0);
        assert_eq!(volume.range(), [-1.0, 19.0]);
    }
}
