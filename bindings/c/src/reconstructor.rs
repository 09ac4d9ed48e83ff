use crate::boundary::{call, long_call, repaired};
use crate::handles::{hand_out, object, release};
use crate::pointers::{Growing, put, read, slice, text};
use crate::render_flags::RenderFlags;
use crate::status::{Failure, FovolnetStatus};
use fovolnet::Reconstructor;
use fovolnet::core::{FrameSize, Pixel, SampleList, SparseFrame};
use std::ffi::c_char;
use std::sync::{Mutex, PoisonError};

/// Reconstructs the sparse frames of one clip, of any renderer, on the CPU. Networks remember earlier frames.
pub struct FovolnetReconstructor {
    inner: Mutex<Reconstructor>,
    size: FrameSize,
}

/// The function that makes reconstructors.
const MAKER: &str = "fovolnet_reconstructor_new";

/// A sparse frame in the memory of the caller. Fill the struct with zeros first. Pictures have no gaps, rows from top to bottom.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FovolnetSparseFrame {
    /// sizeof(FovolnetSparseFrame).
    pub size: usize,
    /// Width in pixels, that of the reconstructor.
    pub width: u32,
    /// Height in pixels, that of the reconstructor.
    pub height: u32,
    /// Display colours (sRGB), 0 to 1, of all pixels; those that are not sampled do not count.
    pub colours: *const f32,
    /// Number of float a pixel in `colours`: 3, or 4 of which the last does not count. 0 means 3.
    pub components: u32,
    /// Always 0.
    pub reserved: u32,
    /// Which pixels are sampled: one byte a pixel, 0 if not.
    pub mask: *const u8,
    /// Way of each pixel to its place in the last frame in pixels, right and down: 2 float a pixel. NULL for a scene that stands
    /// still.
    pub motion: *const f32,
}

// SAFETY: it is `repr(C)` and begins with its size; zeros are null pointers and numbers.
unsafe impl Growing for FovolnetSparseFrame {
    const NAME: &'static str = "FovolnetSparseFrame";
    const FIRST: usize = size_of::<Self>();
}

/// Makes a reconstructor of frames of `width` by `height` pixels. `json` is NULL, or an object with the flags "reconstruct", "weights",
/// "random-weights" and "precision"; by default it is the network wnet-fast. Give the handle to fovolnet_reconstructor_release in
/// the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_reconstructor_new(
    width: u32,
    height: u32,
    json: *const c_char,
    reconstructor: *mut *mut FovolnetReconstructor,
) -> FovolnetStatus {
    long_call(|| {
        let size = FrameSize::new(width, height)?;
        let mut flags = RenderFlags::default();
        if !json.is_null() {
            // SAFETY: see the rules at the top of the header.
            flags.set_json(unsafe { text(json, "json")? })?;
        }
        flags.pictures.check_flags()?;
        let inner = Mutex::new(Reconstructor::new(&flags.pictures.resolve()?, size)?);
        // SAFETY: likewise.
        unsafe { hand_out(FovolnetReconstructor { inner, size }, reconstructor, "reconstructor") }
    })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_reconstructor_release(reconstructor: *mut FovolnetReconstructor) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(reconstructor) }
}

/// Reconstructs the next frame of the clip and writes it to `picture`: 4 float a pixel, display colours 0 to 1 and opacity 1.
/// `bytes` is the size of `picture`. fovolnet_cancel ends it; earlier frames are forgotten then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_reconstructor_reconstruct(
    reconstructor: *mut FovolnetReconstructor,
    sparse: *const FovolnetSparseFrame,
    picture: *mut f32,
    bytes: usize,
) -> FovolnetStatus {
    long_call(|| {
        // SAFETY: see the rules at the top of the header.
        let FovolnetReconstructor { inner, size } = unsafe { object(reconstructor, "reconstructor", MAKER)? };
        let needed = size.pixels() * size_of::<[f32; 4]>();
        if picture.is_null() || bytes < needed {
            return Err(Failure::invalid(format!(
                "`picture` is NULL or too small: it has {bytes} bytes, and a frame of {size} needs {needed}"
            )));
        }
        // SAFETY: likewise.
        let given = unsafe { read(sparse, "sparse")? };
        // SAFETY: likewise.
        let (samples, motion) = unsafe { (samples(&given, *size)?, motion(&given, *size)?) };
        let mut inner = inner.lock().unwrap_or_else(PoisonError::into_inner);
        let work = |inner: &mut Reconstructor| Ok(inner.reconstruct(&samples, motion)?);
        let frame = repaired(&mut *inner, work, |inner| *inner = inner.another(*size))?;
        let numbers: &[u8] = bytemuck::cast_slice(frame.pixels());
        // SAFETY: `picture` has room for them.
        unsafe { numbers.as_ptr().copy_to_nonoverlapping(picture.cast(), numbers.len()) };
        Ok(())
    })
}

/// Forgets earlier frames, as after a cut.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_reconstructor_reset(
    reconstructor: *mut FovolnetReconstructor,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let reconstructor = unsafe { object(reconstructor, "reconstructor", MAKER)? };
        reconstructor.inner.lock().unwrap_or_else(PoisonError::into_inner).reset();
        Ok(())
    })
}

/// Writes whether the reconstructor uses motion, 0 or 1, to `uses_motion`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_reconstructor_uses_motion(
    reconstructor: *const FovolnetReconstructor,
    uses_motion: *mut u32,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let reconstructor = unsafe { object(reconstructor, "reconstructor", MAKER)? };
        let uses = reconstructor.inner.lock().unwrap_or_else(PoisonError::into_inner).uses_motion();
        // SAFETY: likewise.
        unsafe { put(uses_motion, uses.into(), "uses_motion") }
    })
}

/// Samples of `given`, a frame of `size`.
///
/// # Safety
/// The pointers in `given` are as its documentation says.
unsafe fn samples(given: &FovolnetSparseFrame, size: FrameSize) -> Result<SparseFrame, Failure> {
    if (given.width, given.height) != (size.width, size.height) {
        return Err(Failure::invalid(format!(
            "the sparse frame has {}x{} pixels, the reconstructor {size}; make another reconstructor for another size",
            given.width, given.height
        )));
    }
    let components = match given.components {
        0 => 3,
        components @ (3 | 4) => components as usize,
        other => {
            return Err(Failure::invalid(format!("`sparse->components` is {other}; use 3 or 4")));
        }
    };
    // SAFETY: the caller promises it.
    let colours = unsafe { slice(given.colours, size.pixels() * components, "sparse->colours")? };
    // SAFETY: likewise.
    let mask = unsafe { slice(given.mask, size.pixels(), "sparse->mask")? };
    let width = size.width as usize;
    let (mut pixels, mut values) = (Vec::new(), Vec::new());
    for (at, colour) in colours.chunks_exact(components).enumerate().filter(|(at, _)| mask[*at] != 0) {
        pixels.push(Pixel { x: (at % width) as u16, y: (at / width) as u16 });
        values.push([colour[0], colour[1], colour[2]]);
    }
    let depths = vec![f32::INFINITY; pixels.len()];
    Ok(SparseFrame::new(SampleList::new(size, pixels), values, depths))
}

/// Motion of `given`, a frame of `size`.
///
/// # Safety
/// The pointers in `given` are as its documentation says.
unsafe fn motion(given: &FovolnetSparseFrame, size: FrameSize) -> Result<Option<&[[f32; 2]]>, Failure> {
    if given.motion.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller promises it.
    unsafe { slice(given.motion.cast(), size.pixels(), "sparse->motion") }.map(Some)
}
