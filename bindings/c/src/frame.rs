use crate::boundary::call;
use crate::channels::{Channel, FovolnetChannel};
use crate::handles::{object, release};
use crate::pointers::{Growing, put, write};
use crate::status::{Failure, FovolnetStatus};
use fovolnet::RenderedFrame;
use std::ffi::c_void;

/// A rendered frame, which never changes.
pub struct FovolnetFrame(pub(crate) RenderedFrame);

/// The function that makes frames.
const MAKER: &str = "fovolnet_renderer_render";

/// Facts about a frame. Times are in milliseconds; 0 for stages that did not run or were not timed apart.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FovolnetFrameInfo {
    /// sizeof(FovolnetFrameInfo), set by the caller.
    pub size: usize,
    /// Number of the frame.
    pub index: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Width before the frame was enlarged, which the planner of the flags "quality" and "budget" may do. Mask, samples, depth and
    /// motion have this size; else it is the width.
    pub marched_width: u32,
    /// Height before the frame was enlarged.
    pub marched_height: u32,
    /// Always 0.
    pub reserved: u32,
    /// Number of marched pixels, repeated ones included.
    pub samples: u64,
    /// Number of pixels that were marched without shadow rays besides.
    pub guide_samples: u64,
    /// Time of choosing pixels, without `compact`.
    pub mask_ms: f64,
    /// Time of listing them.
    pub compact_ms: f64,
    /// Time of marching, without `scatter`.
    pub march_ms: f64,
    /// Time of the way from rays to the sparse frame.
    pub scatter_ms: f64,
    /// Time of the pixels without shadow rays.
    pub guide_ms: f64,
    /// Time of finding motion.
    pub motion_ms: f64,
    /// Time of the reconstruction.
    pub fill_ms: f64,
    /// Time of the planner.
    pub plan_ms: f64,
    /// Time of the whole frame.
    pub total_ms: f64,
}

// SAFETY: it is `repr(C)` and begins with its size; all fields are numbers.
unsafe impl Growing for FovolnetFrameInfo {
    const NAME: &'static str = "FovolnetFrameInfo";
    const FIRST: usize = size_of::<Self>();
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_frame_release(frame: *mut FovolnetFrame) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(frame) }
}

/// Writes facts about the frame to `info`, whose `size` the caller has set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_frame_info(
    frame: *const FovolnetFrame,
    info: *mut FovolnetFrameInfo,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let rendered = &unsafe { object(frame, "frame", MAKER)? }.0;
        // SAFETY: likewise.
        unsafe { write(info, &facts(rendered), "info") }
    })
}

fn facts(rendered: &RenderedFrame) -> FovolnetFrameInfo {
    let (size, marched, timings) = (rendered.frame.size(), rendered.mask.size(), &rendered.timings);
    let [mask_ms, compact_ms, march_ms, scatter_ms, guide_ms, motion_ms, fill_ms] =
        timings.finer().map(|(_, ms)| ms);
    FovolnetFrameInfo {
        size: 0,
        index: rendered.index,
        width: size.width,
        height: size.height,
        marched_width: marched.width,
        marched_height: marched.height,
        reserved: 0,
        samples: rendered.samples as u64,
        guide_samples: rendered.guide_samples as u64,
        mask_ms,
        compact_ms,
        march_ms,
        scatter_ms,
        guide_ms,
        motion_ms,
        fill_ms,
        plan_ms: timings.plan,
        total_ms: timings.total,
    }
}

/// Writes the number of bytes of a channel to `bytes`. FOVOLNET_ABSENT if the frame does not have it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_frame_bytes(
    frame: *const FovolnetFrame,
    channel: FovolnetChannel,
    bytes: *mut usize,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let rendered = &unsafe { object(frame, "frame", MAKER)? }.0;
        let length = Channel::of(rendered, channel)?.bytes.len();
        // SAFETY: likewise.
        unsafe { put(bytes, length, "bytes") }
    })
}

/// Copies a channel to `buffer`, which has `bytes` bytes. Rows come from top to bottom, `pitch` bytes from one to the next; 0 for
/// rows without gaps. A negative pitch puts the bottom row first, as OpenGL and ANARI have it. Lists have no rows: their pitch is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_frame_read(
    frame: *const FovolnetFrame,
    channel: FovolnetChannel,
    buffer: *mut c_void,
    bytes: usize,
    pitch: isize,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let channel = Channel::of(&unsafe { object(frame, "frame", MAKER)? }.0, channel)?;
        if channel.bytes.is_empty() {
            return Ok(());
        }
        let rows = Rows::of(&channel, pitch)?;
        if buffer.is_null() || bytes < rows.needed() {
            return Err(Failure::invalid(format!(
                "the buffer is NULL or too small: it has {bytes} bytes, and the channel needs {}",
                rows.needed()
            )));
        }
        for (number, row) in channel.bytes.chunks_exact(rows.length).enumerate() {
            // SAFETY: row `number` begins and ends within the bytes that are needed, which the buffer has.
            unsafe {
                let to = buffer.cast::<u8>().add(rows.start(number));
                row.as_ptr().copy_to_nonoverlapping(to, rows.length);
            }
        }
        Ok(())
    })
}

/// Rows of a channel in a buffer.
struct Rows {
    length: usize,
    count: usize,
    pitch: usize,
    is_upside_down: bool,
}

impl Rows {
    fn of(channel: &Channel<'_>, pitch: isize) -> Result<Self, Failure> {
        let all = channel.bytes.len();
        let length = channel.row.unwrap_or(all);
        let (size, count) = (pitch.unsigned_abs(), all / length);
        if pitch != 0 && (channel.row.is_none() || size < length) {
            return Err(Failure::invalid(format!(
                "`pitch` is {pitch}, and rows have {length} bytes; give 0, or at least so many for a channel with rows"
            )));
        }
        let pitch_of_rows = if pitch == 0 { length } else { size };
        if pitch_of_rows.checked_mul(count).is_none() {
            return Err(Failure::invalid(format!("`pitch` is {pitch}, too large for {count} rows; give 0")));
        }
        Ok(Self { length, count, pitch: pitch_of_rows, is_upside_down: pitch < 0 })
    }

    /// Bytes from the first one of a buffer to the last that is written.
    fn needed(&self) -> usize {
        (self.count - 1) * self.pitch + self.length
    }

    /// First byte of row `number` from the top.
    fn start(&self, number: usize) -> usize {
        self.pitch * if self.is_upside_down { self.count - 1 - number } else { number }
    }
}
