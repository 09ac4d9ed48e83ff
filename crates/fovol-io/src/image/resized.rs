use fast_image_resize::images::{TypedImage, TypedImageRef};
use fast_image_resize::pixels::F32x4;
use fast_image_resize::{FilterType, ResizeAlg, ResizeOptions, Resizer};
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
    // One side after the other: within a band, the library forgets rows that two passes need around it.
    let mut wide = Frame::new(FrameSize { width: size.width, height: from.height });
    let rows = frame.pixels().par_chunks(ROWS * from.width as usize);
    rows.zip(wide.pixels_mut().par_chunks_mut(ROWS * size.width as usize)).for_each(|(from_rows, rows)| {
        let height = (rows.len() / size.width as usize) as f64;
        let whole = [0.0, 0.0, f64::from(from.width), height];
        resize((from_rows, from.width), (rows, size.width), whole);
    });
    let mut resized = Frame::new(size);
    let row_height = f64::from(from.height) / f64::from(size.height);
    let bands = resized.pixels_mut().par_chunks_mut(ROWS * size.width as usize);
    bands.enumerate().for_each(|(band, rows)| {
        let top = (band * ROWS) as f64 * row_height;
        let height = (rows.len() / size.width as usize) as f64 * row_height;
        let part = [0.0, top, f64::from(size.width), height.min(f64::from(from.height) - top)];
        resize((wide.pixels(), size.width), (rows, size.width), part);
        rows.iter_mut().flatten().for_each(|value| *value = value.clamp(0.0, 1.0));
    });
    resized
}

/// Resizes the part `[left, top, width, height]` of the pixels `from` to the pixels `to`; both with their row's length.
///
/// The type of the pixels is stated, so that the library is not compiled for every other type too.
fn resize(from: (&[[f32; 4]], u32), to: (&mut [[f32; 4]], u32), [left, top, width, height]: [f64; 4]) {
    let rows = |pixels: usize, width: u32| (pixels / width as usize) as u32;
    let (pixels, columns) = from;
    let rows_from = rows(pixels.len(), columns);
    let picture = TypedImageRef::<F32x4>::from_buffer(columns, rows_from, bytemuck::cast_slice(pixels));
    let (pixels, columns) = to;
    let rows_to = rows(pixels.len(), columns);
    let target = TypedImage::<F32x4>::from_buffer(columns, rows_to, bytemuck::cast_slice_mut(pixels));
    let cubic = ResizeAlg::Convolution(FilterType::CatmullRom);
    let options = ResizeOptions::new().resize_alg(cubic).use_alpha(false).crop(left, top, width, height);
    let (picture, mut target) = (picture.expect(FITS), target.expect(FITS));
    Resizer::new().resize_typed(&picture, &mut target, &options).expect(FITS);
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

    /// Specification of [`resized`], pixel by pixel.
    fn plain(frame: &Frame, size: FrameSize) -> Frame {
        let weight = |d: f64| match d {
            d if d < 1.0 => 1.0 + d * d * (1.5 * d - 2.5),
            d if d < 2.0 => 2.0 + d * (-4.0 + d * (2.5 - 0.5 * d)),
            _ => 0.0,
        };
        let along = |at: u32, large: u32, small: u32| -> Vec<(u32, f64)> {
            let place = (f64::from(at) + 0.5) * f64::from(small) / f64::from(large) - 0.5;
            let taps = (0..small).map(|tap| (tap, weight((f64::from(tap) - place).abs())));
            let taps: Vec<(u32, f64)> = taps.filter(|(_, weight)| *weight != 0.0).collect();
            let sum: f64 = taps.iter().map(|(_, weight)| weight).sum();
            taps.into_iter().map(|(tap, weight)| (tap, weight / sum)).collect()
        };
        let from = frame.size();
        let pixels = (0..size.pixels() as u32).map(|i| {
            let columns = along(i % size.width, size.width, from.width);
            let rows = along(i / size.width, size.height, from.height);
            let mut sum = [0.0; 4];
            for (y, row) in &rows {
                for (x, column) in &columns {
                    (0..4).for_each(|c| sum[c] += row * column * f64::from(frame.pixel(*x, *y)[c]));
                }
            }
            sum.map(|value| (value as f32).clamp(0.0, 1.0))
        });
        Frame::from_pixels(size, pixels.collect()).unwrap()
    }

    #[test]
    fn bands_fit_together() {
        for ([width, height], [wide, high]) in
            [([60, 81], [100, 135]), ([43, 80], [128, 240]), ([9, 70], [10, 200])]
        {
            let size = FrameSize::new(width, height).unwrap();
            let value = |i: u32| ((i * 7919) % 101) as f32 / 100.0;
            let noise = (0..width * height).map(|i| [value(i), value(i + 5), 0.5, 1.0]).collect();
            let frame = Frame::from_pixels(size, noise).unwrap();
            let large = FrameSize::new(wide, high).unwrap();
            let (found, expected) = (resized(&frame, large), plain(&frame, large));
            for y in 0..high {
                for x in 0..wide {
                    let pair = [found.pixel(x, y), expected.pixel(x, y)];
                    assert!(
                        (0..4).all(|c| (pair[0][c] - pair[1][c]).abs() < 1e-4),
                        "{size} {x} {y}: {pair:?}"
                    );
                }
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
