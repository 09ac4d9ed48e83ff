use super::candidate::{Candidate, STEPS};
use super::running_error::RunningError;
use super::sizes::SizeErrors;
use super::way::Way;

/// Measured errors of candidates: mean squared errors of the pixels that can show the volume.
///
/// What makes a candidate differ from the exact frame has several independent causes, whose squared errors add up: its
/// light, its size, its step, its reconstruction. Each is measured apart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Errors {
    /// Cached light against shadow rays.
    pub light: RunningError,
    /// Smaller frames.
    pub sizes: SizeErrors,
    /// Longer steps, one for each of [`STEPS`] but the first.
    pub steps: [RunningError; STEPS.len() - 1],
    /// Reconstruction from sparse pixels at the asked density, by [`Way`], which is known only once it was shown.
    reconstruction: [RunningError; Way::ALL.len()],
}

/// Errors before any was measured.
const LIGHT: f64 = 2e-5;
const AT_STEPS: [f64; STEPS.len() - 1] = [1e-5, 3e-5, 3e-4];
/// Low enough that ratios are tried where cached light is poor, and no lower: frames that are tried are shown.
const RATIO: f64 = 2e-4;
const COLOURS: f64 = 4e-4;
/// Factor of the error with few shadow rays instead of all, measured on seven volumes (docs/measurements.md).
const FEW_RAYS: f64 = 1.12;
/// Power of the density by which the error of a reconstruction falls.
const DENSITY_POWER: f64 = 0.8;
/// Weight of errors that were measured before the scene changed.
const FADED: f64 = 0.3;
/// Smallest error that is told apart from none.
const NONE: f64 = 1e-9;

impl Errors {
    /// Expected error of `candidate`.
    pub fn of(&self, candidate: &Candidate) -> f64 {
        let made = match candidate.way {
            Way::ExactLight => 0.0,
            Way::CachedLight => self.light.mean().unwrap_or(LIGHT),
            way => self.reconstructed(way) / candidate.density.powf(DENSITY_POWER),
        };
        (made + self.sizes.at(candidate.scale) + self.at_step(candidate.step)).max(NONE)
    }

    /// Lets what was measured count little against what will be: the scene has changed.
    pub fn fade(&mut self) {
        let all = self.steps.iter_mut().chain(&mut self.reconstruction);
        all.chain([&mut self.light]).for_each(|error| error.add([], FADED));
    }

    /// Keeps the `error` that the reconstruction of `way` has at `density` times the asked density.
    pub fn remember(&mut self, way: Way, error: f64, density: f64) {
        let known = &mut self.reconstruction[way as usize];
        *known = RunningError::default();
        known.add([error.max(NONE) * density.powf(DENSITY_POWER)], 0.0);
    }

    fn reconstructed(&self, way: Way) -> f64 {
        let known = |way: Way| self.reconstruction[way as usize].mean();
        known(way).unwrap_or_else(|| match way {
            Way::Colours => COLOURS,
            Way::FewShadowRays => known(Way::LightRatio).unwrap_or(RATIO) * FEW_RAYS,
            _ => RATIO,
        })
    }

    fn at_step(&self, step: f64) -> f64 {
        match STEPS.iter().position(|known| *known == step) {
            Some(0) => 0.0,
            Some(i) => self.steps[i - 1].mean().unwrap_or(AT_STEPS[i - 1]),
            None => *AT_STEPS.last().unwrap(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cached(scale: f64, step: f64) -> Candidate {
        Candidate { way: Way::CachedLight, scale, step, density: 1.0 }
    }

    #[test]
    fn errors_grow_with_the_distance_from_the_exact_frame() {
        let mut errors = Errors::default();
        for known in [false, true] {
            if known {
                errors.light.add([1e-6], 0.0);
                errors.sizes.see(0.5, 3e-5, [1e-5, 4e-5, 9e-5]);
            }
            let scales: Vec<f64> =
                (1..=20).rev().map(|i| errors.of(&cached(f64::from(i) / 20.0, 1.0))).collect();
            assert!(scales.windows(2).all(|pair| pair[1] >= pair[0] * 0.999), "{scales:?}");
            assert!(errors.of(&cached(1.0, 2.0)) < errors.of(&cached(1.0, 4.0)));
        }
        assert!((errors.of(&cached(0.5, 1.0)) - 3.1e-5).abs() < 1e-7);
        assert!((errors.of(&cached(0.25, 1.0)) - 7.1e-5).abs() < 1e-7);
        assert_eq!(errors.of(&Candidate { way: Way::ExactLight, ..cached(1.0, 1.0) }), NONE);
    }

    #[test]
    fn fewer_samples_and_fewer_rays_are_worse() {
        let errors = Errors::default();
        let of = |way, density| errors.of(&Candidate { way, density, ..cached(1.0, 1.0) });
        assert!(of(Way::LightRatio, 0.5) > of(Way::LightRatio, 1.0));
        assert!(of(Way::FewShadowRays, 1.0) > of(Way::LightRatio, 1.0));
        assert!(of(Way::Colours, 1.0) > of(Way::FewShadowRays, 1.0));
    }
}
