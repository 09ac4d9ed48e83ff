use fovol_core::GradientOpacity;

/// Opacity by gradient as a table over the length of the gradient.
#[derive(Debug, Clone)]
pub struct GradientTable {
    /// Factors of the extinction, 0…1, at even steps of the length.
    pub factors: Vec<f32>,
    /// Factor from a length to an index, which the last index limits.
    pub scale: f32,
}

/// Steps of the length between 0 and where the factor stays the same.
const STEPS: usize = 2048;

impl GradientTable {
    /// Table of `curve` for gradients up to the length `greatest`.
    pub fn new(curve: &GradientOpacity, greatest: f64) -> Self {
        let range = curve.settles_at().min(greatest);
        if range <= 0.0 {
            return Self { factors: vec![curve.evaluate(0.0) as f32], scale: 0.0 };
        }
        let length = |i: usize| i as f64 / STEPS as f64 * range;
        let factors = (0..=STEPS).map(|i| curve.evaluate(length(i)) as f32).collect();
        Self { factors, scale: (STEPS as f64 / range) as f32 }
    }

    /// The last index.
    pub fn last(&self) -> f32 {
        (self.factors.len() - 1) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_the_curve_at_their_lengths() {
        let curve = GradientOpacity::new(vec![[0.01, 0.0], [0.04, 1.0], [0.5, 1.0]]).unwrap();
        let table = GradientTable::new(&curve, 0.866);
        for length in [0.0, 0.01, 0.013, 0.025, 0.0399, 0.04, 0.3, 0.866] {
            let index = (length as f32 * table.scale).min(table.last());
            let found = f64::from(table.factors[(index + 0.5) as usize]);
            assert!((found - curve.evaluate(length)).abs() < 0.5 / 1500.0, "{length}: {found}");
        }
        // A curve that goes on beyond all gradients.
        let far = GradientOpacity::new(vec![[0.0, 0.0], [1e300, 1.0]]).unwrap();
        assert!(GradientTable::new(&far, 0.866).scale > 1000.0);
        let constant = GradientTable::new(&GradientOpacity::new(vec![[0.0, 0.25]]).unwrap(), 0.866);
        assert_eq!((constant.factors, constant.scale), (vec![0.25], 0.0));
    }
}
