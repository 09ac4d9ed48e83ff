use crate::status::{FOVOLNET_ABSENT, Failure};
use fovolnet::RenderedFrame;
use fovolnet::core::{Pixel, SparseFrame};
use std::borrow::Cow;

/// Part of a frame that can be read.
pub type FovolnetChannel = i32;
/// The picture: 4 uint8_t a pixel. Display colours (sRGB) and opacity, not premultiplied; opacity is 255 unless the flag
/// "transparent" is set, or pixels stay empty for lack of a reconstruction.
pub const FOVOLNET_RGBA8: FovolnetChannel = 1;
/// The picture: 3 uint8_t a pixel. Display colours (sRGB).
pub const FOVOLNET_RGB8: FovolnetChannel = 2;
/// The picture: 4 float a pixel. Display colours (sRGB), 0 to 1, and opacity, not premultiplied.
pub const FOVOLNET_RGBA32F: FovolnetChannel = 3;
/// Colours of the marched pixels: 4 float a pixel. The last is 1 where a pixel was marched; all are 0 elsewhere.
pub const FOVOLNET_SPARSE_RGBA32F: FovolnetChannel = 4;
/// Which pixels were marched: 1 uint8_t a pixel, 1 or 0.
pub const FOVOLNET_MASK8: FovolnetChannel = 5;
/// Distances of marched pixels from the eye in world units: 1 float a pixel. Infinite where nothing shows and where no pixel was
/// marched. Frames of sampling "full" have none; sampling "compact" with pb 1 and reconstruct "none" marches every pixel and has it.
pub const FOVOLNET_DEPTH32F: FovolnetChannel = 6;
/// Way of each pixel to its place in the last frame in pixels, right and down: 2 float a pixel. The first frame has none. Later ones
/// have it if a network uses it, or after fovolnet_renderer_find_motion.
pub const FOVOLNET_MOTION32F: FovolnetChannel = 7;
/// List of marched pixels in raster order: 2 uint16_t each, column and row. Frames of sampling "full" have no lists.
pub const FOVOLNET_SAMPLE_PIXELS16: FovolnetChannel = 8;
/// Colours of the listed pixels: 3 float each.
pub const FOVOLNET_SAMPLE_RGB32F: FovolnetChannel = 9;
/// Distances of the listed pixels from the eye: 1 float each.
pub const FOVOLNET_SAMPLE_DEPTH32F: FovolnetChannel = 10;

/// Bytes of a channel.
pub(crate) struct Channel<'a> {
    pub bytes: Cow<'a, [u8]>,
    /// Bytes of a row; `None` for lists, which have no rows.
    pub row: Option<usize>,
}

impl<'a> Channel<'a> {
    /// Channel `number` of `frame`.
    pub fn of(frame: &'a RenderedFrame, number: FovolnetChannel) -> Result<Self, Failure> {
        let width = frame.frame.size().width as usize;
        let (bytes, pixel) = match number {
            FOVOLNET_RGBA8 => (Cow::Owned(frame.frame.to_rgba8()), 4),
            FOVOLNET_RGB8 => (Cow::Owned(frame.frame.to_rgb8()), 3),
            FOVOLNET_RGBA32F => (borrowed(frame.frame.pixels()), 16),
            FOVOLNET_SPARSE_RGBA32F => (owned(frame.samples_picture().pixels()), 16),
            FOVOLNET_MASK8 => (Cow::Owned(mask(frame)), 1),
            FOVOLNET_DEPTH32F => (owned(&depths(sparse(frame)?)), 4),
            FOVOLNET_MOTION32F => (borrowed(motion(frame)?), 8),
            list => return Ok(Self { bytes: listed(sparse(frame), list)?, row: None }),
        };
        // Planned frames may be smaller before they are enlarged; so are their samples.
        let width = if matches!(number, FOVOLNET_RGBA8 | FOVOLNET_RGB8 | FOVOLNET_RGBA32F) {
            width
        } else {
            frame.mask.size().width as usize
        };
        Ok(Self { bytes, row: Some(width * pixel) })
    }
}

/// List `number` of the samples.
fn listed(sparse: Result<&SparseFrame, Failure>, number: FovolnetChannel) -> Result<Cow<'_, [u8]>, Failure> {
    match number {
        FOVOLNET_SAMPLE_PIXELS16 => {
            let places = sparse?.pixels().iter().map(|Pixel { x, y }| [*x, *y]);
            Ok(owned(&places.collect::<Vec<_>>()))
        }
        FOVOLNET_SAMPLE_RGB32F => Ok(borrowed(sparse?.colours())),
        FOVOLNET_SAMPLE_DEPTH32F => Ok(borrowed(sparse?.depths())),
        other => Err(Failure::invalid(format!(
            "there is no channel {other}; use FOVOLNET_RGBA8 to FOVOLNET_SAMPLE_DEPTH32F, 1 to 10"
        ))),
    }
}

fn borrowed<T: bytemuck::NoUninit>(values: &[T]) -> Cow<'_, [u8]> {
    Cow::Borrowed(bytemuck::cast_slice(values))
}

fn owned<T: bytemuck::NoUninit>(values: &[T]) -> Cow<'static, [u8]> {
    Cow::Owned(bytemuck::cast_slice(values).to_vec())
}

fn mask(frame: &RenderedFrame) -> Vec<u8> {
    let (mask, size) = (&frame.mask, frame.mask.size());
    (0..size.height).flat_map(|y| (0..size.width).map(move |x| mask.contains(x, y).into())).collect()
}

fn depths(sparse: &SparseFrame) -> Vec<f32> {
    let size = sparse.size();
    let mut depths = vec![f32::INFINITY; size.pixels()];
    for (pixel, depth) in sparse.pixels().iter().zip(sparse.depths()) {
        depths[pixel.index(size.width)] = *depth;
    }
    depths
}

fn sparse(frame: &RenderedFrame) -> Result<&SparseFrame, Failure> {
    frame.sparse.as_ref().ok_or_else(|| {
        absent(
            "every pixel was marched without a list, so there are no depths and lists; set sampling to compact, pb to 1 and \
             reconstruct to none for depths of all pixels",
        )
    })
}

fn motion(frame: &RenderedFrame) -> Result<&[[f32; 2]], Failure> {
    frame.motion.as_deref().ok_or_else(|| {
        absent(
            "the frame has no motion: it is the first one, or nothing asked for it; call fovolnet_renderer_find_motion before \
             two sparse frames",
        )
    })
}

fn absent(text: &str) -> Failure {
    Failure { status: FOVOLNET_ABSENT, text: text.into() }
}
