use crate::{FrameSize, Result};
use serde::{Deserialize, Serialize};

/// Gaze and density function of foveated sampling.
///
/// Pixel (x, y) is sampled with the probability τ = (1 − P_b)·P_f + P_b with P_f = exp(−½·r²/σ²). r is the distance
/// of the pixel centre from the gaze in image widths (Bauer et al. 2022, Eq. 1, with σ a standard deviation in image
/// widths). σ = 0 means no fovea: τ = P_b everywhere. See docs/guide/src/internals/algorithm.md, section 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fovea {
    /// Base density P_b, 0…1.
    pub base: f64,
    /// Standard deviation σ of the fovea in image widths, 0 or more.
    pub sigma: f64,
    /// Gaze as fractions (x, y) of the image, from its top left.
    pub gaze: [f64; 2],
}

impl Default for Fovea {
    /// The paper's faster setting: P_b = 0.03, σ = 0.02, gaze in the centre.
    fn default() -> Self {
        Self { base: 0.03, sigma: 0.02, gaze: [0.5, 0.5] }
    }
}

impl Fovea {
    /// Checks that the parameters are valid.
    ///
    /// # Errors
    /// P_b outside [0, 1], σ negative, or anything not finite.
    pub fn check(&self) -> Result<()> {
        crate::checked(
            "base density (--pb)",
            self.base,
            "a number between 0 and 1",
            (0.0..=1.0).contains(&self.base),
        )?;
        crate::checked(
            "fovea width (--sigma)",
            self.sigma,
            "0 or a positive number of image widths",
            self.sigma >= 0.0,
        )?;
        for g in self.gaze {
            crate::checked("gaze", g, "a fraction of the image, 0 to 1 inside it", true)?;
        }
        Ok(())
    }

    /// Density τ at the centre of pixel (`x`, `y`).
    pub fn density_at(&self, x: u32, y: u32, size: FrameSize) -> f64 {
        self.base + (1.0 - self.base) * self.falloff_x(x, size) * self.falloff_y(y, size)
    }

    /// Column factor of P_f: exp(−½·dx²/σ²), dx in image widths.
    pub fn falloff_x(&self, x: u32, size: FrameSize) -> f64 {
        let width = f64::from(size.width);
        self.falloff((f64::from(x) + 0.5 - self.gaze[0] * width) / width)
    }

    /// Row factor of P_f: exp(−½·dy²/σ²), dy in image **widths**.
    pub fn falloff_y(&self, y: u32, size: FrameSize) -> f64 {
        let (width, height) = (f64::from(size.width), f64::from(size.height));
        self.falloff((f64::from(y) + 0.5 - self.gaze[1] * height) / width)
    }

    fn falloff(&self, distance: f64) -> f64 {
        if self.sigma == 0.0 { 0.0 } else { (-0.5 * (distance / self.sigma).powi(2)).exp() }
    }

    /// Expected density of a frame: the mean of τ.
    pub fn expected_density(&self, size: FrameSize) -> f64 {
        // P_f is separable, so its sum over the frame is a product of two sums.
        let columns: f64 = (0..size.width).map(|x| self.falloff_x(x, size)).sum();
        let rows: f64 = (0..size.height).map(|y| self.falloff_y(y, size)).sum();
        self.base + (1.0 - self.base) * columns * rows / size.pixels() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_papers_two_settings_have_their_densities() {
        let size = FrameSize::default();
        let density = |base, sigma| Fovea { base, sigma, ..Fovea::default() }.expected_density(size);
        assert!((density(0.03, 0.02) - 0.0343).abs() < 5e-5);
        assert!((density(0.07, 0.06) - 0.1074).abs() < 5e-5);
        assert_eq!(density(0.05, 0.0), 0.05);
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        for fovea in [
            Fovea { base: f64::NAN, ..Fovea::default() },
            Fovea { base: 1.1, ..Fovea::default() },
            Fovea { sigma: -0.1, ..Fovea::default() },
            Fovea { gaze: [0.5, f64::INFINITY], ..Fovea::default() },
        ] {
            assert!(fovea.check().is_err());
        }
    }

    proptest! {
        #[test]
        fn expected_density_is_the_mean_of_tau(
            w in 1u32..40, h in 1u32..40, base in 0.0f64..1.0, sigma in 0.0f64..0.5,
            gx in 0.0f64..1.0, gy in 0.0f64..1.0,
        ) {
            let size = FrameSize::new(w, h).unwrap();
            let fovea = Fovea { base, sigma, gaze: [gx, gy] };
            let sum: f64 = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)))
                .map(|(x, y)| fovea.density_at(x, y, size)).sum();
            prop_assert!((sum / size.pixels() as f64 - fovea.expected_density(size)).abs() < 1e-12);
        }
    }
}
