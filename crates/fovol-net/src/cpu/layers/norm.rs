use crate::cpu::conv::elu;
use crate::cpu::tensor::Tensor;
use crate::plan::Activation;
use rayon::prelude::*;

/// ε that is added to the variance.
const EPSILON: f64 = 1e-5;

/// Normalises `map` in place over all channels and pixels, then applies an affine map to each channel and
/// `activation`.
pub fn normalise(map: &mut Tensor, weight: &[f32], bias: &[f32], activation: Activation) {
    let row = map.width * map.channels;
    // Sums are added in a fixed order, so that the result does not depend on the number of threads.
    let sums: Vec<[f64; 2]> = map
        .data
        .par_chunks(row)
        .map(|row| {
            row.iter().fold([0.0, 0.0], |[sum, squares], &v| {
                let v = f64::from(v);
                [sum + v, squares + v * v]
            })
        })
        .collect();
    let [sum, squares] = sums.iter().fold([0.0, 0.0], |[a, b], [c, d]| [a + c, b + d]);
    let count = map.data.len() as f64;
    let mean = sum / count;
    let scale = 1.0 / ((squares / count - mean * mean).max(0.0) + EPSILON).sqrt();
    let affine: Vec<(f32, f32)> = weight
        .iter()
        .zip(bias)
        .map(|(&w, &b)| {
            let factor = f64::from(w) * scale;
            (factor as f32, (f64::from(b) - mean * factor) as f32)
        })
        .collect();
    map.data.par_chunks_mut(row).for_each(|row| {
        for pixel in row.chunks_exact_mut(affine.len()) {
            for (v, &(factor, offset)) in pixel.iter_mut().zip(&affine) {
                let x = v.mul_add(factor, offset);
                *v = match activation {
                    Activation::None => x,
                    Activation::Relu => x.max(0.0),
                    Activation::Elu => elu(x),
                };
            }
        }
    });
}
