use crate::cpu::history::motion::{corner_of, whole_motion};
use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::element::Element;
use fovol_simd::{Simd, SimdF32, SimdF32Op};
use glam::Vec4;
use rayon::prelude::*;

/// Moves `input` along `motion`, in pixels of level 0 to the previous position: bilinear, zero outside. Motion is
/// averaged and scaled to the resolution of `input`.
pub fn warp<T: Element>(input: &Tensor<T>, motion: &Tensor, out: &mut Tensor<T>) {
    let factor = motion.height / input.height;
    let c = input.channels;
    out.resize([input.height, input.width, c]);
    out.data.par_chunks_mut(input.width * c).enumerate().for_each(|(y, row)| {
        Simd::best().in_vectors(Row { input, motion, factor, y, row });
    });
}

/// Number of pixels whose sources are found at once.
const LANES: usize = 16;

/// Operation that moves one row.
struct Row<'a, T: Element> {
    input: &'a Tensor<T>,
    motion: &'a Tensor,
    /// Number of motion pixels per input pixel along each axis.
    factor: usize,
    y: usize,
    row: &'a mut [T],
}

impl<T: Element> SimdF32Op for Row<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { input, motion, factor, y, row } = self;
        let size = [input.height, input.width];
        let colours = T::as_stored::<f32>(&input.data).filter(|_| input.channels == 3);
        for first in (0..input.width).step_by(LANES) {
            let moved = match factor {
                1 => of_pixels(motion, y, first),
                _ => std::array::from_fn(|i| mean_motion(motion, [y, first + i], factor)),
            };
            let to = &mut row[first * input.channels..];
            if let (Some(colours), Some(block)) = (colours, Block::new(&moved, [y, first], size)) {
                block.blend(colours, input.width, to, some);
                continue;
            }
            let places = Places::new(&moved, [y, first], size);
            // Loops over constant numbers of channels are vectorised.
            match input.channels {
                3 => places.blend_three(&input.data, to),
                4 => places.blend_four(&input.data, to),
                c => places.blend(&input.data, c, to),
            }
        }
    }
}

/// Neighbouring pixels with the same whole-pixel motion, so that their sources are neighbours too.
struct Block {
    /// Row and column of the upper left source of the first pixel.
    corner: [usize; 2],
    /// Fractional positions of each pixel between its sources, right and down.
    parts: [[f32; LANES]; 2],
}

impl Block {
    /// Makes a block of the pixels from (`y`, `x`) on, with motion `moved`, in an image of `size`. `None` unless
    /// all have one whole-pixel motion and all sources lie inside.
    #[inline(always)]
    fn new(moved: &[[f32; 2]; LANES], [y, x]: [usize; 2], size: [usize; 2]) -> Option<Self> {
        let (whole, is_all) = whole_motion(moved);
        let corner = corner_of(LANES, [y, x], whole, size).filter(|_| is_all && x + LANES <= size[1])?;
        let mut parts = [[0.0; LANES]; 2];
        for (i, moved) in moved.iter().enumerate() {
            parts[0][i] = moved[0] - whole[0];
            parts[1][i] = moved[1] - whole[1];
        }
        Some(Self { corner, parts })
    }

    /// Interpolates an image of three channels, `width` pixels wide, at these positions and writes to `to`.
    #[inline(always)]
    fn blend<T: Element, V: SimdF32>(&self, image: &[f32], width: usize, to: &mut [T], some: V) {
        let [above, left] = self.corner;
        let numbers = 3 * (LANES + 1);
        let upper = &image[3 * (above * width + left)..][..numbers];
        let lower = &image[3 * ((above + 1) * width + left)..][..numbers];
        for first in (0..LANES).step_by(V::N) {
            let across = some.load(&self.parts[0][first..]).repeat3();
            let down = some.load(&self.parts[1][first..]).repeat3();
            for third in 0..3 {
                let at = 3 * first + third * V::N;
                let upper = between(some.load(&upper[at..]), some.load(&upper[at + 3..]), across[third]);
                let lower = between(some.load(&lower[at..]), some.load(&lower[at + 3..]), across[third]);
                T::store(between(upper, lower, down[third]), &mut to[at..]);
            }
        }
    }
}

/// Interpolates linearly between `one` and `other`.
#[inline(always)]
fn between<V: SimdF32>(one: V, other: V, part: V) -> V {
    (other - one).mul_add(part, one)
}

/// The four bilinear sources of each of several pixels of a row.
struct Places {
    /// Indices in the image.
    pixels: [[u32; LANES]; 4],
    /// Weights, 0 outside.
    weights: [[f32; LANES]; 4],
}

impl Places {
    /// Finds the sources of the pixels from (`y`, `x`) on, with motion `moved`, in an image of `height` and
    /// `width`.
    #[inline(always)]
    fn new(moved: &[[f32; 2]; LANES], [y, x]: [usize; 2], [height, width]: [usize; 2]) -> Self {
        let (mut pixels, mut weights) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
        for i in 0..LANES {
            let (rows, down) = along(y as f32 + moved[i][1], height);
            let (columns, across) = along((x + i) as f32 + moved[i][0], width);
            for corner in 0..4 {
                pixels[corner][i] = rows[corner / 2] * width as u32 + columns[corner % 2];
                weights[corner][i] = down[corner / 2] * across[corner % 2];
            }
        }
        Self { pixels, weights }
    }

    /// Sources and weights of pixel `i`.
    #[inline(always)]
    fn of(&self, i: usize) -> ([usize; 4], [f32; 4]) {
        let Self { pixels: [a, b, c, d], weights: [wa, wb, wc, wd] } = self;
        ([a[i] as usize, b[i] as usize, c[i] as usize, d[i] as usize], [wa[i], wb[i], wc[i], wd[i]])
    }

    /// Interpolates an image of four channels and writes to `row`, as far as it goes.
    #[inline(always)]
    fn blend_four<T: Element>(&self, image: &[T], row: &mut [T]) {
        let image = image.as_chunks::<4>().0;
        for (i, to) in row.as_chunks_mut::<4>().0.iter_mut().take(LANES).enumerate() {
            let (pixels, weights) = self.of(i);
            let pixels = pixels.map(|at| Vec4::from_array(image[at].map(T::to_f32)));
            *to = mean(pixels, weights).to_array().map(T::from_f32);
        }
    }

    /// Interpolates an image of three channels and writes to `row`. Except at the ends, pixels are read and written
    /// as vectors of four, with one value of the next pixel.
    #[inline(always)]
    fn blend_three<T: Element>(&self, image: &[T], row: &mut [T]) {
        let (count, last) = ((row.len() / 3).min(LANES), image.len() / 3 - 1);
        for i in 0..count {
            let (pixels, weights) = self.of(i);
            let mean = if pixels[3] < last {
                mean(pixels.map(|at| four(image, 3 * at)), weights)
            } else {
                mean(pixels.map(|at| three(image, 3 * at)), weights)
            };
            let mean = mean.to_array().map(T::from_f32);
            if i + 1 < count {
                row[3 * i..][..4].copy_from_slice(&mean);
            } else {
                row[3 * i..][..3].copy_from_slice(&mean[..3]);
            }
        }
    }

    /// Interpolates an image of any number of channels and writes to `row`.
    #[inline(always)]
    fn blend<T: Element>(&self, image: &[T], channels: usize, row: &mut [T]) {
        for (i, to) in row.chunks_exact_mut(channels).take(LANES).enumerate() {
            let (pixels, w) = self.of(i);
            let [a, b, c, d] = pixels.map(|at| &image[at * channels..][..channels]);
            for (k, to) in to.iter_mut().enumerate() {
                let upper = w[0] * a[k].to_f32() + w[1] * b[k].to_f32();
                *to = T::from_f32(upper + (w[2] * c[k].to_f32() + w[3] * d[k].to_f32()));
            }
        }
    }
}

/// Four elements from `at` on.
#[inline(always)]
fn four<T: Element>(image: &[T], at: usize) -> Vec4 {
    let numbers = &image[at..at + 4];
    Vec4::new(numbers[0].to_f32(), numbers[1].to_f32(), numbers[2].to_f32(), numbers[3].to_f32())
}

/// Three elements from `at` on, and a zero.
#[inline(always)]
fn three<T: Element>(image: &[T], at: usize) -> Vec4 {
    let numbers = &image[at..at + 3];
    Vec4::new(numbers[0].to_f32(), numbers[1].to_f32(), numbers[2].to_f32(), 0.0)
}

/// Weighted sum of four pixels.
#[inline(always)]
fn mean([a, b, c, d]: [Vec4; 4], [wa, wb, wc, wd]: [f32; 4]) -> Vec4 {
    (a * wa + b * wb) + (c * wc + d * wd)
}

/// Finds the two of `count` pixels in a line between which `at` lies, and their weights. Beyond the ends, and for
/// NaN, the result is an end pixel with weight 0.
#[inline(always)]
fn along(at: f32, count: usize) -> ([u32; 2], [f32; 2]) {
    let last = (count - 1) as f32;
    let first = at.floor();
    let second = first + 1.0;
    let part = at - first;
    let near = if first >= 0.0 && first <= last { 1.0 - part } else { 0.0 };
    let far = if second >= 0.0 && second <= last { part } else { 0.0 };
    ([first, second].map(|at| whole(at.max(0.0).min(last))), [near, far])
}

/// Converts a whole number of 0…2²³ − 1 by adding 2²³ and taking the fraction bits. A checked conversion is not
/// vectorised.
#[inline(always)]
fn whole(number: f32) -> u32 {
    (number + 8_388_608.0).to_bits() & 0x007F_FFFF
}

/// Motion of the pixels of row `y` from column `x` on; the last pixel is repeated beyond the border.
#[inline(always)]
fn of_pixels(motion: &Tensor, y: usize, x: usize) -> [[f32; 2]; LANES] {
    let row = &motion.row(y).as_chunks::<2>().0[x..];
    match row.first_chunk() {
        Some(lanes) => *lanes,
        None => std::array::from_fn(|i| row[i.min(row.len() - 1)]),
    }
}

/// Mean motion of the `factor`² pixels that form pixel (`y`, `x`) of the lower resolution, in pixels of the latter.
#[inline(always)]
fn mean_motion(motion: &Tensor, [y, x]: [usize; 2], factor: usize) -> [f32; 2] {
    let mut sum = [0.0f32; 2];
    let first = (x * factor).min(motion.width - factor);
    for row in y * factor..(y + 1) * factor {
        for column in first..first + factor {
            let from = motion.pixel(row, column);
            sum = [sum[0] + from[0], sum[1] + from[1]];
        }
    }
    sum.map(|s| s / (factor * factor * factor) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_move_and_the_outside_is_zero() {
        let input = Tensor { data: (1..=12).map(|i| i as f32).collect(), height: 3, width: 4, channels: 1 };
        let mut motion = Tensor::zeros(6, 8, 2);
        motion.data.chunks_exact_mut(2).for_each(|m| m.copy_from_slice(&[2.0, -4.0]));
        let mut out = Tensor::<f32>::default();
        // At half the resolution: one pixel right, two up.
        warp(&input, &motion, &mut out);
        assert_eq!(out.row(2), [2.0, 3.0, 4.0, 0.0]);
        assert_eq!(out.row(1), [0.0; 4]);
        motion.data.fill(f32::NAN);
        warp(&input, &motion, &mut out);
        assert!(out.data.iter().all(|&v| v == 0.0));
    }

    #[test]
    fn pixels_that_move_alike_are_moved_as_others_are() {
        let random = |numbers: usize, seed: u64| {
            let shape = vec![numbers, 5];
            crate::weights::random::values(&crate::plan::Parameter { name: "x".into(), shape }, seed)
        };
        let (height, width) = (9, 70);
        let input = Tensor { data: random(height * width * 3, 1).into(), height, width, channels: 3 };
        let mut motion = Tensor::zeros(height, width, 2);
        for (i, (moved, part)) in motion.data.iter_mut().zip(random(height * width * 2, 2)).enumerate() {
            *moved = [1.0, -2.0][i % 2] + part.abs().min(0.99);
        }
        let mut out = Tensor::default();
        warp(&input, &motion, &mut out);
        for y in 0..height {
            for x in 0..width {
                let moved = motion.pixel(y, x);
                let (rows, down) = along(y as f32 + moved[1], height);
                let (columns, across) = along(x as f32 + moved[0], width);
                for c in 0..3 {
                    let one = |i: usize, j: usize| {
                        down[i] * across[j] * input.pixel(rows[i] as usize, columns[j] as usize)[c]
                    };
                    let expected = one(0, 0) + one(0, 1) + one(1, 0) + one(1, 1);
                    assert!((out.pixel(y, x)[c] - expected).abs() < 1e-5, "{y} {x} {c}");
                }
            }
        }
    }
}
