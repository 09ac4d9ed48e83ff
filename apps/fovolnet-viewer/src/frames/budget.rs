//! Frame budget: adapts quality to the time of a frame.
//!
//! While the view moves, frames must keep the requested rate. Quality levels form a ladder, from good to bad. The best level
//! whose predicted time fits is taken. Predictions use the measured milliseconds per sample and, for reconstruction, per
//! pixel.

use fovolnet::core::{FrameSize, ShadowMode};
use fovolnet::{Choice, Reconstruction, RenderSettings, Sampling, ShadowRays, Timings, WeightsChoice};

/// How the frames of a quality level are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// With the session's sampling, reconstruction and shadows.
    AsAsked,
    /// Every pixel, with cached shadows instead of shadow rays.
    CachedLight,
}

/// Quality level, relative to the session's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QualityLevel {
    /// How the frames are made.
    pub way: Way,
    /// Factor of the resolution along each side.
    pub scale: f64,
    /// Factor of the base density; the fovea's width scales by its square root.
    pub density: f64,
    /// Factor of the step along rays.
    pub step: f64,
}

/// Levels from the best to what an old laptop manages. Measured on four volumes, whole frames with cached light at half the
/// size have 31 to 51 dB, and reconstructed ones at full size 26 to 45.
const LADDER: [QualityLevel; 20] = {
    const fn asked(scale: f64, density: f64, step: f64) -> QualityLevel {
        QualityLevel { way: Way::AsAsked, scale, density, step }
    }
    const fn cached(scale: f64, step: f64) -> QualityLevel {
        QualityLevel { way: Way::CachedLight, scale, density: 1.0, step }
    }
    [
        cached(1.0, 1.0),
        cached(0.85, 1.0),
        cached(0.75, 1.0),
        cached(0.65, 1.0),
        cached(0.55, 1.0),
        asked(1.0, 1.0, 1.0),
        asked(1.0, 0.75, 1.0),
        cached(0.45, 1.0),
        asked(1.0, 0.75, 1.5),
        asked(0.75, 1.0, 1.0),
        asked(1.0, 0.6, 2.0),
        cached(0.37, 1.0),
        asked(0.75, 1.0, 1.5),
        asked(0.6, 1.0, 1.5),
        asked(0.5, 1.0, 1.5),
        cached(0.3, 1.0),
        cached(0.25, 1.0),
        cached(0.25, 2.0),
        cached(0.2, 2.0),
        cached(0.15, 3.0),
    ]
};

/// First level that is open to every session: slower machines have nothing else.
const LAST_RESORT: usize = 15;
/// Levels of the first frame, before anything was measured: of free sessions, and of others.
const START: [usize; 2] = [4, 9];

/// Fraction of the budget that a predicted time may take: views change, and the next frame may take longer.
const HOLD: f64 = 0.84;
/// Hysteresis: a better level is taken if its predicted time is below this fraction of the budget.
const CLIMB: f64 = 0.7;
/// Weight of the last frame in moving averages.
const NEW: f64 = 0.35;
/// Decay per frame of the remembered costs of the way that is not in use.
const FORGET: f64 = 0.997;
/// Assumed cost of reconstruction before it was measured, in milliseconds per pixel: as asked, and of whole frames.
const UNMEASURED: [f64; 2] = [1.5e-4, 1e-5];
/// Assumed cost of a sample with cached light, as a part of that of a sample with a shadow ray.
const CACHED_SHARE: f64 = 0.2;

/// Measured costs of a [`Way`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Costs {
    /// Milliseconds per sample at the session's step.
    sample_ms: Option<f64>,
    /// Milliseconds per pixel of reconstruction.
    pixel_ms: Option<f64>,
    /// Milliseconds that changes of the scene take before a frame.
    change_ms: f64,
}

/// Chooses the quality level of frames.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Budget {
    /// Current level; `None` before the first choice.
    rung: Option<usize>,
    /// Whether a frame was made at this level. The first one takes longer because of allocations.
    is_warm: bool,
    /// Costs of frames as asked, and with cached light.
    costs: [Costs; 2],
}

/// Moving average of a cost whose last value is `new`.
fn learned(known: Option<f64>, new: f64) -> Option<f64> {
    Some(known.map_or(new, |old| old + NEW * (new - old)))
}

/// Whether a session leaves it to the budget how its frames in motion are made: none of its sampling, reconstruction, weights,
/// guide and shadow rays is chosen.
pub fn is_free(asked: &RenderSettings) -> bool {
    asked.sampling == Sampling::Compact
        && asked.reconstruction == Reconstruction::WNet
        && asked.weights == WeightsChoice::Usual
        && asked.guide == Choice::Auto
        && asked.density == Choice::Auto
        && asked.shadow_rays == ShadowRays::Exact
}

impl Budget {
    /// Forgets all measurements, since another volume has other costs.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The current quality level.
    pub fn rung(&self) -> &'static QualityLevel {
        &LADDER[self.rung.unwrap_or(START[1])]
    }

    /// Updates the costs from a frame that was made with [`Self::settings`] of `asked`, after a change of the scene that took
    /// `change_ms`.
    pub fn learn(&mut self, asked: &RenderSettings, samples: usize, timings: &Timings, change_ms: f64) {
        let rung = *self.rung();
        let kind = rung.way as usize;
        // The unused way may have become cheaper, for example because less of the volume is visible. Its remembered costs decay
        // so that it is tried again.
        let other = &mut self.costs[1 - kind];
        other.pixel_ms = other.pixel_ms.map(|ms| ms * FORGET);
        other.sample_ms = other.sample_ms.map(|ms| ms * FORGET);
        other.change_ms *= FORGET;
        let costs = &mut self.costs[kind];
        if samples > 0 {
            let ms = (timings.mask + timings.march) * step(asked, &rung) / samples as f64;
            costs.sample_ms = learned(costs.sample_ms, ms);
        }
        if !std::mem::replace(&mut self.is_warm, true) {
            return;
        }
        costs.change_ms += NEW * (change_ms - costs.change_ms);
        let pixels = scaled(asked.size, rung.scale).pixels() as f64;
        // Everything besides mask and march: reconstruction and the motion that it needs.
        let filling = (timings.total - timings.mask - timings.march).max(0.0);
        costs.pixel_ms = learned(costs.pixel_ms, filling / pixels);
    }

    /// Takes the best level for frames of `ms` milliseconds. Frames are made in any way if `is_free`; else as asked where that
    /// is possible in the time.
    pub fn choose(&mut self, asked: &RenderSettings, ms: f64, is_free: bool) {
        let is_open = |rung: usize| is_free || rung >= LAST_RESORT || LADDER[rung].way == Way::AsAsked;
        let fits =
            |rung: usize, share: f64| is_open(rung) && self.predicted(asked, &LADDER[rung]) <= ms * share;
        let before = self.rung;
        let now = before.filter(|rung| is_open(*rung)).unwrap_or(START[usize::from(!is_free)]);
        let chosen = if before.is_none() {
            now
        } else if fits(now, HOLD) {
            (0..now).find(|&rung| fits(rung, CLIMB)).unwrap_or(now)
        } else {
            (now..LADDER.len()).find(|&rung| fits(rung, HOLD)).unwrap_or(LADDER.len() - 1)
        };
        self.rung = Some(chosen);
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
        let kind = rung.way as usize;
        let pixel_ms = self.costs[kind].pixel_ms.unwrap_or(UNMEASURED[kind]);
        self.sample_ms(kind) * samples / step(asked, rung)
            + pixel_ms * size.pixels() as f64
            + self.costs[kind].change_ms
    }

    /// Milliseconds of a sample, or what they probably are.
    fn sample_ms(&self, kind: usize) -> f64 {
        let [asked, cached] = self.costs.map(|costs| costs.sample_ms);
        let guessed = [cached.map(|ms| ms / CACHED_SHARE), asked.map(|ms| ms * CACHED_SHARE)];
        [asked, cached][kind].or(guessed[kind]).unwrap_or(0.0)
    }
}

/// Factor of the step at the level `rung`. It is 1 where a session has cached shadows: their grid is made for one step.
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
    if rung.way == Way::CachedLight {
        settings.sampling = Sampling::Full;
        settings.shadow_rays = ShadowRays::Exact;
        if asked.shadows == ShadowMode::On {
            settings.shadows = ShadowMode::Cached;
        }
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

    /// Frame of a machine that needs `sample` milliseconds per thousand samples with a shadow ray, a tenth of that with cached
    /// light, and `net` or `fill` milliseconds per million pixels.
    fn frame(settings: &RenderSettings, [sample, net, fill]: [f64; 3]) -> (usize, Timings) {
        let size = settings.size;
        let samples = settings.fovea(0).unwrap().expected_density(size) * size.pixels() as f64;
        let is_whole = settings.sampling == Sampling::Full;
        let samples = if is_whole { size.pixels() as f64 } else { samples };
        let march = samples * sample * 1e-3 / (settings.step / 0.5) * if is_whole { 0.1 } else { 1.0 };
        let per_pixel = if is_whole { fill } else { net };
        let reconstruct = per_pixel * size.pixels() as f64 * 1e-6;
        (samples as usize, Timings { march, reconstruct, total: march + reconstruct, ..Timings::default() })
    }

    /// Total time of the last of many frames with a budget of `ms`, the number of level changes in the second half,
    /// and the level.
    fn settled(machine: [f64; 3], ms: f64, is_free: bool) -> (f64, usize, QualityLevel) {
        let (mut budget, mut changes, mut total) = (Budget::default(), 0, 0.0);
        for i in 0..60 {
            let before = budget.rung;
            budget.choose(&asked(), ms, is_free);
            changes += usize::from(i >= 30 && before != budget.rung);
            let (samples, timings) = frame(&budget.settings(&asked()), machine);
            budget.learn(&asked(), samples, &timings, 0.0);
            total = timings.total;
        }
        (total, changes, *budget.rung())
    }

    #[test]
    fn fast_machines_make_the_best_frames() {
        for (is_free, best) in [(true, 0), (false, 5)] {
            let (ms, _, rung) = settled([1e-4, 2.0, 1.0], 100.0, is_free);
            assert_eq!(rung, LADDER[best]);
            assert!(ms < 10.0);
        }
    }

    #[test]
    fn slower_machines_keep_the_time_and_stay_where_they_are() {
        for machine in [[1.0, 200.0, 10.0], [3.0, 200.0, 10.0], [6.0, 900.0, 20.0]] {
            for ms in [125.0, 66.0] {
                for is_free in [true, false] {
                    let (took, changes, rung) = settled(machine, ms, is_free);
                    assert!(took <= ms * 1.05, "{machine:?}: {took} of {ms} on {rung:?}");
                    assert_eq!(changes, 0, "{machine:?} {ms}");
                    assert!(!is_free || rung.way == Way::CachedLight);
                }
            }
        }
    }

    #[test]
    fn scenes_that_change_all_the_time_get_what_they_leave() {
        let mut budget = Budget::default();
        let mut total = 0.0;
        for _ in 0..60 {
            budget.choose(&asked(), 100.0, true);
            let (samples, timings) = frame(&budget.settings(&asked()), [1.0, 200.0, 10.0]);
            let change_ms = if budget.rung().way == Way::CachedLight { 60.0 } else { 2.0 };
            budget.learn(&asked(), samples, &timings, change_ms);
            total = timings.total + change_ms;
        }
        assert!(total <= 105.0, "{total} on {:?}", budget.rung());
    }

    #[test]
    fn what_making_room_takes_is_no_reason_to_give_up() {
        let (mut budget, mut networks) = (Budget::default(), 0);
        for _ in 0..60 {
            let before = budget.rung;
            budget.choose(&asked(), 100.0, false);
            let (samples, mut timings) = frame(&budget.settings(&asked()), [0.5, 220.0, 10.0]);
            if before != budget.rung || !budget.is_warm {
                timings.reconstruct += 300.0;
                timings.total += 300.0;
            }
            budget.learn(&asked(), samples, &timings, 0.0);
            networks += usize::from(budget.rung().way == Way::AsAsked);
        }
        assert!(networks == 60, "{networks} of 60 frames");
    }

    #[test]
    fn what_was_dear_is_tried_again() {
        let mut budget = Budget::default();
        let mut go = |network: f64, frames: usize| {
            for _ in 0..frames {
                budget.choose(&asked(), 100.0, false);
                let (samples, timings) = frame(&budget.settings(&asked()), [0.5, network, 10.0]);
                budget.learn(&asked(), samples, &timings, 0.0);
            }
            budget.rung().way == Way::AsAsked
        };
        assert!(!go(2000.0, 30));
        assert!(go(100.0, 1500));
    }

    #[test]
    fn what_nothing_helps_gets_the_cheapest() {
        assert_eq!(settled([5000.0, 1e6, 1e6], 10.0, true).2, LADDER[LADDER.len() - 1]);
        assert_eq!(settled([5000.0, 1e6, 1e6], 10.0, false).2, LADDER[LADDER.len() - 1]);
    }

    #[test]
    fn cached_shadows_stay_as_they_are() {
        let asked = RenderSettings { shadows: ShadowMode::Cached, ..asked() };
        assert!(LADDER.iter().all(|rung| applied(&asked, rung).step == 0.5));
    }

    #[test]
    fn levels_of_one_way_become_cheaper() {
        let cost = |rung| frame(&applied(&asked(), rung), [1.0, 200.0, 10.0]).1.total;
        for way in [Way::AsAsked, Way::CachedLight] {
            let rungs: Vec<f64> = LADDER.iter().filter(|rung| rung.way == way).map(cost).collect();
            assert!(
                rungs[1..].iter().all(|rung| *rung < rungs[0]) && rungs[0] > 3.0 * rungs[rungs.len() - 1]
            );
        }
        assert!(LADDER[LAST_RESORT..].iter().all(|rung| rung.way == Way::CachedLight));
        assert_eq!(START.map(|rung| LADDER[rung].way), [Way::CachedLight, Way::AsAsked]);
    }

    #[test]
    fn what_is_chosen_is_kept() {
        assert!(is_free(&asked()));
        let others = [
            RenderSettings { guide: fovolnet::Guide::Quarter.into(), ..asked() },
            RenderSettings { reconstruction: Reconstruction::DeepFovea, ..asked() },
            RenderSettings { sampling: Sampling::Direct, ..asked() },
            RenderSettings { shadow_rays: "8".parse().unwrap(), ..asked() },
        ];
        assert!(others.iter().all(|other| !is_free(other)));
        let (dark, cached) = (RenderSettings { shadows: ShadowMode::Off, ..asked() }, asked());
        assert_eq!(applied(&dark, &LADDER[0]).shadows, ShadowMode::Off);
        assert_eq!(applied(&cached, &LADDER[0]).shadows, ShadowMode::Cached);
    }
}
