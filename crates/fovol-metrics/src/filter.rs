/// Weights of a separable window, equal along both axes; they sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Window(Vec<f64>);

/// Outputs computed at once, so that sums stay in registers.
const LANES: usize = 8;

impl Window {
    /// Gaussian of standard deviation `sigma` pixels, cut to `size` pixels and normalised.
    pub fn gaussian(size: usize, sigma: f64) -> Self {
        let middle = (size as f64 - 1.0) * 0.5;
        let weight = |i: usize| (-(i as f64 - middle).powi(2) / (2.0 * sigma * sigma)).exp();
        let sum: f64 = (0..size).map(weight).sum();
        Self((0..size).map(|i| weight(i) / sum).collect())
    }

    /// Equal weights over `size` pixels.
    pub fn uniform(size: usize) -> Self {
        Self(vec![1.0 / size as f64; size])
    }

    /// Side of the window in pixels.
    pub fn size(&self) -> usize {
        self.0.len()
    }

    /// Filters one row without padding: `out[i]` is the weighted mean of `row[i..i + size]`.
    pub fn along_row(&self, row: &[f64], out: &mut [f64]) {
        debug_assert_eq!(row.len() + 1, out.len() + self.size());
        self.sums(out, |k, i| &row[k + i..]);
    }

    /// Filters across rows: `out[i]` is the weighted mean of `rows[..size][i]`.
    pub fn across_rows(&self, rows: &[Vec<f64>], out: &mut [f64]) {
        debug_assert_eq!(rows.len(), self.size());
        self.sums(out, |k, i| &rows[k][i..]);
    }

    /// `out[i] = Σ_k weight[k] · source(k, i)[0]`.
    #[inline(always)]
    fn sums<'a>(&self, out: &mut [f64], source: impl Fn(usize, usize) -> &'a [f64]) {
        let mut blocks = out.chunks_exact_mut(LANES);
        let mut at = 0;
        for block in &mut blocks {
            let mut sum = [0.0; LANES];
            for (k, &weight) in self.0.iter().enumerate() {
                let values = &source(k, at)[..LANES];
                for lane in 0..LANES {
                    sum[lane] += weight * values[lane];
                }
            }
            block.copy_from_slice(&sum);
            at += LANES;
        }
        for (i, value) in blocks.into_remainder().iter_mut().enumerate() {
            *value = self.0.iter().enumerate().map(|(k, weight)| weight * source(k, at + i)[0]).sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant_and_a_ramp_a_ramp() {
        for window in [Window::gaussian(11, 1.5), Window::uniform(7)] {
            let ramp: Vec<f64> = (0..40).map(f64::from).collect();
            let mut out = vec![0.0; 41 - window.size()];
            window.along_row(&ramp, &mut out);
            let middle = (window.size() / 2) as f64;
            for (i, value) in out.iter().enumerate() {
                assert!((value - (i as f64 + middle)).abs() < 1e-12);
            }
            let rows = vec![vec![0.7; 13]; window.size()];
            let mut out = vec![0.0; 13];
            window.across_rows(&rows, &mut out);
            assert!(out.iter().all(|v| (v - 0.7).abs() < 1e-12));
        }
    }
}
