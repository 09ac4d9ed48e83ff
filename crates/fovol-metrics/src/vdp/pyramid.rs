//! The Laplacian pyramid: Burt and Adelson, "The Laplacian pyramid as a compact image code" (1983), with
//! a = 0.4 and borders mirrored about the edge of the outermost pixels (see [`continue_ends`]).

use crate::planes::Plane;
use rayon::prelude::*;

/// Smallest width and height that FovVideoVDP and ColorVideoVDP can measure, in pixels; smaller frames have no contrast band.
pub const MIN_SIDE: u32 = 4;

/// Centre frequency of the second Laplacian band relative to the first, which lies at half the sampling frequency.
/// Further bands halve it.
const SECOND_BAND: f64 = 0.3228;

/// Frequency in cycles per degree at which the bands end.
pub(crate) const LOWEST: f64 = 0.2;

/// Half of the symmetric kernel, from the centre outwards.
const KERNEL: [f32; 3] = [0.4, 0.25, 0.05];

/// Centre frequencies in cycles per degree of all bands that fit, finest first; at least one. The base, which follows
/// them, keeps at least 2 pixels along each side.
pub(crate) fn octaves(width: usize, height: usize, pixels_per_degree: f64) -> Vec<f64> {
    let halvings = width.min(height).max(4).ilog2() as i32 - 1;
    let nyquist = 0.5 * pixels_per_degree;
    let coarser = (1..halvings).map(|i| nyquist * SECOND_BAND * 0.5_f64.powi(i - 1));
    std::iter::once(nyquist).chain(coarser).collect()
}

/// Gaussian pyramid of one picture, finest level first.
#[derive(Debug, Clone)]
pub(crate) struct Pyramid(Vec<Plane>);

impl Pyramid {
    /// Allocates `levels` levels for a picture of this size.
    pub fn new(width: usize, height: usize, levels: usize) -> Self {
        let plane = |level: usize| {
            let (width, height) = (((width - 1) >> level) + 1, ((height - 1) >> level) + 1);
            Plane { width, height, values: vec![0.0; width * height] }
        };
        Self((0..levels).map(plane).collect())
    }

    /// Finest level, which the caller fills before [`Self::build`].
    pub fn finest_mut(&mut self) -> &mut Plane {
        &mut self.0[0]
    }

    /// Computes all coarser levels.
    pub fn build(&mut self) {
        for level in 1..self.0.len() {
            let (fine, coarse) = self.0.split_at_mut(level);
            reduce(&fine[level - 1], &mut coarse[0]);
        }
    }

    pub fn level(&self, level: usize) -> &Plane {
        &self.0[level]
    }
}

/// Mirrored index of pixel `i` of `n`; `i` may lie up to 2 beyond the ends.
fn mirrored(i: isize, n: usize) -> usize {
    let n = n as isize;
    let inside = if i < 0 { -1 - i } else { i };
    let inside = if inside >= n { 2 * n - 1 - inside } else { inside };
    inside.clamp(0, n - 1) as usize
}

/// Downsamples `fine` by 2 along both axes after smoothing.
fn reduce(fine: &Plane, coarse: &mut Plane) {
    let width = fine.width;
    coarse.values.par_chunks_mut(coarse.width).enumerate().for_each_init(
        || vec![0.0; width + 4],
        |line, (y, out)| {
            let row = |dy: isize| fine.row(mirrored(2 * y as isize + dy, fine.height));
            smooth_columns([row(-2), row(-1), row(0), row(1), row(2)], &mut line[2..width + 2]);
            continue_ends(line, fine.height);
            smooth_every_second(line, out);
        },
    );
}

/// Fills the 2 places before and the 2 after the row in `line`, a row of a picture of `height` rows.
///
/// Borders are mirrored unless exactly one of width and height is odd. There the published program ends rows as if
/// their length had the parity of the height, so that the weights of the last pixel sum to 1.25 or 0.75. Mirroring
/// there too would change scores by up to 0.006 JOD in small frames, and they would no longer be comparable.
fn continue_ends(line: &mut [f32], height: usize) {
    let width = line.len() - 4;
    let end = width + 2;
    (line[0], line[1]) = (line[3], line[2]);
    let (last, before) = (line[end - 1], line[end - 2]);
    (line[end], line[end + 1]) = match (width % 2, height % 2) {
        (0, 1) => (before + last * KERNEL[1] / KERNEL[2], 0.0),
        (1, 0) => (0.0, last),
        _ => (last, before),
    };
}

fn smooth_columns(rows: [&[f32]; 5], out: &mut [f32]) {
    let n = out.len();
    let [a, b, c, d, e] = rows.map(|row| &row[..n]);
    for x in 0..n {
        out[x] = KERNEL[0] * c[x] + KERNEL[1] * (b[x] + d[x]) + KERNEL[2] * (a[x] + e[x]);
    }
}

/// Smooths and downsamples one row; `out[x]` is centred on `line[2x + 2]`.
fn smooth_every_second(line: &[f32], out: &mut [f32]) {
    for (x, out) in out.iter_mut().enumerate() {
        let v = &line[2 * x..2 * x + 5];
        *out = KERNEL[0] * v[2] + KERNEL[1] * (v[1] + v[3]) + KERNEL[2] * (v[0] + v[4]);
    }
}

/// Upsamples row `y` from `coarse` to twice its resolution. `line` needs room for 2 pixels more than a coarse row.
pub(crate) fn expand_row(coarse: &Plane, y: usize, line: &mut Vec<f32>, out: &mut [f32]) {
    let width = coarse.width;
    line.resize(width + 2, 0.0);
    let row = |dy: isize| coarse.row(((y / 2) as isize + dy).clamp(0, coarse.height as isize - 1) as usize);
    let (above, here, below) = (row(-1), row(0), row(1));
    // Even rows meet 3 taps of the kernel and odd ones 2. Taps are doubled, as every second row is empty.
    let [middle, near, far] = KERNEL.map(|k| 2.0 * k);
    let inner = &mut line[1..width + 1];
    if y.is_multiple_of(2) {
        for x in 0..width {
            inner[x] = middle * here[x] + far * (above[x] + below[x]);
        }
    } else {
        for x in 0..width {
            inner[x] = near * (here[x] + below[x]);
        }
    }
    line[0] = line[1];
    line[width + 1] = line[width];
    let mut pairs = out.chunks_exact_mut(2);
    for (pair, v) in (&mut pairs).zip(line.windows(3)) {
        pair[0] = middle * v[1] + far * (v[0] + v[2]);
        pair[1] = near * (v[1] + v[2]);
    }
    if let [last] = pairs.into_remainder() {
        *last = middle * line[width] + far * (line[width - 1] + line[width + 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(coarse: &Plane, width: usize, height: usize) -> Plane {
        let mut out = Plane { width, height, values: vec![0.0; width * height] };
        for (y, row) in out.values.chunks_mut(width).enumerate() {
            expand_row(coarse, y, &mut Vec::new(), row);
        }
        out
    }

    #[test]
    fn as_many_bands_as_fit_halve_the_frequency() {
        for (side, count) in [(4, 1), (7, 1), (8, 2), (16, 3), (48, 4), (120, 5)] {
            assert_eq!(octaves(side, 500, 75.4).len(), count, "{side}");
        }
        let found = octaves(64, 64, 20.0);
        let expected = [10.0, 3.228, 1.614, 0.807, 0.4035];
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn constants_stay_constant_in_every_size() {
        for (width, height) in [(4, 4), (5, 7), (6, 10), (33, 21)] {
            let mut pyramid = Pyramid::new(width, height, 2);
            pyramid.finest_mut().values.fill(3.0);
            pyramid.build();
            let coarse = pyramid.level(1);
            assert_eq!((coarse.width, coarse.height), (width.div_ceil(2), height.div_ceil(2)));
            assert!(coarse.values.iter().all(|v| (v - 3.0).abs() < 1e-6));
            let back = expanded(coarse, width, height);
            assert!(back.values.iter().all(|v| (v - 3.0).abs() < 1e-6));
        }
    }

    #[test]
    fn rows_end_as_in_the_published_program() {
        for (width, height, weights) in [
            (8, 8, [0.05, 0.25, 0.4, 0.3]),
            (7, 7, [0.0, 0.05, 0.3, 0.65]),
            (8, 7, [0.05, 0.25, 0.45, 0.5]),
            (7, 8, [0.0, 0.05, 0.25, 0.45]),
        ] {
            for (i, weight) in weights.into_iter().enumerate() {
                let mut pyramid = Pyramid::new(width, height, 2);
                let column = pyramid.finest_mut().values.iter_mut().skip(width - 4 + i).step_by(width);
                column.for_each(|v| *v = 1.0);
                pyramid.build();
                let found = pyramid.level(1).row(1)[3];
                assert!((found - weight).abs() < 1e-6, "{width}x{height}, {i}: {found} {weight}");
            }
        }
    }

    #[test]
    fn an_impulse_spreads_by_the_kernel_and_mirrors_at_the_edge() {
        let mut pyramid = Pyramid::new(6, 6, 2);
        for y in 0..6 {
            pyramid.finest_mut().values[y * 6 + 1] = 1.0;
        }
        pyramid.build();
        let close = |found: &[f32], expected: &[f32]| {
            assert_eq!(found.len(), expected.len());
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-6), "{found:?}");
        };
        // Mirroring repeats pixel 1 at −2.
        close(pyramid.level(1).row(1), &[0.3, 0.25, 0.0]);
        let coarse = Plane { width: 3, height: 1, values: vec![1.0, 0.0, 0.0] };
        close(expanded(&coarse, 6, 2).row(0), &[0.9, 0.5, 0.1, 0.0, 0.0, 0.0]);
        close(expanded(&coarse, 5, 2).row(1), &[0.9, 0.5, 0.1, 0.0, 0.0]);
    }
}
