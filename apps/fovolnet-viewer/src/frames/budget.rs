//! Frame budget: adapts quality to the time of a frame.
//!
//! While the view moves, frames must keep the requested rate. Quality levels form a ladder, each cheaper and worse
//! than the one before. The best level whose predicted time fits is taken. Predictions use the measured milliseconds
//! per sample and, for reconstruction, per pixel.

use fovolnet::core::{FrameSize, ShadowMode};
use fovolnet::net::Fill;
use fovolnet::{Reconstruction, RenderSettings, Sampling, Timings, WeightsChoice};

/// Quality level, relative to the session's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QualityLevel {
    /// Factor of the resolution along each side.
    pub scale: f64,
    /// Whether the session's reconstruction is used; otherwise the cheapest fill.
    pub as_asked: bool,
    /// Factor of the base density; the fovea's width scales by its square root.
    pub density: f64,
    /// Factor of the step along rays.
    pub step: f64,
}

/// Levels from the session's full quality down to what an old laptop manages.
const LADDER: [QualityLevel; 14] = {
    const fn rung(scale: f64, as_asked: bool, density: f64, step: f64) -> QualityLevel {
        QualityLevel { scale, as_asked, density, step }
    }
    [
        rung(1.0, true, 1.0, 1.0),
        rung(1.0, true, 0.75, 1.0),
        rung(1.0, true, 0.75, 1.5),
        rung(0.75, true, 1.0, 1.0),
        rung(1.0, true, 0.6, 2.0),
        rung(0.75, true, 1.0, 1.5),
        rung(0.6, true, 1.0, 1.5),
        rung(0.5, true, 1.0, 1.5),
        rung(0.75, false, 1.0, 1.5),
        rung(0.6, false, 0.75, 1.5),
        rung(0.5, false, 0.75, 2.0),
        rung(0.4, false, 0.75, 2.0),
        rung(0.3, false, 0.75, 2.5),
        rung(0.25, false, 0.5, 3.0),
    ]
};

/// Level of the first frame, before anything was measured.
const START: usize = 3;

/// Hysteresis: a better level is taken if its predicted time is below this fraction of the budget.
const CLIMB: f64 = 0.8;
/// Weight of the last frame in moving averages.
const NEW: f64 = 0.35;
/// Decay per frame of the remembered cost of the reconstruction that is not in use.
const FORGET: f64 = 0.997;
/// Assumed cost of reconstruction before it was measured, in milliseconds per pixel: with a network and without.
const UNMEASURED: [f64; 2] = [1.5e-4, 1e-5];

/// Chooses the quality level of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    rung: usize,
    /// Whether a frame was made at this level. The first one takes longer because of allocations.
    is_warm: bool,
    /// Milliseconds per sample at the session's step.
    sample_ms: Option<f64>,
    /// Milliseconds per pixel of reconstruction: with the session's method and with the cheapest.
    pixel_ms: [Option<f64>; 2],
}

impl Default for Budget {
    fn default() -> Self {
        Self { rung: START, is_warm: false, sample_ms: None, pixel_ms: [None; 2] }
    }
}

impl Budget {
    /// Forgets all measurements, since another volume has other costs.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The current quality level.
    pub fn rung(&self) -> &'static QualityLevel {
        &LADDER[self.rung]
    }

    /// Updates the costs from a frame that was made with [`Self::settings`] of `asked`.
    pub fn learn(&mut self, asked: &RenderSettings, samples: usize, timings: &Timings) {
        let rung = *self.rung();
        let learn = |known: Option<f64>, new: f64| Some(known.map_or(new, |old| old + NEW * (new - old)));
        if samples > 0 {
            let ms = (timings.mask + timings.march) * step(asked, &rung) / samples as f64;
            self.sample_ms = learn(self.sample_ms, ms);
        }
        let kind = usize::from(!rung.as_asked);
        // The unused method may have become cheaper, for example because less of the volume is visible. Its
        // remembered cost decays so that it is tried again.
        self.pixel_ms[1 - kind] = self.pixel_ms[1 - kind].map(|ms| ms * FORGET);
        if !std::mem::replace(&mut self.is_warm, true) {
            return;
        }
        let pixels = scaled(asked.size, rung.scale).pixels() as f64;
        // Everything besides mask and march: reconstruction and the motion that it needs.
        let filling = (timings.total - timings.mask - timings.march).max(0.0);
        self.pixel_ms[kind] = learn(self.pixel_ms[kind], filling / pixels);
    }

    /// Takes the best level for frames of `ms` milliseconds.
    pub fn choose(&mut self, asked: &RenderSettings, ms: f64) {
        let before = self.rung;
        let fits = |rung: usize, share: f64| self.predicted(asked, &LADDER[rung]) <= ms * share;
        if fits(self.rung, 1.0) {
            if let Some(better) = (0..self.rung).find(|&rung| fits(rung, CLIMB)) {
                self.rung = better;
            }
        } else {
            self.rung = (self.rung..LADDER.len()).find(|&rung| fits(rung, 1.0)).unwrap_or(LADDER.len() - 1);
        }
        self.is_warm &= self.rung == before;
    }

    /// Settings of a frame at the current level, from the full-quality settings `asked`.
    pub fn settings(&self, asked: &RenderSettings) -> RenderSettings {
        applied(asked, self.rung())
    }

    /// Predicted milliseconds of a frame at the level `rung`.
    fn predicted(&self, asked: &RenderSettings, rung: &QualityLevel) -> f64 {
        let settings = applied(asked, rung);
        let size = settings.size;
        let fovea = settings.fovea(0).ok().filter(|_| settings.sampling != Sampling::Full);
        let density = fovea.map_or(1.0, |fovea| fovea.expected_density(size));
        let samples = density * size.pixels() as f64;
        let kind = usize::from(!rung.as_asked);
        let pixel_ms = self.pixel_ms[kind].unwrap_or(UNMEASURED[kind]);
        self.sample_ms.unwrap_or(0.0) * samples / step(asked, rung) + pixel_ms * size.pixels() as f64
    }
}

/// Factor of the step at the level `rung`. It is 1 with cached shadows: their grid is made for one step, and making
/// it again takes as long as many frames.
fn step(asked: &RenderSettings, rung: &QualityLevel) -> f64 {
    if asked.shadows == ShadowMode::Cached { 1.0 } else { rung.step }
}

/// Applies the level `rung` to the settings `asked`.
fn applied(asked: &RenderSettings, rung: &QualityLevel) -> RenderSettings {
    let mut settings = asked.clone();
    settings.size = scaled(asked.size, rung.scale);
    settings.pb = asked.pb * rung.density;
    settings.sigma = asked.sigma * rung.density.sqrt();
    settings.step = (asked.step * step(asked, rung)).min(100.0);
    if !rung.as_asked {
        settings.reconstruction = Reconstruction::Fill(Fill::PullPush);
        settings.weights = WeightsChoice::Usual;
    }
    settings
}

/// Scales `size` by `scale` along each side, to at least one pixel.
pub fn scaled(size: FrameSize, scale: f64) -> FrameSize {
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    FrameSize { width: side(size.width), height: side(size.height) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked() -> RenderSettings {
        RenderSettings { sampling: Sampling::Compact, ..RenderSettings::default() }
    }

    /// Frame of a machine that needs `sample` milliseconds per thousand samples, and `net` or `fill` milliseconds per
    /// million pixels.
    fn frame(settings: &RenderSettings, [sample, net, fill]: [f64; 3]) -> (usize, Timings) {
        let size = settings.size;
        let samples = settings.fovea(0).unwrap().expected_density(size) * size.pixels() as f64;
        let march = samples * sample * 1e-3 / (settings.step / 0.5);
        let per_pixel = if settings.reconstruction == Reconstruction::WNet { net } else { fill };
        let reconstruct = per_pixel * size.pixels() as f64 * 1e-6;
        (samples as usize, Timings { march, reconstruct, total: march + reconstruct, ..Timings::default() })
    }

    /// Total time of the last of many frames with a budget of `ms`, the number of level changes in the second half,
    /// and the level.
    fn settled(machine: [f64; 3], ms: f64) -> (f64, usize, QualityLevel) {
        let (mut budget, mut changes, mut total) = (Budget::default(), 0, 0.0);
        for i in 0..60 {
            let before = budget.rung;
            budget.choose(&asked(), ms);
            changes += usize::from(i >= 30 && before != budget.rung);
            let (samples, timings) = frame(&budget.settings(&asked()), machine);
            budget.learn(&asked(), samples, &timings);
            total = timings.total;
        }
        (total, changes, *budget.rung())
    }

    #[test]
    fn fast_machines_do_what_was_asked() {
        let (ms, _, rung) = settled([1e-4, 2.0, 1.0], 100.0);
        assert_eq!(rung, LADDER[0]);
        assert!(ms < 10.0);
    }

    #[test]
    fn slower_machines_keep_the_time_and_stay_where_they_are() {
        for machine in [[1.0, 200.0, 10.0], [3.0, 200.0, 10.0], [6.0, 900.0, 20.0]] {
            for ms in [125.0, 66.0] {
                let (took, changes, rung) = settled(machine, ms);
                assert!(took <= ms * 1.05, "{machine:?}: {took} of {ms} on {rung:?}");
                assert_eq!(changes, 0, "{machine:?} {ms}");
            }
        }
    }

    #[test]
    fn what_making_room_takes_is_no_reason_to_give_up() {
        let (mut budget, mut networks) = (Budget::default(), 0);
        for _ in 0..60 {
            let before = budget.rung;
            budget.choose(&asked(), 100.0);
            let (samples, mut timings) = frame(&budget.settings(&asked()), [0.5, 220.0, 10.0]);
            if before != budget.rung || !budget.is_warm {
                timings.reconstruct += 300.0;
                timings.total += 300.0;
            }
            budget.learn(&asked(), samples, &timings);
            networks += usize::from(budget.rung().as_asked);
        }
        assert!(networks == 60, "{networks} of 60 frames");
    }

    #[test]
    fn what_was_dear_is_tried_again() {
        let mut budget = Budget::default();
        let mut go = |network: f64, frames: usize| {
            for _ in 0..frames {
                budget.choose(&asked(), 100.0);
                let (samples, timings) = frame(&budget.settings(&asked()), [0.5, network, 10.0]);
                budget.learn(&asked(), samples, &timings);
            }
            budget.rung().as_asked
        };
        assert!(!go(2000.0, 30));
        assert!(go(100.0, 1500));
    }

    #[test]
    fn what_nothing_helps_gets_the_cheapest() {
        assert_eq!(settled([5000.0, 1e6, 1e6], 10.0).2, LADDER[LADDER.len() - 1]);
    }

    #[test]
    fn cached_shadows_stay_as_they_are() {
        let asked = RenderSettings { shadows: ShadowMode::Cached, ..asked() };
        assert!(LADDER.iter().all(|rung| applied(&asked, rung).step == 0.5));
    }

    #[test]
    fn every_rung_is_cheaper_than_the_first() {
        let machine = [1.0, 200.0, 10.0];
        let cost = |rung| frame(&applied(&asked(), rung), machine).1.total;
        assert!(LADDER[1..].iter().all(|rung| cost(rung) < cost(&LADDER[0])));
    }
}
