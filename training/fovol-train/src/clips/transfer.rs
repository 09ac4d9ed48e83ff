//! Random transfer functions.

use fovol_core::{ControlPoint, TransferFunction};
use rand::{Rng, RngExt};

/// Bins of the histogram.
const BINS: usize = 256;

/// Random transfer function for values of `histogram`: a few opacity bumps near frequent values, in changing colours.
/// One in five has many narrow bumps, one in five is faint throughout.
pub(super) fn random_transfer(
    random: &mut impl Rng,
    histogram: &[u64],
) -> fovol_core::Result<TransferFunction> {
    let mut unit = || random.random::<f64>();
    let kind = unit();
    let bumps = if kind < 0.2 { 6 + (unit() * 10.0) as usize } else { 1 + (unit() * 3.0) as usize };
    let faint = (0.2..0.4).contains(&kind);
    let cumulative = equalised(histogram);
    let mut heights = [0.0f64; BINS + 1];
    for _ in 0..bumps {
        // Half of the bumps follow the value frequencies and half are uniform, because rare values matter too.
        let place = unit();
        let common = cumulative.partition_point(|&share| share < place) as f64 / BINS as f64;
        let centre = if unit() < 0.5 { common } else { unit() };
        let width = if bumps > 4 { 0.004 + 0.02 * unit() } else { 0.02 + 0.25 * unit().powi(2) };
        let height = if faint { 0.01 + 0.06 * unit() } else { 0.02 + 0.9 * unit().powi(2) };
        let rises = unit() < 0.3;
        for (i, to) in heights.iter_mut().enumerate() {
            let away = (i as f64 / BINS as f64 - centre) / width;
            let bump = if rises && away > 0.0 { 1.0 } else { (1.0 - away.abs()).max(0.0) };
            *to = to.max(height * bump);
        }
    }
    // Low values are mostly air. They become transparent unless nothing else is visible.
    let clear = (unit() * 0.15 * BINS as f64) as usize;
    if heights[clear..].iter().any(|&height| height > 0.01) {
        heights[..clear].fill(0.0);
    }
    let hues = [unit(), unit(), unit(), unit()];
    let saturation = 0.9 * unit();
    let points = (0..=BINS).map(|i| {
        let v = i as f64 / BINS as f64;
        ControlPoint::new(v, colour(v, hues, saturation), heights[i])
    });
    TransferFunction::new(points.collect())
}

/// Cumulative distribution of the histogram, per bin.
fn equalised(histogram: &[u64]) -> Vec<f64> {
    // The most frequent bin is mostly air and would attract all bumps.
    let most = histogram.iter().copied().max().unwrap_or(0);
    let counts: Vec<u64> = histogram.iter().map(|&count| if count == most { 0 } else { count }).collect();
    let total = counts.iter().sum::<u64>().max(1) as f64;
    let mut below = 0.0;
    counts
        .iter()
        .map(|&count| {
            below += count as f64 / total;
            below
        })
        .collect()
}

/// Colour that runs through four hues as `v` goes from 0 to 1, bright enough to be visible.
fn colour(v: f64, hues: [f64; 4], saturation: f64) -> [f64; 3] {
    let at = v * 2.999;
    let (part, along) = (at as usize, at.fract());
    let hue = hues[part] + (hues[part + 1] - hues[part]) * along;
    let light = 0.55 + 0.45 * v;
    std::array::from_fn(|c| {
        let wave = 0.5 + 0.5 * (std::f64::consts::TAU * (hue + c as f64 / 3.0)).cos();
        light * (1.0 - saturation * (1.0 - wave))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn every_one_shows_something() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut histogram = vec![3; BINS];
        histogram[0] = 10_000;
        for _ in 0..200 {
            let transfer = random_transfer(&mut random, &histogram).unwrap();
            assert!(transfer.max_opacity(0.0, 1.0) > 0.005);
            assert!(transfer.points().iter().all(|p| p.colour.iter().all(|c| (0.0..=1.0).contains(c))));
        }
    }
}
