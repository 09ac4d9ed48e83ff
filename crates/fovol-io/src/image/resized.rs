use fast_image_resize::images::{Image, ImageRef};
use fast_image_resize::{FilterType, PixelType, ResizeAlg, ResizeOptions, Resizer};
use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// Nothing can be wrong with the sizes and the alignment of frames.
const FITS: &str = "frames have as many pixels as their sizes say";
/// Rows that one task makes.
const ROWS: usize = 64;

/// `frame` at another size: cubic (Catmull and Rom), cut to 0…1.
///
/// # Panics
/// Never: frames have as many pixels as their sizes say.
#[must_use]
pub fn resized(frame: &Frame, size: FrameSize) -> Frame {
    let from = frame.size();
    if from == size {
        return frame.clone();
    }
    let bytes = bytemuck::cast_slice(frame.pixels());
    let picture = ImageRef::new(from.width, from.height, bytes, PixelType::F32x4).expect(FITS);
    let cubic = ResizeAlg::Convolution(FilterType::CatmullRom);
    let options = ResizeOptions::new().resize_alg(cubic).use_alpha(false);
    let row_height = f64::from(from.height) / f64::from(size.height);
    let mut resized = Frame::new(size);
    let width = size.width as usize;
    resized.pixels_mut().par_chunks_mut(ROWS * width).enumerate().for_each(|(band, pixels)| {
        let rows = pixels.len() / width;
        // A band is the enlarged part of the picture; the filter sees the rows around it.
        let (top, height) = ((band * ROWS) as f64 * row_height, rows as f64 * row_height);
        let options = options.crop(0.0, top, f64::from(from.width), height.min(f64::from(from.height) - top));
        let bytes = bytemuck::cast_slice_mut(&mut *pixels);
        let mut target = Image::from_slice_u8(size.width, rows as u32, bytes, PixelType::F32x4).expect(FITS);
        Resizer::new().resize(&picture, &mut target, &options).expect(FITS);
        pixels.iter_mut().flatten().for_each(|value| *value = value.clamp(0.0, 1.0));
    });
    resized
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_size_keeps_what_is_linear() {
        for ([width, height], [wide, high]) in [([16, 12], [32, 24]), ([40, 90], [100, 200])] {
            let size = FrameSize::new(width, height).unwrap();
            let at = |i: u32, sides: u32| i as f32 / sides as f32;
            let ramp = (0..width * height)
                .map(|i| [at(i % width, width), at(i / width, height), 0.25, 1.0])
                .collect();
            let larger =
                resized(&Frame::from_pixels(size, ramp).unwrap(), FrameSize::new(wide, high).unwrap());
            for y in high / 5..high * 4 / 5 {
                let x = wide / 3 + y % (wide / 3);
                // Centres of pixels are in the middle of them.
                let place = |at: u32, large: u32, small: u32| {
                    ((at as f32 + 0.5) * small as f32 / large as f32 - 0.5) / small as f32
                };
                let expected = [place(x, wide, width), place(y, high, height), 0.25, 1.0];
                let found = larger.pixel(x, y);
                assert!((0..4).all(|c| (found[c] - expected[c]).abs() < 1e-4), "{y}: {found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn values_stay_in_their_range_and_equal_sizes_change_nothing() {
        let size = FrameSize::new(7, 5).unwrap();
        let edges = (0..35).map(|i| [(i % 2) as f32, (i / 7 % 2) as f32, 1.0, 1.0]).collect();
        let frame = Frame::from_pixels(size, edges).unwrap();
        assert_eq!(resized(&frame, size), frame);
        for side in [[1, 1], [3, 11], [40, 2], [3, 200]] {
            let other = resized(&frame, side.try_into().unwrap());
            assert!(other.pixels().iter().flatten().all(|value| (0.0..=1.0).contains(value)));
            assert!(other.pixels().iter().all(|pixel| pixel[3] > 0.999));
        }
    }
}
