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
    let rows = out.data.par_chunks_mut(input.width * c).enumerate();
    rows.for_each_init(Places::default, |places, (y, row)| {
        Simd::best().vectorised(Row { input, motion, factor, y, places, row });
    });
}

/// For each pixel of a row the four pixels that it lies between: one array for each of these, so that loops over pixels
/// become vectors.
#[derive(Debug, Default)]
struct Places {
    /// Their numbers in the image.
    pixels: [Vec<u32>; 4],
    /// Their weights, 0 outside.
    weights: [Vec<f32>; 4],
}

/// The warping of one row.
struct Row<'a, T: Element> {
    input: &'a Map<T>,
    motion: &'a Map,
    /// Pixels of the motion to one of the input, along each axis.
    factor: usize,
    y: usize,
    places: &'a mut Places,
    row: &'a mut [T],
}

impl<T: Element> Work for Row<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { input, motion, factor, y, places, row } = self;
        places.find(motion, factor, y, [input.height, input.width]);
        // Pixels of known length are moved in vectors.
        match input.channels {
            3 => places.blend::<3, T>(input, row),
            4 => places.blend::<4, T>(input, row),
            c => {
                for (x, to) in row.chunks_exact_mut(c).enumerate() {
                    let place = places.at(x);
                    let pixels = place.map(|(at, _)| &input.data[at as usize * c..][..c]);
                    for (k, to) in to.iter_mut().enumerate() {
                        let upper = place[0].1 * pixels[0][k].to_f32() + place[1].1 * pixels[1][k].to_f32();
                        let lower = place[2].1 * pixels[2][k].to_f32() + place[3].1 * pixels[3][k].to_f32();
                        *to = T::from_f32(upper + lower);
                    }
                }
            }
        }
    }
}

impl Places {
    /// Finds where the pixels of row `y` were in an image of `height` and `width`.
    #[inline(always)]
    fn find(&mut self, motion: &Map, factor: usize, y: usize, [height, width]: [usize; 2]) {
        self.pixels.iter_mut().for_each(|pixels| pixels.resize(width, 0));
        self.weights.iter_mut().for_each(|weights| weights.resize(width, 0.0));
        let [a, b, c, d] = &mut self.pixels;
        let [wa, wb, wc, wd] = &mut self.weights;
        let (a, b, c, d) = (&mut a[..width], &mut b[..width], &mut c[..width], &mut d[..width]);
        let (wa, wb, wc, wd) = (&mut wa[..width], &mut wb[..width], &mut wc[..width], &mut wd[..width]);
        for x in 0..width {
            let [dx, dy] = mean_motion(motion, [y * factor, x * factor], factor);
            let (rows, down) = along(y as f32 + dy, height);
            let (columns, across) = along(x as f32 + dx, width);
            a[x] = rows[0] * width as u32 + columns[0];
            b[x] = rows[0] * width as u32 + columns[1];
            c[x] = rows[1] * width as u32 + columns[0];
            d[x] = rows[1] * width as u32 + columns[1];
            wa[x] = down[0] * across[0];
            wb[x] = down[0] * across[1];
            wc[x] = down[1] * across[0];
            wd[x] = down[1] * across[1];
        }
    }

    /// The four pixels that pixel `x` lies between, with their weights.
    #[inline(always)]
    fn at(&self, x: usize) -> [(u32, f32); 4] {
        let [a, b, c, d] = &self.pixels;
        let [wa, wb, wc, wd] = &self.weights;
        [(a[x], wa[x]), (b[x], wb[x]), (c[x], wc[x]), (d[x], wd[x])]
    }

    /// Writes what `input`, of `C` channels, has there to `row`.
    #[inline(always)]
    fn blend<const C: usize, T: Element>(&self, input: &Map<T>, row: &mut [T]) {
        let pixels = input.data.as_chunks::<C>().0;
        for (x, to) in row.as_chunks_mut::<C>().0.iter_mut().enumerate() {
            let [(a, wa), (b, wb), (c, wc), (d, wd)] = self.at(x);
            let (a, b) = (&pixels[a as usize], &pixels[b as usize]);
            let (c, d) = (&pixels[c as usize], &pixels[d as usize]);
            for k in 0..C {
                let upper = wa * a[k].to_f32() + wb * b[k].to_f32();
                to[k] = T::from_f32(upper + (wc * c[k].to_f32() + wd * d[k].to_f32()));
            }
        }
    }
}

/// The two of `count` pixels in a line that `at` lies between, and their weights. Beyond the ends, and where `at` is no
/// number, they are the first or last with a weight of 0.
#[inline(always)]
fn along(at: f32, count: usize) -> ([u32; 2], [f32; 2]) {
    let last = (count - 1) as f32;
    let first = at.floor();
    let second = first + 1.0;
    let part = at - first;
    let near = if first >= 0.0 && first <= last { 1.0 - part } else { 0.0 };
    let far = if second >= 0.0 && second <= last { part } else { 0.0 };
    ([first.max(0.0).min(last) as u32, second.max(0.0).min(last) as u32], [near, far])
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_move_and_the_outside_is_zero() {
        let input =
            Map { data: (1..=12).map(|i| i as f32).collect(), height: 3, width: 4, channels: 1, top: 0 };
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
