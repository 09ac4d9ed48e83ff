//! How strongly two positions repel each other, in units of 2⁻²².
//!
//! The tables are written out, not computed: whole numbers make the ranks the same on every machine,
//! whatever its exponential function rounds to.

/// The last distance at which positions repel each other, where the Gaussian has fallen to 0.005:
/// ⌊√(−2σ² ln 0.005)⌋.
pub(super) const RADIUS: usize = 6;

/// Between pixels of one frame, \[dy + 6\]\[dx + 6\]: k(dx)·k(dy)/S².
pub(super) const SPACE: [[u64; 2 * RADIUS + 1]; 2 * RADIUS + 1] = mirrored(&QUADRANT);

/// Between frames of one pixel, by their distance: k(dt)/S.
pub(super) const TIME: [u64; RADIUS + 1] =
    [2_230_998, 1_942_440, 1_282_014, 641_409, 243_262, 69_937, 15_242];

/// [`SPACE`] by distances. k(d) = exp(−½·d²/σ²), σ = 1.9, S = Σ k(d) over d = 1…6.
const QUADRANT: [[u64; RADIUS + 1]; RADIUS + 1] = [
    [1_186_693, 1_033_206, 681_918, 341_173, 129_394, 37_200, 8_107],
    [1_033_206, 899_571, 593_718, 297_045, 112_658, 32_389, 7_059],
    [681_918, 593_718, 391_855, 196_050, 74_354, 21_377, 4_659],
    [341_173, 297_045, 196_050, 98_087, 37_200, 10_695, 2_331],
    [129_394, 112_658, 74_354, 37_200, 14_109, 4_056, 884],
    [37_200, 32_389, 21_377, 10_695, 4_056, 1_166, 254],
    [8_107, 7_059, 4_659, 2_331, 884, 254, 55],
];

const fn mirrored(quadrant: &[[u64; RADIUS + 1]; RADIUS + 1]) -> [[u64; 2 * RADIUS + 1]; 2 * RADIUS + 1] {
    let mut whole = [[0; 2 * RADIUS + 1]; 2 * RADIUS + 1];
    let mut y = 0;
    while y <= 2 * RADIUS {
        let mut x = 0;
        while x <= 2 * RADIUS {
            whole[y][x] = quadrant[y.abs_diff(RADIUS)][x.abs_diff(RADIUS)];
            x += 1;
        }
        y += 1;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_formula() {
        const SIGMA: f64 = 1.9;
        let gauss = |d: usize| (-((d * d) as f64) / (2.0 * SIGMA * SIGMA)).exp();
        let sum: f64 = (1..=RADIUS).map(gauss).sum();
        let fixed = |weight: f64| (weight * f64::from(1 << 22)).round() as u64;
        for dy in 0..=RADIUS {
            assert_eq!(TIME[dy], fixed(gauss(dy) / sum));
            for dx in 0..=RADIUS {
                let weight = fixed(gauss(dx) * gauss(dy) / (sum * sum));
                assert_eq!(SPACE[RADIUS + dy][RADIUS - dx], weight);
                assert_eq!(SPACE[RADIUS - dy][RADIUS + dx], weight);
            }
        }
        assert_eq!(RADIUS as f64, (-2.0 * SIGMA * SIGMA * 0.005f64.ln()).sqrt().floor());
    }
}
