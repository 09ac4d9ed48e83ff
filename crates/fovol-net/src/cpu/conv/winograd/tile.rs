//! Transforms of one tile along one axis (Toom and Cook's way to Winograd's algorithms). They evaluate polynomials
//! at the points 0, ±11/16, ±3/2 and ∞, and interpolate.
//!
//! Usual points are 0, ±1, ±2 and ∞. Of the fractions that are exact in f32, the chosen ones keep bf16 rounding
//! noise lowest: 3.5 dB below the usual ones on layers of the trained networks. This is still 3 to 4 dB above tiles
//! of 2×2.
use fovol_simd::Pixels;

/// Outputs of a tile along an axis.
pub const SIDE: usize = 4;
/// Inputs of a tile along an axis, and products.
pub const REACH: usize = SIDE + 2;
/// Number of products of a tile.
pub const PLACES: usize = REACH * REACH;

/// Magnitudes of the finite points other than 0.
const A: f32 = 11.0 / 16.0;
const B: f32 = 3.0 / 2.0;
const A2: f32 = A * A;
const B2: f32 = B * B;

/// Input transform Bᵀd.
#[inline(always)]
pub fn inputs<V: Pixels>(d: [V; REACH]) -> [V; REACH] {
    let some = d[0];
    let (a, minus_a, b, minus_b) = (some.splat(A), some.splat(-A), some.splat(B), some.splat(-B));
    let (minus_a2, minus_b2) = (some.splat(-A2), some.splat(-B2));
    let (sum, product) = (some.splat(-A2 - B2), some.splat(A2 * B2));
    let (even_a, odd_a) = (d[2].mul_add(minus_b2, d[4]), d[1].mul_add(minus_b2, d[3]));
    let (even_b, odd_b) = (d[2].mul_add(minus_a2, d[4]), d[1].mul_add(minus_a2, d[3]));
    [
        d[0].mul_add(product, d[2].mul_add(sum, d[4])),
        odd_a.mul_add(a, even_a),
        odd_a.mul_add(minus_a, even_a),
        odd_b.mul_add(b, even_b),
        odd_b.mul_add(minus_b, even_b),
        d[1].mul_add(product, d[3].mul_add(sum, d[5])),
    ]
}

/// Output transform Aᵀm.
#[inline(always)]
pub fn outputs<V: Pixels>(m: [V; REACH]) -> [V; SIDE] {
    let some = m[0];
    let (a, b, a2, b2) = (some.splat(A), some.splat(B), some.splat(A2), some.splat(B2));
    let (a3, b3) = (some.splat(A2 * A), some.splat(B2 * B));
    let (even_a, odd_a) = (m[1] + m[2], m[1] - m[2]);
    let (even_b, odd_b) = (m[3] + m[4], m[3] - m[4]);
    [
        m[0] + even_a + even_b,
        odd_a.mul_add(a, odd_b * b),
        even_a.mul_add(a2, even_b * b2),
        odd_a.mul_add(a3, odd_b.mul_add(b3, m[5])),
    ]
}

/// Weight transform GgGᵀ of a 3×3 kernel, row by row.
pub fn weights(kernel: &[f32]) -> [f32; PLACES] {
    let (a, b) = (f64::from(A), f64::from(B));
    let points = [0.0, a, -a, b, -b];
    let row = |place: usize| {
        let Some(&point) = points.get(place) else { return [0.0, 0.0, 1.0] };
        let others = points.iter().filter(|&&other| other != point);
        let scale: f64 = others.map(|other| point - other).product();
        [1.0 / scale, point / scale, point * point / scale]
    };
    let rows: [[f64; 3]; REACH] = std::array::from_fn(row);
    std::array::from_fn(|place| {
        let (down, along) = (rows[place / REACH], rows[place % REACH]);
        let mut sum = 0.0;
        for (y, down) in down.iter().enumerate() {
            for (x, along) in along.iter().enumerate() {
                sum += down * along * f64::from(kernel[3 * y + x]);
            }
        }
        sum as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    #[test]
    fn three_weights_slide_over_six_numbers() {
        let numbers: [f32; REACH] = [0.3, -1.2, 0.7, 2.0, -0.4, 0.9];
        let kernel = [0.5f32, -0.25, 1.5];
        // Only the middle row of the kernel has weights, which leaves a convolution along one axis.
        let along: Vec<f32> = (0..9).map(|at| if at / 3 == 1 { kernel[at % 3] } else { 0.0 }).collect();
        let transformed = weights(&along);
        let rows: [[f32; REACH]; REACH] = std::array::from_fn(|y| {
            let d = numbers.map(|v| if y == 1 { v } else { 0.1 * y as f32 });
            inputs(d.map(Vec4::splat)).map(|v| v.x)
        });
        let products: Vec<f32> = (0..PLACES)
            .map(|place| {
                let column: [Vec4; REACH] = std::array::from_fn(|y| Vec4::splat(rows[y][place % REACH]));
                inputs(column)[place / REACH].x * transformed[place]
            })
            .collect();
        let down: [[f32; SIDE]; REACH] = std::array::from_fn(|x| {
            let column: [Vec4; REACH] = std::array::from_fn(|y| Vec4::splat(products[y * REACH + x]));
            outputs(column).map(|v| v.x)
        });
        let first = outputs(std::array::from_fn::<_, REACH, _>(|x| Vec4::splat(down[x][0])));
        for (x, found) in first.into_iter().enumerate() {
            let expected: f32 = (0..3).map(|k| kernel[k] * numbers[x + k]).sum();
            assert!((found.x - expected).abs() < 1e-5, "{x}: {} and {expected}", found.x);
        }
    }
}
