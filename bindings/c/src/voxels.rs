use crate::pointers::{Growing, slice, text};
use crate::status::Failure;
use fovolnet::OpenVolume;
use fovolnet::core::{Contents, Dtype, Endian, Grid, Placement, Space, Volume};
use glam::{DMat3, DVec3};
use std::ffi::{c_char, c_void};
use std::sync::Arc;

/// Type of voxels.
pub type FovolnetDtype = i32;
/// uint8_t
pub const FOVOLNET_U8: FovolnetDtype = 1;
/// int8_t
pub const FOVOLNET_I8: FovolnetDtype = 2;
/// uint16_t
pub const FOVOLNET_U16: FovolnetDtype = 3;
/// int16_t
pub const FOVOLNET_I16: FovolnetDtype = 4;
/// uint32_t
pub const FOVOLNET_U32: FovolnetDtype = 5;
/// int32_t
pub const FOVOLNET_I32: FovolnetDtype = 6;
/// uint64_t
pub const FOVOLNET_U64: FovolnetDtype = 7;
/// int64_t
pub const FOVOLNET_I64: FovolnetDtype = 8;
/// Half precision of IEEE 754
pub const FOVOLNET_F16: FovolnetDtype = 9;
/// float
pub const FOVOLNET_F32: FovolnetDtype = 10;
/// double
pub const FOVOLNET_F64: FovolnetDtype = 11;

/// Meaning of voxels.
pub type FovolnetMeaning = i32;
/// Values, of which the first component is shown.
pub const FOVOLNET_VALUES: FovolnetMeaning = 0;
/// Three or four components: red, green, blue, and opacity. Without a fourth, luminance is the opacity.
pub const FOVOLNET_COLOURS: FovolnetMeaning = 1;
/// Labels, between which nothing is interpolated.
pub const FOVOLNET_LABELS: FovolnetMeaning = 2;

/// Space in which a grid is placed.
pub type FovolnetSpace = i32;
/// None: the grid stands along x, y and z of the world.
pub const FOVOLNET_SPACE_NONE: FovolnetSpace = 0;
/// Patient space. Pictures show the patient upright, as "orientation" says.
pub const FOVOLNET_SPACE_PATIENT: FovolnetSpace = 1;
/// Other space, which aligns volumes with each other.
pub const FOVOLNET_SPACE_OTHER: FovolnetSpace = 2;

/// Called once with `user` when the voxels are not needed any more, on the thread that gives the last use of them up. It must not
/// call functions of this library.
pub type FovolnetRelease = Option<unsafe extern "C" fn(user: *mut c_void)>;

/// Voxels in the memory of the caller. Fill the struct with zeros, then set `size`, `data`, `bytes`, `dims`, `spacing` and `dtype`;
/// everything else may stay zero.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FovolnetVoxels {
    /// sizeof(FovolnetVoxels).
    pub size: usize,
    /// The first component of the first voxel. Components of a voxel lie side by side; x is fastest, then y, then z, without gaps.
    /// The byte order is that of the processor; any alignment will do. Nobody may write there until `release` is called.
    pub data: *const c_void,
    /// Number of bytes at `data`: at least the product of dims, components and the size of the type.
    pub bytes: usize,
    /// Number of voxels along x, y, z.
    pub dims: [u64; 3],
    /// Distance of voxels along x, y, z, above 0. Pictures depend on their ratios only.
    pub spacing: [f64; 3],
    /// Type of each component.
    pub dtype: FovolnetDtype,
    /// Number of components of each voxel; 0 means 1.
    pub components: u32,
    /// Meaning of the components.
    pub meaning: FovolnetMeaning,
    /// Whether and where the grid is placed by `directions` and `origin`.
    pub space: FovolnetSpace,
    /// Directions of the x, y and z axis of the grid, three numbers each, in LPS: left, posterior, superior. Any length will do.
    pub directions: [f64; 9],
    /// Centre of the first voxel in LPS, in the unit of `spacing`.
    pub origin: [f64; 3],
    /// Name for notes and errors; NULL is "the volume". It is copied.
    pub name: *const c_char,
    /// Called when the voxels are not needed any more; may be NULL. Without it, keep them until every volume and renderer that was
    /// given them is released.
    pub release: FovolnetRelease,
    /// Argument of `release`.
    pub user: *mut c_void,
}

// SAFETY: it is `repr(C)` and begins with its size; zeros are null pointers, numbers and no function.
unsafe impl Growing for FovolnetVoxels {
    const NAME: &'static str = "FovolnetVoxels";
    const FIRST: usize = size_of::<Self>();
}

/// Bytes of the caller.
struct Lent {
    start: *const u8,
    length: usize,
    release: FovolnetRelease,
    user: *mut c_void,
}

// SAFETY: the caller promises that nobody writes the bytes, and that `release` may be called on any thread.
unsafe impl Send for Lent {}
// SAFETY: likewise; the bytes are only read.
unsafe impl Sync for Lent {}

impl AsRef<[u8]> for Lent {
    fn as_ref(&self) -> &[u8] {
        // SAFETY: the caller promises that these bytes stay until `release` is called.
        unsafe { std::slice::from_raw_parts(self.start, self.length) }
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: the caller gave the function for this argument.
            unsafe { release(self.user) };
        }
    }
}

/// Byte order of this processor.
const NATIVE: Endian = if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little };

/// Volume of the caller's voxels, before settings are applied.
///
/// # Safety
/// The pointers in `voxels` are as its documentation says.
pub(crate) unsafe fn lend(voxels: &FovolnetVoxels) -> Result<OpenVolume, Failure> {
    let dtype = dtype_of(voxels.dtype)?;
    let dims = voxels.dims.map(|dim| usize::try_from(dim).unwrap_or(usize::MAX));
    let grid = Grid::new(dims, voxels.spacing)?;
    // SAFETY: the caller promises it.
    let bytes = unsafe { slice(voxels.data.cast::<u8>(), voxels.bytes, "voxels->data")? };
    let name = match voxels.name.is_null() {
        true => "the volume",
        // SAFETY: the caller promises it.
        false => unsafe { text(voxels.name, "voxels->name")? },
    };
    let components = voxels.components.max(1) as usize;
    let contents = contents(voxels.meaning, components)?;
    let placement = placement(voxels)?;
    // A volume that fails must not release the voxels: an error leaves them to the caller.
    let lent = Lent { start: bytes.as_ptr(), length: bytes.len(), release: None, user: voxels.user };
    Volume::with_layout(grid, dtype, NATIVE, components, Arc::new(lent), 0)?;
    let lent =
        Lent { start: bytes.as_ptr(), length: bytes.len(), release: voxels.release, user: voxels.user };
    let volume = Volume::with_layout(grid, dtype, NATIVE, components, Arc::new(lent), 0)?;
    let volume = volume.with_contents(contents);
    let volume = match placement {
        Some(placement) => volume.with_placement(placement),
        None => volume,
    };
    Ok(OpenVolume::of(Arc::new(volume), name))
}

fn dtype_of(number: FovolnetDtype) -> Result<Dtype, Failure> {
    let known = DTYPES.iter().find(|(of, _)| *of == number);
    known.map(|(_, dtype)| *dtype).ok_or_else(|| {
        Failure::invalid(format!("`voxels->dtype` is {number}; use FOVOLNET_U8 to FOVOLNET_F64, 1 to 11"))
    })
}

/// Number of `dtype` in the header.
pub(crate) fn number_of(dtype: Dtype) -> FovolnetDtype {
    DTYPES.iter().find(|(_, of)| *of == dtype).map_or(0, |(number, _)| *number)
}

const DTYPES: [(FovolnetDtype, Dtype); 11] = [
    (FOVOLNET_U8, Dtype::U8),
    (FOVOLNET_I8, Dtype::I8),
    (FOVOLNET_U16, Dtype::U16),
    (FOVOLNET_I16, Dtype::I16),
    (FOVOLNET_U32, Dtype::U32),
    (FOVOLNET_I32, Dtype::I32),
    (FOVOLNET_U64, Dtype::U64),
    (FOVOLNET_I64, Dtype::I64),
    (FOVOLNET_F16, Dtype::F16),
    (FOVOLNET_F32, Dtype::F32),
    (FOVOLNET_F64, Dtype::F64),
];

fn contents(meaning: FovolnetMeaning, components: usize) -> Result<Contents, Failure> {
    if meaning == FOVOLNET_COLOURS && !matches!(components, 3 | 4) {
        return Err(Failure::invalid(format!(
            "the voxels have {components} components, and colours have 3 or 4; set `voxels->meaning` to FOVOLNET_VALUES"
        )));
    }
    if !(FOVOLNET_VALUES..=FOVOLNET_LABELS).contains(&meaning) {
        return Err(Failure::invalid(format!(
            "`voxels->meaning` is {meaning}; use FOVOLNET_VALUES, FOVOLNET_COLOURS or FOVOLNET_LABELS"
        )));
    }
    let (are_colours, are_labels) = (meaning == FOVOLNET_COLOURS, meaning == FOVOLNET_LABELS);
    Ok(Contents { components, are_colours, are_labels, ..Contents::default() })
}

fn placement(voxels: &FovolnetVoxels) -> Result<Option<Placement>, Failure> {
    let space = match voxels.space {
        FOVOLNET_SPACE_NONE => return Ok(None),
        FOVOLNET_SPACE_PATIENT => Space::Patient,
        FOVOLNET_SPACE_OTHER => Space::Other,
        other => {
            return Err(Failure::invalid(format!(
                "`voxels->space` is {other}; use FOVOLNET_SPACE_NONE, FOVOLNET_SPACE_PATIENT or FOVOLNET_SPACE_OTHER"
            )));
        }
    };
    let axes = DMat3::from_cols_array(&voxels.directions);
    Ok(Some(Placement::new(axes, DVec3::from_array(voxels.origin), space)?))
}
