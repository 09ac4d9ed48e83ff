//! Spatial spread of masking: a Gaussian over neighbouring pixels of a band.

/// Standard deviation in pixels of the band.
const SIGMA: f64 = 3.0;

/// Reach of the window to each side, in pixels.
pub(crate) const REACH: usize = 6;

/// Symmetric window, from the centre outwards; cut at [`REACH`] and normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blur([f32; REACH + 1]);

impl Blur {
    /// Window whose weights sum to 1.
    pub fn new() -> Self {
        let bump = |i: usize| (-0.5 * (i as f64 / SIGMA).powi(2)).exp();
        let sum = bump(0) + 2.0 * (1..=REACH).map(bump).sum::<f64>();
        Self(std::array::from_fn(|i| (bump(i) / sum) as f32))
    }

    /// Whether bands of this size are blurred at all: both sides must exceed [`REACH`].
    pub fn reaches(width: usize, height: usize) -> bool {
        width.min(height) > REACH
    }

    /// Blurs a row, which is mirrored about the centres of its outermost pixels. `line` is scratch memory.
    pub fn along_row(&self, row: &[f32], line: &mut Vec<f32>, out: &mut [f32]) {
        let n = row.len();
        line.clear();
        line.extend((1..=REACH).rev().map(|i| row[i]));
        line.extend_from_slice(row);
        line.extend((1..=REACH).map(|i| row[n - 1 - i]));
        self.sums(|offset| &line[(REACH as isize + offset) as usize..], out);
    }

    /// Blurs across rows: `row(y)` is the row `y` of a band of `height` rows, `out` becomes row `y` of the blurred band.
    pub fn across_rows<'a>(
        &self,
        y: usize,
        height: usize,
        row: impl Fn(usize) -> &'a [f32],
        out: &mut [f32],
    ) {
        self.sums(|offset| row(mirrored(y as isize + offset, height)), out);
    }

    /// Weighted sums of the slices that `source` gives for the offsets −[`REACH`] to [`REACH`].
    #[inline(always)]
    fn sums<'a>(&self, source: impl Fn(isize) -> &'a [f32], out: &mut [f32]) {
        let n = out.len();
        for (value, centre) in out.iter_mut().zip(source(0)) {
            *value = self.0[0] * centre;
        }
        for (i, weight) in self.0.iter().enumerate().skip(1) {
            let (before, after) = (&source(-(i as isize))[..n], &source(i as isize)[..n]);
            for x in 0..n {
                out[x] += weight * (before[x] + after[x]);
            }
        }
    }
}

/// Index of pixel `i` of `n`, mirrored about the centres of the outermost pixels.
fn mirrored(i: isize, n: usize) -> usize {
    let last = n as isize - 1;
    let i = i.abs();
    (if i > last { 2 * last - i } else { i }) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_stay_and_impulses_spread_alike_along_rows_and_across() {
        let blur = Blur::new();
        for (n, at) in [(7, 0), (9, 1), (20, 10), (20, 19)] {
            let mut row = vec![0.0; n];
            row[at] = 1.0;
            let mut found = vec![0.0; n];
            blur.along_row(&row, &mut Vec::new(), &mut found);
            for y in 0..n {
                let mut across = [0.0];
                blur.across_rows(y, n, |i| &row[i..=i], &mut across);
                assert!((across[0] - found[y]).abs() < 1e-6, "{n} {at} {y}");
            }
            blur.along_row(&vec![2.0; n], &mut Vec::new(), &mut found);
            assert!(found.iter().all(|v| (v - 2.0).abs() < 1e-5));
        }
        assert!((blur.0[0] - 0.137_02).abs() < 1e-5 && (blur.0[REACH] - 0.018_544).abs() < 1e-5, "{blur:?}");
    }
}
