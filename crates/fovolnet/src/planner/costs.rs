use super::candidate::Candidate;
use super::way::{FEW, Way};
use crate::RenderSettings;
use fovol_core::{Fovea, FrameSize};
use fovol_render::cpu::march::SampleCount;

/// Costs of candidates: counted work times learned rates.
///
/// One unit of work is a sample of the volume along a primary ray.
#[derive(Debug, Clone, PartialEq)]
pub struct Costs {
    /// Samples of a ray that may meet the volume, with shadow rays and at the asked step.
    primary: f64,
    shadow: f64,
    /// Part of the frame's pixels that may meet it.
    share: f64,
    /// Milliseconds of a unit, by [`Way`], once a frame was made so.
    rates: [Option<f64>; Way::ALL.len()],
    /// Milliseconds of a unit of a small frame with every pixel, that was not shown.
    trial: Option<f64>,
    /// Milliseconds of a unit of exact rays, from scattered ones; `None` before any was timed.
    guess: Option<f64>,
}

// Measured on five volumes of 256³ with AVX2, where empty space is skipped; a unit takes 8 ns of two threads.
/// Work of a shadow sample.
const SHADOW: f64 = 1.1;
/// Work of a sample with cached light.
const CACHED: f64 = 1.7;
/// Work of a ray besides its samples.
const RAY: f64 = 5.0;
/// Work of a pixel of a frame, of one that is enlarged, and of one that is reconstructed.
const PIXEL: f64 = 1.0;
const ENLARGED: f64 = 1.2;
const RECONSTRUCTED: f64 = 7.0;
/// Factor of the work of sparse rays: they share less.
const SPARSE: f64 = 1.3;
/// Factor of the work of a few hundred scattered rays.
const SCATTERED: f64 = 2.0;
/// Part of the pixels that a guide marches.
const GUIDE: f64 = 0.25;
/// Weight of the last frame in moving averages.
const NEW: f64 = 0.35;
/// Largest factor of the rate of a frame that counts.
const MOST_GROWTH: f64 = 2.5;
/// Milliseconds of a unit before any was timed.
const RATE: f64 = 8e-6;

impl Default for Costs {
    fn default() -> Self {
        Self {
            primary: 150.0,
            shadow: 900.0,
            share: 0.5,
            rates: [None; Way::ALL.len()],
            trial: None,
            guess: None,
        }
    }
}

impl Costs {
    /// Takes the part of the pixels that may meet the volume, 0…1.
    pub fn see(&mut self, share: f64) {
        self.share = share;
    }

    /// Takes the `samples` of `rays` rays with shadow rays at the asked step.
    pub fn count(&mut self, samples: SampleCount, rays: usize) {
        if rays > 0 {
            let of = |samples: u64| samples as f64 / rays as f64;
            (self.primary, self.shadow) = (of(samples.primary).max(1.0), of(samples.shadow));
        }
    }

    /// Learns that the exact rays of `rays` scattered pixels took `ms` milliseconds.
    pub fn guess(&mut self, rays: usize, ms: f64) {
        let work = SCATTERED * rays as f64 * (RAY + self.primary + SHADOW * self.shadow);
        if work > 0.0 {
            let new = ms / work;
            self.guess = Some(self.guess.map_or(new, |old| old + NEW * (new - old)));
        }
    }

    /// Part of the pixels that may meet the volume, 0…1.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Work of a frame of `candidate`, as it is shown.
    pub fn work(&self, candidate: &Candidate, asked: &RenderSettings) -> f64 {
        let enlarged = if candidate.scale < 1.0 { ENLARGED * asked.size.pixels() as f64 } else { 0.0 };
        self.made(candidate, asked) + enlarged
    }

    /// Work of a frame of `candidate` at its own size.
    fn made(&self, candidate: &Candidate, asked: &RenderSettings) -> f64 {
        let pixels = candidate.size(asked.size).pixels() as f64;
        let seen = pixels * self.share;
        let primary = RAY + self.primary / candidate.step;
        // Shadow rays start at every sample, and take longer steps, too.
        let shadow = SHADOW * self.shadow / candidate.step.powi(2);
        let marched = match candidate.way {
            Way::ExactLight => seen * (primary + shadow),
            Way::CachedLight => seen * (RAY + CACHED * self.primary / candidate.step),
            Way::LightRatio | Way::Colours => SPARSE * density(candidate, asked) * seen * (primary + shadow),
            Way::FewShadowRays => {
                let shadow = shadow.min(f64::from(FEW) * shadow / self.primary);
                SPARSE * density(candidate, asked) * seen * (primary + shadow)
            }
        };
        let guide = match candidate.way {
            Way::LightRatio | Way::FewShadowRays => GUIDE * seen * primary,
            Way::ExactLight | Way::CachedLight | Way::Colours => 0.0,
        };
        let per_pixel = if candidate.way.is_full() { PIXEL } else { RECONSTRUCTED };
        marched + guide + per_pixel * pixels
    }

    /// Milliseconds that a frame of `candidate` will take.
    pub fn ms(&self, candidate: &Candidate, asked: &RenderSettings) -> f64 {
        self.work(candidate, asked) * self.rate(candidate.way)
    }

    /// Learns that a frame of `candidate` with every pixel, which is not shown, took `ms` milliseconds.
    pub fn try_out(&mut self, candidate: &Candidate, asked: &RenderSettings, ms: f64) {
        self.trial = Some(ms / self.made(candidate, asked));
    }

    /// Learns that a frame of `candidate` took `ms` milliseconds.
    pub fn learn(&mut self, candidate: &Candidate, asked: &RenderSettings, ms: f64) {
        let new = ms / self.work(candidate, asked);
        let rate = &mut self.rates[candidate.way as usize];
        // One frame that waited for other programs says little.
        *rate = Some(rate.map_or(new, |old| old + NEW * (new.min(MOST_GROWTH * old) - old)));
    }

    /// Rate of a way. That of a way that was not used follows from similar ways, or from exact rays of probes. Where a network takes
    /// long, rates of sparse frames say nothing of full ones.
    fn rate(&self, way: Way) -> f64 {
        let known = |is_full: bool| {
            let alike = Way::ALL.into_iter().filter(move |other| other.is_full() == is_full);
            let rates: Vec<f64> = alike.filter_map(|other| self.rates[other as usize]).collect();
            (!rates.is_empty()).then(|| rates.iter().sum::<f64>() / rates.len() as f64)
        };
        let sparse = || if way.is_full() { None } else { known(false) };
        let whole = || known(true).or(self.trial).or(self.guess);
        self.rates[way as usize].or_else(sparse).or_else(whole).unwrap_or(RATE)
    }
}

/// Expected part of the pixels that sparse frames of `candidate` march.
fn density(candidate: &Candidate, asked: &RenderSettings) -> f64 {
    let settings = candidate.settings(asked);
    let fovea = Fovea { base: settings.pb, sigma: settings.sigma, ..Fovea::default() };
    // It depends on the shape of the frame, hardly on its size.
    let FrameSize { width, height } = settings.size;
    let smaller = (width.max(height) / 128).max(1);
    fovea.expected_density(FrameSize { width: (width / smaller).max(1), height: (height / smaller).max(1) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(way: Way) -> Candidate {
        Candidate { way, scale: 1.0, step: 1.0, density: 1.0 }
    }

    #[test]
    fn work_falls_with_size_step_and_density() {
        let (costs, asked) = (Costs::default(), RenderSettings::default());
        let work = |candidate: Candidate| costs.work(&candidate, &asked);
        for way in Way::ALL {
            assert!(work(Candidate { scale: 0.5, ..full(way) }) < work(full(way)), "{way}");
            assert!(work(Candidate { step: 2.0, ..full(way) }) < work(full(way)), "{way}");
        }
        assert!(work(Candidate { density: 0.5, ..full(Way::LightRatio) }) < work(full(Way::LightRatio)));
        assert!(work(full(Way::FewShadowRays)) < work(full(Way::LightRatio)));
        assert!(work(full(Way::CachedLight)) < work(full(Way::ExactLight)));
    }

    #[test]
    fn a_slow_network_makes_no_full_frame_look_slow() {
        let (mut costs, asked) = (Costs::default(), RenderSettings::default());
        costs.guess(100, SCATTERED * 100.0 * (RAY + 150.0 + SHADOW * 900.0) * RATE);
        let before = costs.ms(&full(Way::ExactLight), &asked);
        costs.learn(&full(Way::LightRatio), &asked, 1e4);
        assert_eq!(costs.ms(&full(Way::ExactLight), &asked), before);
        assert!(costs.ms(&full(Way::FewShadowRays), &asked) > before);
    }

    #[test]
    fn rates_follow_the_clock() {
        let (mut costs, asked) = (Costs::default(), RenderSettings::default());
        for _ in 0..20 {
            costs.learn(&full(Way::CachedLight), &asked, 80.0);
        }
        assert!((costs.ms(&full(Way::CachedLight), &asked) - 80.0).abs() < 1e-9);
        let exact = costs.ms(&full(Way::ExactLight), &asked);
        assert!(exact > 80.0, "{exact}");
        let count = SampleCount { primary: 100, shadow: 0 };
        costs.count(count, 10);
        costs.see(0.25);
        assert!(costs.ms(&full(Way::ExactLight), &asked) < exact && costs.share() == 0.25);
    }
}
