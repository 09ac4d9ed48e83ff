use crate::boundary::{call, long_call};
use crate::committed::Committed;
use crate::flags;
use crate::handles::{hand_out, object, release};
use crate::opened::{Overlaid, Source, VolumeParameters};
use crate::pointers::{Growing, path_text, put_text, read, text, write};
use crate::status::{Failure, FovolnetStatus};
use crate::transfer_function::FovolnetTransferFunction;
use crate::voxels::{FovolnetDtype, FovolnetVoxels, lend, number_of};
use fovolnet::OpenVolume;
use std::ffi::c_char;
use std::sync::Arc;

/// A volume: voxels from a file, from the memory of the caller, or made by the library, and volumes laid over them.
pub struct FovolnetVolume(Committed<VolumeParameters, Arc<OpenVolume>>);

impl FovolnetVolume {
    /// Volume of the last commit.
    pub(crate) fn opened(&self) -> Result<Arc<OpenVolume>, Failure> {
        self.0.committed("volume")
    }
}

/// The function that makes volumes.
const MAKER: &str = "fovolnet_volume_new";

/// Facts about a committed volume.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FovolnetVolumeInfo {
    /// sizeof(FovolnetVolumeInfo), set by the caller.
    pub size: usize,
    /// Number of voxels along x, y, z.
    pub dims: [u64; 3],
    /// Distance of voxels along x, y, z.
    pub spacing: [f64; 3],
    /// Values shown as 0 and 1 of a transfer function.
    pub range: [f64; 2],
    /// Smallest and largest finite value.
    pub extremes: [f64; 2],
    /// Type of the voxels.
    pub dtype: FovolnetDtype,
    /// Number of components of each voxel.
    pub components: u32,
    /// Number of volumes and channels that are shown together, this one included.
    pub layers: u32,
    /// Whether the position in space is known: 0 or 1.
    pub is_placed: u32,
}

// SAFETY: it is `repr(C)` and begins with its size; all fields are numbers.
unsafe impl Growing for FovolnetVolumeInfo {
    const NAME: &'static str = "FovolnetVolumeInfo";
    const FIRST: usize = size_of::<Self>();
}

/// Makes a volume without voxels. Give the handle to fovolnet_volume_release in the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_new(volume: *mut *mut FovolnetVolume) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    call(|| unsafe { hand_out(FovolnetVolume(Committed::default()), volume, "volume") })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again. Renderers that show the volume keep what
/// they need.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_release(volume: *mut FovolnetVolume) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(volume) }
}

/// Sets where the voxels come from: a file, a folder of slices, an address of Zarr on the web, or the name of a procedural volume
/// such as "head". Paths may hold any bytes. The next commit opens it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_set_source(
    volume: *mut FovolnetVolume,
    source: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let source = unsafe { path_text(source, "source")? };
        // SAFETY: likewise.
        unsafe { object(volume, "volume", MAKER)? }.0.set(|pending| {
            pending.source = Source::Named(source);
            Ok(())
        })
    })
}

/// Sets voxels in the memory of the caller, which are not copied. The struct itself may go away after the call. After an error the
/// library does not know the voxels, and never calls `release`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_set_voxels(
    volume: *mut FovolnetVolume,
    voxels: *const FovolnetVoxels,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let volume = unsafe { object(volume, "volume", MAKER)? };
        // SAFETY: likewise.
        let lent = unsafe { lend(&read(voxels, "voxels")?)? };
        volume.0.set(|pending| {
            pending.source = Source::Lent(lent);
            Ok(())
        })
    })
}

/// Sets how the volume is read, by the name and the value of a flag of the command line: "dims", "dtype", "endian", "spacing",
/// "range", "window", "array", "component", "channel", "time", "level", "series", "overlay", "downsample". Voxels in memory take
/// spacing, range, window, component and downsample.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_set(
    volume: *mut FovolnetVolume,
    name: *const c_char,
    value: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let (name, value) = unsafe { (text(name, "name")?, text(value, "value")?) };
        // SAFETY: likewise.
        let volume = unsafe { object(volume, "volume", MAKER)? };
        volume.0.set(|pending| flags::set(&mut pending.settings, name, value))
    })
}

/// Sets all settings in a JSON object, such as {"dims": [64, 64, 32], "dtype": "u8"}. Null takes a setting back. An error changes
/// nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_set_json(
    volume: *mut FovolnetVolume,
    json: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let json = unsafe { text(json, "json")? };
        // SAFETY: likewise.
        let volume = unsafe { object(volume, "volume", MAKER)? };
        volume.0.set(|pending| flags::set_json(&mut pending.settings, json))
    })
}

/// Takes a setting back, so that its default holds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_unset(
    volume: *mut FovolnetVolume,
    name: *const c_char,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let name = unsafe { text(name, "name")? };
        // SAFETY: likewise.
        let volume = unsafe { object(volume, "volume", MAKER)? };
        volume.0.set(|pending| flags::unset(&mut pending.settings, name))
    })
}

/// Lays `overlay` over the box of `volume` at the next commit, up to three times. Positions align the two; without them the overlay
/// is stretched to the box. `transfer_function` may be NULL for colours of the library's choice. Both must be committed before
/// `volume` is, and a later commit of theirs is seen after another commit of `volume`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_add_overlay(
    volume: *mut FovolnetVolume,
    overlay: *const FovolnetVolume,
    transfer_function: *const FovolnetTransferFunction,
) -> FovolnetStatus {
    call(|| {
        if std::ptr::eq(volume, overlay) {
            return Err(Failure::invalid("a volume cannot lie over itself; make another one"));
        }
        // SAFETY: see the rules at the top of the header.
        let overlay = unsafe { Overlaid::of(overlay, transfer_function)? };
        // SAFETY: likewise.
        unsafe { object(volume, "volume", MAKER)? }.0.set(|pending| {
            pending.overlays.push(overlay);
            Ok(())
        })
    })
}

/// Takes all overlays of fovolnet_volume_add_overlay back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_clear_overlays(volume: *mut FovolnetVolume) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        unsafe { object(volume, "volume", MAKER)? }.0.set(|pending| {
            pending.overlays.clear();
            Ok(())
        })
    })
}

/// Opens the volume with its pending parameters. Renderers show it from their next frame on. After an error the volume of the last
/// commit stays. May take long; fovolnet_cancel ends it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_commit(volume: *mut FovolnetVolume) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let volume = unsafe { object(volume, "volume", MAKER)? };
        let opened = volume.0.pending().open()?;
        volume.0.commit(Arc::new(opened));
        Ok(())
    })
}

/// Writes facts about the committed volume to `info`, whose `size` the caller has set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_info(
    volume: *const FovolnetVolume,
    info: *mut FovolnetVolumeInfo,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let opened = unsafe { object(volume, "volume", MAKER)? }.opened()?;
        let (volume, grid) = (&opened.volume, opened.volume.grid());
        let statistics = volume.statistics();
        let facts = FovolnetVolumeInfo {
            size: 0,
            dims: grid.dims().map(|dim| dim as u64),
            spacing: grid.spacing(),
            range: volume.range(),
            extremes: [statistics.min, statistics.max],
            dtype: number_of(volume.dtype()),
            components: volume.components() as u32,
            layers: opened.layers.len() as u32 + 1,
            is_placed: volume.placement().is_some().into(),
        };
        // SAFETY: likewise.
        unsafe { write(info, &facts, "info") }
    })
}

/// Writes what was assumed while the committed volume was read, and why little of it may be visible: one line each. Texts: see the
/// top of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_volume_notes(
    volume: *const FovolnetVolume,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let opened = unsafe { object(volume, "volume", MAKER)? }.opened()?;
        let notes: Vec<String> = opened.notes().into_iter().chain(opened.remarks()).collect();
        // SAFETY: likewise.
        unsafe { put_text(&notes.join("\n"), text, capacity, length) }
    })
}
