use super::element::Element;
use super::map::Map;
use super::simd::{Simd, Work};
use rayon::prelude::*;

/// Moves `input` along `motion` (pixels of level 0 to the previous position, averaged and scaled to the resolution
/// of `input`): bilinear, zero outside.
pub fn warp<T: Element>(input: &Map<T>, motion: &Map, out: &mut Map<T>) {
    let factor = motion.height / input.height;
    let c = input.channels;
    out.resize([input.height, input.width, c]);
    out.data.par_chunks_mut(input.width * c).enumerate().for_each(|(y, row)| {
        Simd::best().vectorised(Row { input, motion, factor, y, row });
    });
}

/// The warping of one row.
struct Row<'a, T> {
    input: &'a Map<T>,
    motion: &'a Map,
    /// Pixels of the motion to one of the input, along each axis.
    factor: usize,
    y: usize,
    row: &'a mut [T],
}

impl<T: Element> Work for Row<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { input, motion, factor, y, row } = self;
        for (x, to) in row.chunks_exact_mut(input.channels).enumerate() {
            let [dx, dy] = mean_motion(motion, [y * factor, x * factor], factor);
            bilinear(input, y as f32 + dy, x as f32 + dx, to);
        }
    }
}

/// The mean motion of `factor`² pixels from (`y`, `x`) on, in pixels `factor` times as large.
#[inline(always)]
fn mean_motion(motion: &Map, [y, x]: [usize; 2], factor: usize) -> [f32; 2] {
    if factor == 1 {
        let from = motion.pixel(y, x);
        return [from[0], from[1]];
    }
    let mut sum = [0.0f32; 2];
    for row in y..y + factor {
        for column in x..x + factor {
            let from = motion.pixel(row, column);
            sum = [sum[0] + from[0], sum[1] + from[1]];
        }
    }
    sum.map(|s| s / (factor * factor * factor) as f32)
}

/// Writes the value at (`y`, `x`) between pixel centres to `to`.
#[inline(always)]
fn bilinear<T: Element>(input: &Map<T>, y: f32, x: f32, to: &mut [T]) {
    let inside = y > -1.0 && x > -1.0 && y < input.height as f32 && x < input.width as f32;
    // Also false for positions that are no numbers.
    if !inside {
        to.fill(T::default());
        return;
    }
    let (top, left) = (y.floor(), x.floor());
    let (fy, fx) = (y - top, x - left);
    let (top, left) = (top as isize, left as isize);
    let is_inner =
        top >= 0 && left >= 0 && top + 1 < input.height as isize && left + 1 < input.width as isize;
    if is_inner {
        let (top, left, c) = (top as usize, left as usize, input.channels);
        let at = (top * input.width + left) * c;
        let (above, below) = (&input.data[at..at + 2 * c], &input.data[at + input.width * c..][..2 * c]);
        let weights = [(1.0 - fy) * (1.0 - fx), (1.0 - fy) * fx, fy * (1.0 - fx), fy * fx];
        let ((a, b), (d, e)) = (above.split_at(c), below.split_at(c));
        for k in 0..c {
            let upper = weights[0] * a[k].to_f32() + weights[1] * b[k].to_f32();
            to[k] = T::from_f32(upper + weights[2] * d[k].to_f32() + weights[3] * e[k].to_f32());
        }
        return;
    }
    to.fill(T::default());
    for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
        for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
            let (row, column) = (top + dy, left + dx);
            let exists =
                row >= 0 && column >= 0 && row < input.height as isize && column < input.width as isize;
            if exists {
                let from = input.pixel(row as usize, column as usize);
                for (to, v) in to.iter_mut().zip(from) {
                    *to = T::from_f32(to.to_f32() + wy * wx * v.to_f32());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_move_and_the_outside_is_zero() {
        let input = Map { data: (1..=12).map(|i| i as f32).collect(), height: 3, width: 4, channels: 1 };
        let mut motion = Map::zeros(6, 8, 2);
        motion.data.chunks_exact_mut(2).for_each(|m| m.copy_from_slice(&[2.0, -4.0]));
        let mut out = Map::<f32>::default();
        // At half the resolution: one to the right, two up.
        warp(&input, &motion, &mut out);
        assert_eq!(out.row(2), [2.0, 3.0, 4.0, 0.0]);
        assert_eq!(out.row(1), [0.0; 4]);
        motion.data.fill(f32::NAN);
        warp(&input, &motion, &mut out);
        assert!(out.data.iter().all(|&v| v == 0.0));
    }
}
