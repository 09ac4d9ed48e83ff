use fovol_core::stop;
use rayon::prelude::*;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftDirection, FftPlanner};
use std::sync::Arc;

/// Fourier transforms of a cube of `n`³ values, x fastest.
pub(super) struct CubeTransform {
    n: usize,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
}

impl CubeTransform {
    pub fn new(n: usize) -> Self {
        let mut planner = FftPlanner::new();
        Self { n, forward: planner.plan_fft_forward(n), inverse: planner.plan_fft_inverse(n) }
    }

    /// Values to Fourier coefficients: scaled by 1/n³, so that a wave of amplitude 1 has two
    /// coefficients of ½. `spare` is overwritten.
    pub fn forward(&self, data: &mut [Complex32], spare: &mut [Complex32]) {
        self.transform(&*self.forward, data, spare);
        let scale = 1.0 / (self.n as f32).powi(3);
        data.par_chunks_mut(self.n * self.n).for_each(|slab| slab.iter_mut().for_each(|c| *c *= scale));
    }

    /// Fourier coefficients to values; `spare` is overwritten.
    pub fn inverse(&self, data: &mut [Complex32], spare: &mut [Complex32]) {
        self.transform(&*self.inverse, data, spare);
    }

    fn transform(&self, fft: &dyn Fft<f32>, data: &mut [Complex32], spare: &mut [Complex32]) {
        let n = self.n;
        data.par_chunks_mut(n * n).for_each_init(
            || Lines::new(fft, n),
            |lines, slab| {
                stop::point();
                fft.process_with_scratch(slab, &mut lines.scratch);
                lines.across(fft, slab);
            },
        );
        // [z][y][x] → [y][z][x], so that lines along z lie within one slab, and back.
        exchange_outer(n, data, spare);
        spare
            .par_chunks_mut(n * n)
            .for_each_init(|| Lines::new(fft, n), |lines, slab| lines.across(fft, slab));
        exchange_outer(n, spare, data);
    }
}

/// Room for the lines across one slab.
struct Lines {
    n: usize,
    turned: Vec<Complex32>,
    scratch: Vec<Complex32>,
}

impl Lines {
    fn new(fft: &dyn Fft<f32>, n: usize) -> Self {
        let zero = Complex32::default();
        Self { n, turned: vec![zero; n * n], scratch: vec![zero; fft.get_inplace_scratch_len()] }
    }

    /// Transforms the columns of an n×n slab.
    fn across(&mut self, fft: &dyn Fft<f32>, slab: &mut [Complex32]) {
        transpose(self.n, slab, &mut self.turned);
        fft.process_with_scratch(&mut self.turned, &mut self.scratch);
        transpose(self.n, &self.turned, slab);
    }
}

fn transpose(n: usize, from: &[Complex32], to: &mut [Complex32]) {
    const TILE: usize = 8;
    for row in (0..n).step_by(TILE) {
        for column in (0..n).step_by(TILE) {
            for i in row..(row + TILE).min(n) {
                for j in column..(column + TILE).min(n) {
                    to[j * n + i] = from[i * n + j];
                }
            }
        }
    }
}

/// Swaps the two slower axes.
fn exchange_outer(n: usize, from: &[Complex32], to: &mut [Complex32]) {
    to.par_chunks_mut(n * n).enumerate().for_each(|(outer, slab)| {
        for (inner, row) in slab.chunks_exact_mut(n).enumerate() {
            let at = (inner * n + outer) * n;
            row.copy_from_slice(&from[at..at + n]);
        }
    });
}

/// The signed wave number of position `i` of `n`.
pub(super) fn wave_number(i: usize, n: usize) -> i32 {
    if i <= n / 2 { i as i32 } else { i as i32 - n as i32 }
}

/// Evaluates Fourier coefficients on any other grid over the same period: zeros are added, or
/// frequencies that the grid cannot hold are dropped.
///
/// Lines along z are transformed for the coefficients that are there, then each slice by itself, so
/// that no padded cube is ever in memory.
pub(super) struct Resampler {
    n: usize,
    dims: [usize; 3],
    /// `[z][ky][kx]`: values along z, coefficients along the others.
    columns: Vec<Complex32>,
    along_x: Arc<dyn Fft<f32>>,
    along_y: Arc<dyn Fft<f32>>,
}

impl Resampler {
    pub fn new(coefficients: &[Complex32], n: usize, dims: [usize; 3]) -> Self {
        let mut planner = FftPlanner::new();
        let mut plan = |side| planner.plan_fft(side, FftDirection::Inverse);
        let [along_x, along_y, along_z] = dims.map(&mut plan);
        let mut lines = vec![Complex32::default(); n * n * dims[2]];
        lines.par_chunks_mut(dims[2]).enumerate().for_each(|(line, out)| {
            stop::point();
            place(n, out, |k| coefficients[k * n * n + line]);
            along_z.process(out);
        });
        let mut columns = vec![Complex32::default(); lines.len()];
        columns.par_chunks_mut(n * n).enumerate().for_each(|(z, slab)| {
            slab.iter_mut().enumerate().for_each(|(line, c)| *c = lines[line * dims[2] + z]);
        });
        Self { n, dims, columns, along_x, along_y }
    }

    /// The values of slice `z`, x fastest.
    pub fn slice(&self, z: usize) -> Vec<Complex32> {
        let (n, [nx, ny, _]) = (self.n, self.dims);
        let slab = &self.columns[z * n * n..(z + 1) * n * n];
        // [x][y] with coefficients along x: only n of them are there.
        let mut turned = vec![Complex32::default(); n * ny];
        for (kx, line) in turned.chunks_exact_mut(ny).enumerate() {
            place(n, line, |ky| slab[ky * n + kx]);
        }
        self.along_y.process(&mut turned);
        let mut slice = vec![Complex32::default(); nx * ny];
        for (y, row) in slice.chunks_exact_mut(nx).enumerate() {
            place(n, row, |kx| turned[kx * ny + y]);
        }
        self.along_x.process(&mut slice);
        slice
    }
}

/// Copies `n` coefficients to the places of the same wave numbers in `out`.
///
/// A line without a sine at its Nyquist frequency cannot hold a wave there: it is dropped, as are all
/// above it.
fn place(n: usize, out: &mut [Complex32], coefficient: impl Fn(usize) -> Complex32) {
    let side = out.len();
    for i in 0..n {
        let k = wave_number(i, n);
        if 2 * k.unsigned_abs() as usize >= n.min(side) {
            continue;
        }
        out[k.rem_euclid(side as i32) as usize] = coefficient(i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    fn wave(x: f32, y: f32, z: f32) -> f32 {
        (TAU * (2.0 * x + y)).sin() + 0.5 * (TAU * 3.0 * z).cos() + 0.25
    }

    fn sampled(dims: [usize; 3]) -> Vec<Complex32> {
        let [nx, ny, nz] = dims;
        let at = |i: usize, n: usize| i as f32 / n as f32;
        (0..nx * ny * nz)
            .map(|i| wave(at(i % nx, nx), at(i / nx % ny, ny), at(i / nx / ny, nz)).into())
            .collect()
    }

    fn transformed(n: usize) -> Vec<Complex32> {
        let mut data = sampled([n; 3]);
        let mut spare = data.clone();
        CubeTransform::new(n).forward(&mut data, &mut spare);
        data
    }

    #[test]
    fn coefficients_are_where_they_belong() {
        let n = 12;
        let data = transformed(n);
        let at = |x: usize, y: usize, z: usize| data[(z * n + y) * n + x];
        assert!((at(0, 0, 0) - Complex32::new(0.25, 0.0)).norm() < 1e-6);
        assert!((at(0, 0, 3) - Complex32::new(0.25, 0.0)).norm() < 1e-6);
        assert!((at(2, 1, 0) - Complex32::new(0.0, -0.5)).norm() < 1e-6);
        assert!((at(n - 2, n - 1, 0) - Complex32::new(0.0, 0.5)).norm() < 1e-6);
    }

    #[test]
    fn forward_and_inverse_are_inverse() {
        let original = sampled([12; 3]);
        let (mut data, mut spare) = (transformed(12), original.clone());
        CubeTransform::new(12).inverse(&mut data, &mut spare);
        assert!(data.iter().zip(&original).all(|(a, b)| (a - b).norm() < 1e-5));
    }

    #[test]
    fn resampling_is_exact_for_what_the_grid_can_hold() {
        for dims in [[12, 12, 12], [20, 33, 7], [48, 9, 16]] {
            let resampler = Resampler::new(&transformed(12), 12, dims);
            let expected = sampled(dims);
            for z in 0..dims[2] {
                let from = z * dims[0] * dims[1];
                for (a, b) in resampler.slice(z).iter().zip(&expected[from..]) {
                    assert!((a - b).norm() < 1e-5, "{dims:?} slice {z}: {a} {b}");
                }
            }
        }
    }
}
