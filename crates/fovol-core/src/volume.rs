use crate::found::Found;
use crate::{Contents, Dtype, Endian, Error, Grid, Placement, Result, Voxel, with_voxel_type};
use glam::DVec3;
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::sync::Arc;

/// Bytes behind a volume: a heap buffer or a memory map, shared and never copied.
pub type VoxelBytes = Arc<dyn AsRef<[u8]> + Send + Sync>;

/// Scaling declared by a file: value = slope · raw + intercept (NIfTI `scl_slope`, DICOM rescale).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rescale {
    /// Factor; finite and not zero.
    pub slope: f64,
    /// Offset; finite.
    pub intercept: f64,
}

impl Rescale {
    /// Identity scaling.
    pub const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };

    /// Scales the raw value `raw`.
    #[inline]
    pub fn apply(self, raw: f64) -> f64 {
        self.slope * raw + self.intercept
    }
}

/// Scalar field on a regular [`Grid`], in the layout of memory or file: x fastest, then y, then z, components
/// interleaved. Only the first component is shown.
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
    pub(crate) found: Arc<Found>,
}

impl Volume {
    /// Volume over `bytes` with at least dims × components × `dtype` of native-endian data.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] if there are fewer bytes.
    pub fn new(grid: Grid, dtype: Dtype, bytes: VoxelBytes) -> Result<Self> {
        let endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };
        Self::with_layout(grid, dtype, endian, 1, bytes, 0)
    }

    /// Volume whose first component lies `offset` bytes into `bytes`, in the given byte order, with `components`
    /// interleaved values per voxel.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] if `bytes` end early; [`Error::Extent`] for zero components.
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
            found: Arc::default(),
        })
    }

    /// One-component volume from typed values, x fastest.
    ///
    /// # Errors
    /// [`Error::TooFewBytes`] if there are fewer values than voxels.
    pub fn from_values<T: Voxel + bytes::Plain>(grid: Grid, values: Vec<T>) -> Result<Self> {
        Self::new(grid, T::DTYPE, Arc::new(bytes::Owned(values)))
    }

    /// Sets the scaling that the file declares.
    ///
    /// # Errors
    /// A slope that is zero or not finite, an intercept that is not finite.
    pub fn with_rescale(mut self, rescale: Rescale) -> Result<Self> {
        crate::checked("scale slope", rescale.slope, "a finite number other than 0", rescale.slope != 0.0)?;
        crate::checked("scale intercept", rescale.intercept, "a finite number", true)?;
        self.rescale = rescale;
        self.found = Arc::default();
        Ok(self)
    }

    /// Sets the displayed range (scaled values) instead of the volume's own.
    ///
    /// # Errors
    /// Bounds that are not finite and rising.
    pub fn with_range(mut self, range: [f64; 2]) -> Result<Self> {
        crate::checked("range low end", range[0], "a finite number", true)?;
        crate::checked("range high end", range[1], "a finite number above the low end", range[1] > range[0])?;
        self.range = Some(range);
        Ok(self)
    }

    /// Sets another spacing.
    ///
    /// # Errors
    /// A spacing that is not finite and positive.
    pub fn with_spacing(mut self, spacing: [f64; 3]) -> Result<Self> {
        self.grid = Grid::new(self.grid.dims(), spacing)?;
        Ok(self)
    }

    /// Sets the name of the file's format.
    #[must_use]
    pub fn with_format(mut self, format: impl Into<String>) -> Self {
        self.format = format.into();
        self
    }

    /// Sets the position that the file declares.
    #[must_use]
    pub fn with_placement(mut self, placement: Placement) -> Self {
        self.placement = Some(placement);
        self
    }

    /// Sets the unit of the spacing by its symbol: `mm`, `µm`, `m`.
    #[must_use]
    pub fn with_units(mut self, units: impl Into<String>) -> Self {
        self.units = Some(units.into());
        self
    }

    /// Sets the description of the file's content.
    #[must_use]
    pub fn with_contents(mut self, contents: Contents) -> Self {
        self.contents = contents;
        self
    }

    /// Sets the scaled value that marks voxels without data; the range leaves it out.
    #[must_use]
    pub fn with_no_data(mut self, no_data: f64) -> Self {
        self.no_data = Some(no_data);
        self.found = Arc::default();
        self
    }

    /// Selects component `index` of each voxel. Component 0 is used in place, others are copied.
    ///
    /// # Errors
    /// [`Error::Extent`] if there is no such component.
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
            self.found = Arc::default();
        }
        Ok(self)
    }

    /// Adds a warning from reading the file: one line, with control characters escaped.
    #[must_use]
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
        self.notes.push(note.into().chars().map(shown).collect());
        self
    }

    /// Copies warnings, content description and missing-data value from `other`, from whose bytes this volume was
    /// made.
    #[must_use]
    pub fn with_notes_of(mut self, other: &Self) -> Self {
        self.contents.clone_from(&other.contents);
        self.no_data = other.no_data;
        self.notes.clone_from(&other.notes);
        self
    }

    /// Crops the volume to the voxels of `part` along x, y and z; the displayed range stays.
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
            found: Arc::default(),
            ..self.clone()
        })
    }

    /// Copies this volume's metadata to `other`, a downsampled version of it.
    pub(crate) fn dressed(&self, other: Self) -> Self {
        let [coarse, fine] = [&other, self].map(|volume| DVec3::from_array(volume.grid.spacing()));
        let first = (coarse / fine - 1.0) * 0.5;
        Self {
            rescale: self.rescale,
            range: self.lasting_range(),
            format: self.format.clone(),
            placement: self.placement.map(|placement| placement.moved_to(first, &self.grid)),
            units: self.units.clone(),
            found: Arc::default(),
            ..other.with_notes_of(self)
        }
    }

    /// Range of a volume derived from this one; fixed, so that colours stay.
    fn lasting_range(&self) -> Option<[f64; 2]> {
        let is_usual = self.dtype == Dtype::U8 && self.rescale == Rescale::IDENTITY;
        self.range.or((!is_usual).then(|| self.range()))
    }

    /// Size and spacing.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Type of one component.
    pub fn dtype(&self) -> Dtype {
        self.dtype
    }

    /// Byte order of [`Self::data`].
    pub fn endian(&self) -> Endian {
        self.endian
    }

    /// Interleaved values per voxel.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Scaling declared by the file.
    pub fn rescale(&self) -> Rescale {
        self.rescale
    }

    /// Name of the file's format, for `info`.
    pub fn format(&self) -> &str {
        &self.format
    }

    /// Position declared by the file.
    pub fn placement(&self) -> Option<&Placement> {
        self.placement.as_ref()
    }

    /// Symbol of the unit of the spacing, if the file declares it.
    pub fn units(&self) -> Option<&str> {
        self.units.as_deref()
    }

    /// Content of the file, and the part of it that this volume holds.
    pub fn contents(&self) -> &Contents {
        &self.contents
    }

    /// Scaled value that marks voxels without data, if the file declares one.
    pub fn no_data(&self) -> Option<f64> {
        self.no_data
    }

    /// Warnings from reading the file, one line each: for example left-over bytes or contradictory sizes.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All voxels as bytes: dims × components × dtype, in [`Self::endian`] order.
    pub fn data(&self) -> &[u8] {
        let length = self.grid.voxels() * self.components * self.dtype.size();
        &(*self.bytes).as_ref()[self.offset..self.offset + length]
    }

    /// Displayed range: the scaled values that map to v = 0…1. It is the range that was set, else 0…255 for unscaled
    /// u8, else the finite minimum…maximum without outliers ([`shown`](crate::Statistics::shown)).
    pub fn range(&self) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        if self.dtype == Dtype::U8 && self.rescale == Rescale::IDENTITY {
            return [0.0, 255.0];
        }
        self.statistics().shown
    }

    /// Whether [`Self::range`] was set rather than computed.
    pub fn range_is_chosen(&self) -> bool {
        self.range.is_some()
    }

    /// Value of voxel `[x, y, z]` after scaling.
    ///
    /// # Panics
    /// If the voxel lies outside the grid.
    pub fn value(&self, voxel: [usize; 3]) -> f64 {
        let [nx, ny, nz] = self.grid.dims();
        let [x, y, z] = voxel;
        assert!(x < nx && y < ny && z < nz, "voxel {voxel:?} outside the grid {nx}x{ny}x{nz}");
        let at = ((z * ny + y) * nx + x) * self.components * self.dtype.size();
        let bytes = &self.data()[at..at + self.dtype.size()];
        let raw = with_voxel_type!(self.dtype, T => T::decode(bytes, self.endian).to_f64());
        self.rescale.apply(raw)
    }

    /// Display value of a scaled value: clamp((value − lo)/(hi − lo), 0, 1); 0 for non-finite values.
    pub fn normalised(&self, value: f64) -> f64 {
        let [lo, hi] = self.range();
        if value.is_finite() && hi > lo { ((value - lo) / (hi - lo)).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Calls `visit` with the raw first component (before scaling) of each voxel in `range` (positions in x-fastest
    /// order). `T` must be the type of [`Self::dtype`].
    ///
    /// # Panics
    /// If `T` is another type.
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

/// Typed values viewed as bytes.
pub(crate) mod bytes {
    use half::f16;

    /// Types without padding for which every bit pattern is valid.
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
