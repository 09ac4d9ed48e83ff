use super::seeded::lattice;

/// The noise of a scanner: standard normal at each voxel (nearly: a sum of eight uniform numbers),
/// correlated with its neighbours as the reconstruction of a scan leaves it.
#[derive(Clone, Copy)]
pub(super) struct Grain {
    seed: u32,
}

impl Grain {
    pub fn new(seed: u64) -> Self {
        Self { seed: (seed ^ (seed >> 32)) as u32 }
    }

    /// The noise of voxel `index`: mean 0, variance 1.
    pub fn at(self, index: [usize; 3]) -> f32 {
        let [x, y, z] = index.map(|i| i as i32);
        let mut sum = 0.0;
        for corner in 0..8 {
            let hash = lattice(self.seed, [x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)]);
            sum += hash as f32 * (2.0 / u32::MAX as f32) - 1.0;
        }
        // Each of the eight has the variance 1/3.
        sum * (3.0f32 / 8.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_0_and_variance_1() {
        let grain = Grain::new(5);
        let values: Vec<f32> =
            (0..30_000).map(|i| grain.at([i * 2 % 60, i * 2 / 60 * 2 % 200, i / 3000 * 2])).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32;
        assert!(mean.abs() < 0.05 && (variance - 1.0).abs() < 0.1, "{mean} {variance}");
    }
}
