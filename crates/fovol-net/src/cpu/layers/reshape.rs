//! Layers that move or average a few elements of each pixel.

use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::element::Element;
use rayon::prelude::*;

/// Resizes `out`, keeping its buffer, and calls `fill` for each of its rows.
fn rows<T: Element>(out: &mut Tensor<T>, size: [usize; 3], fill: impl Fn(usize, &mut [T]) + Sync) {
    out.resize(size);
    out.data.par_chunks_mut(size[1] * size[2]).enumerate().for_each(|(y, row)| fill(y, row));
}

/// Averages 2×2 pixels.
pub fn pool<T: Element>(input: &Tensor<T>, out: &mut Tensor<T>) {
    let c = input.channels;
    rows(out, [input.height / 2, input.width / 2, c], |y, row| {
        let (above, below) = (input.row(2 * y), input.row(2 * y + 1));
        for (x, to) in row.chunks_exact_mut(c).enumerate() {
            let at = 2 * x * c;
            for k in 0..c {
                let sum = |row: &[T]| row[at + k].to_f32() + row[at + c + k].to_f32();
                to[k] = T::from_f32(0.25 * (sum(above) + sum(below)));
            }
        }
    });
}

/// Folds 2×2 pixels into channels: channel c of pixel (x, y) of the four becomes 4c + 2y + x.
pub fn space_to_depth(input: &Tensor, out: &mut Tensor) {
    let c = input.channels;
    rows(out, [input.height / 2, input.width / 2, 4 * c], |y, row| {
        for (x, to) in row.chunks_exact_mut(4 * c).enumerate() {
            for part in 0..4 {
                let from = input.pixel(2 * y + part / 2, 2 * x + part % 2);
                (0..c).for_each(|k| to[4 * k + part] = from[k]);
            }
        }
    });
}

/// Unfolds channels into 2×2 pixels, the inverse of [`space_to_depth`].
pub fn depth_to_space(input: &Tensor, out: &mut Tensor) {
    let c = input.channels / 4;
    rows(out, [input.height * 2, input.width * 2, c], |y, row| {
        for (x, to) in row.chunks_exact_mut(c).enumerate() {
            let from = input.pixel(y / 2, x / 2);
            let part = 2 * (y % 2) + x % 2;
            (0..c).for_each(|k| to[k] = from[4 * k + part]);
        }
    });
}

/// Appends `weight` to `colour` as a fourth channel.
pub fn join(colour: &Tensor, weight: &Tensor, out: &mut Tensor) {
    rows(out, [colour.height, colour.width, 4], |y, row| {
        let pixels = colour.row(y).as_chunks::<3>().0.iter().zip(weight.row(y));
        for (to, (&[r, g, b], &w)) in row.as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
            *to = [r, g, b, w];
        }
    });
}

/// Copies `channels` channels from number `first` on.
pub fn part(input: &Tensor, first: usize, channels: usize, out: &mut Tensor) {
    rows(out, [input.height, input.width, channels], |y, row| {
        let pixels = row.chunks_exact_mut(channels).zip(input.row(y).chunks_exact(input.channels));
        pixels.for_each(|(to, from)| to.copy_from_slice(&from[first..first + channels]));
    });
}

/// Shifts an image: pixel (x, y) of `to` becomes pixel (x, y) + `by` of `from`, or the nearest one inside. `to`
/// keeps its size.
pub fn shift<T: Element>(from: &Tensor<T>, by: [i64; 2], to: &mut Tensor<T>) {
    let channels = from.channels;
    let nearest = |at: usize, way: i64, count: usize| (at as i64 + way).clamp(0, count as i64 - 1) as usize;
    to.data.par_chunks_mut(to.width * channels).enumerate().for_each(|(y, row)| {
        let from_row = from.row(nearest(y, by[1], from.height));
        for (x, pixel) in row.chunks_exact_mut(channels).enumerate() {
            let at = nearest(x, by[0], from.width) * channels;
            pixel.copy_from_slice(&from_row[at..at + channels]);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_orders_channels_as_pixel_unshuffle_and_back() {
        let mut input = Tensor::zeros(4, 6, 3);
        input.data.iter_mut().enumerate().for_each(|(i, v)| *v = i as f32);
        let (mut folded, mut back) = (Tensor::default(), Tensor::default());
        space_to_depth(&input, &mut folded);
        assert_eq!((folded.height, folded.width, folded.channels), (2, 3, 12));
        assert_eq!(folded.pixel(1, 2)[4 * 2 + 2 + 1], input.pixel(3, 5)[2]);
        depth_to_space(&folded, &mut back);
        assert_eq!(back, input);
    }

    #[test]
    fn pools_are_means() {
        let input = Tensor { data: vec![1.0, 2.0, 3.0, 6.0].into(), height: 2, width: 2, channels: 1 };
        let mut out = Tensor::default();
        pool(&input, &mut out);
        assert_eq!(out, Tensor { data: vec![3.0].into(), height: 1, width: 1, channels: 1 });
    }
}
