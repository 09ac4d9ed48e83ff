//! Orthogonalised update steps of Muon (Jordan et al. 2024): all singular directions of a weight matrix move equally
//! far.
//!
//! Many input channels of a layer are often nearly equal. The useful information lies in their small differences,
//! where gradients are small.

use tch::Tensor;

/// Newton-Schulz iterations; five bring singular values to between 0.7 and 1.2.
const ITERATIONS: u32 = 5;
/// Coefficients of x, x³ and x⁵ chosen by Jordan et al.
const QUINTIC: [f64; 3] = [3.4445, -4.7750, 2.0315];
/// Keeps the quotient finite.
const EPSILON: f64 = 1e-7;
/// Root mean square of a step, similar to Adam's in practice (Liu et al. 2025).
const SIZE: f64 = 0.2;

/// Orthogonalises `direction`, the weights of a convolution \[out, in, rows, columns\]. The singular values of the
/// matrix \[out, in · rows · columns\] become nearly equal, and the entries' root mean square becomes 0.2.
pub(super) fn orthogonal(direction: &Tensor) -> Tensor {
    let size = direction.size();
    let matrix = direction.reshape([size[0], -1]);
    let [rows, columns] = [matrix.size()[0], matrix.size()[1]];
    let is_tall = rows > columns;
    let wide = if is_tall { matrix.tr() } else { matrix };
    let mut x = &wide / (wide.norm() + EPSILON);
    let [a, b, c] = QUINTIC;
    for _ in 0..ITERATIONS {
        let square = x.matmul(&x.tr());
        let polynomial = &square * b + square.matmul(&square) * c;
        x = &x * a + polynomial.matmul(&x);
    }
    let x = if is_tall { x.tr() } else { x };
    (x * (SIZE * (rows.max(columns) as f64).sqrt())).reshape(&size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tch::{Device, Kind};

    #[test]
    fn all_directions_become_equally_long() {
        tch::manual_seed(7);
        for shape in [[16, 31, 3, 3], [48, 2, 3, 3], [1, 5, 3, 3], [9, 4, 3, 3]] {
            // Some directions are a thousand times shorter than others.
            let spread = Tensor::logspace(-3.0, 0.0, shape[0], 10.0, (Kind::Float, Device::Cpu));
            let direction = Tensor::randn(shape, (Kind::Float, Device::Cpu)) * spread.view([-1, 1, 1, 1]);
            let found = orthogonal(&direction);
            assert_eq!(found.size(), shape);
            let matrix = found.reshape([shape[0], -1]);
            let [rows, columns] = [matrix.size()[0], matrix.size()[1]];
            let (_, lengths, _) = matrix.svd(true, true);
            let lengths = lengths / (SIZE * (rows.max(columns) as f64).sqrt());
            let (least, most) = (lengths.min().double_value(&[]), lengths.max().double_value(&[]));
            assert!(least > 0.3 && most < 1.25, "{shape:?}: {least} to {most}");
        }
    }

    #[test]
    fn nothing_stays_nothing() {
        let found = orthogonal(&Tensor::zeros([4, 3, 3, 3], (Kind::Float, Device::Cpu)));
        assert_eq!(found.abs().max().double_value(&[]), 0.0);
    }
}
