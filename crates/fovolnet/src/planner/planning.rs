use super::candidate::Candidate;
use super::costs::Costs;
use super::errors::Errors;
use super::frame_plan::FramePlan;
use super::freedom::Freedom;
use super::limit::Limit;
use super::probes::{Probes, Shown};
use super::running_error::psnr_of_part;
use super::shown_error::ShownError;
use super::survey::Survey;
use super::way::Way;
use crate::{Pipeline, RenderSettings, Result, Viewpoint};
use fovol_core::ShadowMode;
use std::time::Instant;

/// Costs of a frame that was made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MadeFrame {
    /// Milliseconds of the frame, without changes of the scene.
    pub ms: f64,
    /// Milliseconds that changes of the scene took before it.
    pub change_ms: f64,
    /// Milliseconds of its probes.
    pub probe_ms: f64,
    /// Whether light, transfer function or clip are not those of the frame before.
    pub scene_changed: bool,
}

/// Chooses how frames are made.
///
/// For every frame: [`Self::choose`], then make the frame with [`Self::settings`], then [`Self::learn`] and [`Self::measure`].
#[derive(Debug, Clone)]
pub struct Planner {
    errors: Errors,
    costs: Costs,
    chosen: Option<Chosen>,
    /// Error of frames like the last one.
    shown: ShownError,
    /// Part of the frames that follow a change of the scene, 0…1.
    change_rate: f64,
    /// Milliseconds of a change of the scene, without cached shadows to make, and of those.
    change_ms: f64,
    grid_ms: f64,
    /// Probe pixels of the next frame, and milliseconds that each takes with its substitutes.
    probes: usize,
    pixel_ms: f64,
    /// Milliseconds that all measurements take.
    probe_ms: f64,
}

/// Candidate with its expected error and cost.
#[derive(Debug, Clone, Copy)]
struct Rated {
    candidate: Candidate,
    error: f64,
    cost: f64,
}

#[derive(Debug, Clone)]
struct Chosen {
    candidate: Candidate,
    /// Frames since the choice.
    frames: u32,
    predicted_ms: Option<f64>,
    why: String,
}

/// Probe pixels of a frame, and bounds of their number within a budget.
const PROBES: usize = 1024;
const FIRST_PROBES: usize = 256;
const FEWEST_PROBES: usize = 32;
const MOST_PROBES: usize = 1024;
/// Time of probes that are compared, in that of probes that are not.
const COMPARED: f64 = 2.0;
/// Part of a budget that probes may take.
const PROBING: f64 = 0.08;
/// Frames after a choice that have a survey; later every eighth has one.
const SURVEYED: [u32; 4] = [0, 1, 2, 4];
const SURVEYED_LATER: u32 = 8;
/// Part of a budget that a frame is expected to take at most: the next view may take longer.
const HOLD: f64 = 0.9;
/// Part of a budget that a better way is expected to take at most.
const CLIMB: f64 = 0.8;
/// Factor of the error below which another way is better: half a decibel.
const BETTER: f64 = 0.89;
/// Frames from one measurement of cached light to the next, where frames do not have it.
const LIGHT_MEASURED: u32 = 32;
/// Frames for which a way is kept, unless it takes too long: reconstructions settle in that time.
const KEPT: u32 = 8;
/// Part of a budget below which a way is not kept if another one is better.
const UNUSED: f64 = 0.5;
/// Weight of the last frame in moving averages.
const NEW: f64 = 0.35;
/// Part of the frames after changes of the scene below which it rests.
const RESTS: f64 = 0.05;
/// Milliseconds of cached shadows before they were made.
const UNKNOWN_GRID_MS: f64 = 50.0;

impl Default for Planner {
    fn default() -> Self {
        Self::new()
    }
}

impl Planner {
    /// Planner that knows nothing yet.
    pub fn new() -> Self {
        Self {
            errors: Errors::default(),
            costs: Costs::default(),
            chosen: None,
            shown: ShownError::default(),
            change_rate: 0.0,
            change_ms: 0.0,
            grid_ms: UNKNOWN_GRID_MS,
            probes: FIRST_PROBES,
            pixel_ms: 0.0,
            probe_ms: 0.0,
        }
    }

    /// The current choice.
    pub fn candidate(&self) -> Option<Candidate> {
        self.chosen.as_ref().map(|chosen| chosen.candidate)
    }

    /// Settings of the next frame, from those that are `asked`.
    pub fn settings(&self, asked: &RenderSettings) -> RenderSettings {
        self.candidate().map_or_else(|| asked.clone(), |candidate| candidate.settings(asked))
    }

    /// Chooses how the next frame is made.
    pub fn choose(&mut self, asked: &RenderSettings, freedom: Freedom, limit: Limit) {
        self.limit_probes(limit);
        let (budget, holds, climbs) = match limit {
            Limit::Time(ms) => ((ms - self.probe_ms).max(0.0), HOLD, CLIMB),
            Limit::Work => (self.costs.work(&Candidate::of(asked), asked), 1.0, 1.0),
        };
        let rated = |candidate: Candidate| Rated {
            candidate,
            error: self.errors.of(&candidate),
            cost: match limit {
                Limit::Time(_) => self.costs.ms(&candidate, asked) + self.expected_change(candidate.way),
                Limit::Work => self.costs.work(&candidate, asked),
            },
        };
        let all: Vec<Rated> = Candidate::all(asked, freedom).into_iter().map(rated).collect();
        let fitting = |part: f64| all.iter().filter(move |rated| rated.cost <= budget * part);
        let best = |part: f64| fitting(part).min_by(|a, b| a.error.total_cmp(&b.error));
        let now = self.candidate().and_then(|now| all.iter().find(|rated| rated.candidate == now));
        let frames = self.chosen.as_ref().map_or(0, |chosen| chosen.frames);
        let stays = now.filter(|now| {
            let may_change = frames >= KEPT || (frames > 1 && now.cost < UNUSED * budget);
            let is_better = |best: &&Rated| best.error < BETTER * now.error && may_change;
            now.cost <= budget && best(climbs).is_none_or(|best| !is_better(&best))
        });
        let best = stays.or_else(|| best(if now.is_some() { climbs } else { holds }));
        let why = match best {
            Some(best) => reason(best.candidate.way, fitting(holds).count(), limit),
            None => "nothing fits the budget; this is the cheapest".to_owned(),
        };
        let cheapest = || all.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Rated { candidate, cost, .. } = *best.or_else(cheapest).expect("every setting has candidates");
        let predicted_ms = matches!(limit, Limit::Time(_)).then_some(cost);
        self.take(candidate, predicted_ms, why);
    }

    /// Takes as many probes as a small part of the budget allows.
    fn limit_probes(&mut self, limit: Limit) {
        self.probes = match limit {
            Limit::Time(ms) if self.pixel_ms > 0.0 => {
                let fitting = PROBING * ms / self.pixel_ms;
                (fitting as usize).clamp(FEWEST_PROBES, MOST_PROBES)
            }
            Limit::Time(_) => FIRST_PROBES,
            Limit::Work => PROBES,
        };
    }

    /// Takes `candidate` for the next frame, as a saved plan says.
    pub fn follow(&mut self, candidate: Candidate) {
        self.take(candidate, None, "as the session says".to_owned());
    }

    fn take(&mut self, candidate: Candidate, predicted_ms: Option<f64>, why: String) {
        let same = self.chosen.as_ref().filter(|chosen| chosen.candidate == candidate);
        let frames = same.map_or(0, |chosen| chosen.frames) + 1;
        if frames == 1 {
            self.shown = ShownError::default();
        }
        self.chosen = Some(Chosen { candidate, frames, predicted_ms, why });
    }

    /// Milliseconds that a frame is expected to wait for changes of the scene.
    fn expected_change(&self, way: Way) -> f64 {
        let grid_ms = if way == Way::CachedLight { self.grid_ms } else { 0.0 };
        self.change_rate * (self.change_ms + grid_ms)
    }

    /// Learns what the last frame cost.
    pub fn learn(&mut self, asked: &RenderSettings, made: MadeFrame) {
        let Some(Chosen { candidate, frames, .. }) = self.chosen else { return };
        self.probe_ms += NEW * (made.probe_ms - self.probe_ms);
        let changed = f64::from(u8::from(made.scene_changed));
        self.change_rate += NEW * (changed - self.change_rate);
        if made.scene_changed {
            let grid_ms = if candidate.way == Way::CachedLight { self.grid_ms } else { 0.0 };
            self.change_ms += NEW * ((made.change_ms - grid_ms).max(0.0) - self.change_ms);
            self.shown = ShownError::default();
            self.errors.fade();
        }
        // The first frame makes room for what the next ones use again.
        if frames > 1 {
            self.costs.learn(&candidate, asked, made.ms);
        }
    }

    /// Measures errors at probe pixels of frame `number` from `viewpoint`: of the frame that is `shown`, and of other
    /// candidates in turn.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn measure(
        &mut self,
        (pipeline, viewpoint, asked): (&mut Pipeline, &Viewpoint, &RenderSettings),
        number: u32,
        shown: Option<Shown<'_>>,
        may_be_cached: bool,
    ) -> Result<()> {
        let probed = (pipeline, viewpoint, asked);
        let started = Instant::now();
        let Some(mut probes) = Probes::new(probed, (number, self.probes, shown), &mut self.costs)? else {
            return Ok(());
        };
        let rests = self.change_rate < RESTS;
        let is_cached = self.candidate().is_some_and(|candidate| candidate.way == Way::CachedLight);
        // Where the scene changes, cached light may have to be made for a measurement alone.
        let light_is_cached = is_cached && rests;
        if let Some(shown) = shown {
            probes.compare(shown, light_is_cached, (&mut self.shown, &mut self.errors))?;
        }
        if let Some(ms) = probes.cached_shadows_ms() {
            self.grid_ms = ms;
        }
        let compared = if shown.is_some() { 1.0 } else { COMPARED };
        let pixel_ms = compared * started.elapsed().as_secs_f64() * 1e3 / self.probes as f64;
        self.pixel_ms += if self.pixel_ms > 0.0 { NEW } else { 1.0 } * (pixel_ms - self.pixel_ms);
        let frames = self.chosen.as_ref().map_or(0, |chosen| chosen.frames);
        if SURVEYED.contains(&frames) || frames.is_multiple_of(SURVEYED_LATER) {
            if may_be_cached && !light_is_cached && frames.is_multiple_of(LIGHT_MEASURED) {
                probes.measure_light(&mut self.errors)?;
            }
            // Longer steps are wrong by their shadow rays most of all.
            let shadows = if is_cached || (may_be_cached && rests) {
                ShadowMode::Cached
            } else {
                probes.exact_shadows()
            };
            let region = probes.region();
            let mut survey = Survey::new(&mut probes, shadows)?;
            survey.measure_steps(&mut self.errors);
            match shown.zip(self.candidate()) {
                Some(shown) => survey.measure_sizes(shown, self.shown.mean(), &mut self.errors),
                None => survey.measure_sizes_anew(region, (&mut self.errors, &mut self.costs))?,
            }
        }
        self.remember_reconstruction();
        Ok(())
    }

    /// Keeps the error of a reconstruction that is shown.
    fn remember_reconstruction(&mut self) {
        let Some(Candidate { way, scale, step, density }) = self.candidate() else { return };
        if way.is_full() {
            return;
        }
        let whole = Candidate { way: Way::ExactLight, scale, step, density };
        if let Some(error) = self.shown.mean() {
            self.errors.remember(way, error - self.errors.of(&whole), density);
        }
    }

    /// How the last frame was made, and with what error.
    pub fn plan(&self, asked: &RenderSettings) -> Option<FramePlan> {
        let Chosen { candidate, predicted_ms, why, .. } = self.chosen.clone()?;
        let share = self.costs.share();
        let known = self.shown.with_confidence();
        let psnr = |mse: f64| psnr_of_part(mse, share);
        Some(FramePlan {
            way: candidate.way,
            size: candidate.size(asked.size),
            step: asked.step * candidate.step,
            density: candidate.density,
            predicted_ms,
            psnr: known.map(|[mean, ..]| psnr(mean)),
            psnr_range: known.map(|[_, least, most]| [psnr(most), psnr(least)]),
            why,
        })
    }
}

/// Why `way` was chosen among `count` candidates.
fn reason(way: Way, count: usize, limit: Limit) -> String {
    match limit {
        Limit::Time(ms) => format!("least error of {count} that fit {ms} ms: {way}"),
        Limit::Work => format!("least error of {count} with no more work than the settings: {way}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    fn asked() -> RenderSettings {
        RenderSettings { size: FrameSize::new(640, 360).unwrap(), ..RenderSettings::default() }
    }

    /// Milliseconds of frames on a machine that does `rate` times the expected work a millisecond.
    fn took(planner: &Planner, rate: f64) -> f64 {
        Costs::default().work(&planner.candidate().unwrap(), &asked()) * rate
    }

    /// The candidates of `frames` frames within `limit` on a machine of `rate`.
    fn planned(limit: Limit, rate: f64, freedom: Freedom, frames: usize) -> Vec<Candidate> {
        let mut planner = Planner::new();
        let one = |_| {
            planner.choose(&asked(), freedom, limit);
            let ms = took(&planner, rate);
            planner.learn(&asked(), MadeFrame { ms, ..MadeFrame::default() });
            planner.candidate().unwrap()
        };
        (0..frames).map(one).collect()
    }

    #[test]
    fn budgets_are_kept_and_choices_rest() {
        for rate in [1e-6, 4e-6, 2e-5] {
            for ms in [20.0, 80.0, 300.0] {
                let all = planned(Limit::Time(ms), rate, Freedom::ALL, 60);
                let last = all[59];
                let took = Costs::default().work(&last, &asked()) * rate;
                assert!(took <= ms, "{last:?} takes {took} of {ms}");
                assert!(all[30..].iter().all(|candidate| *candidate == last), "{rate} {ms}: {all:?}");
            }
        }
    }

    #[test]
    fn more_time_makes_better_frames() {
        let error =
            |ms| Errors::default().of(planned(Limit::Time(ms), 4e-6, Freedom::ALL, 40).last().unwrap());
        let errors: Vec<f64> = [5.0, 20.0, 80.0, 300.0, 30000.0].map(error).into();
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
        let exact = *planned(Limit::Time(30000.0), 4e-6, Freedom::ALL, 40).last().unwrap();
        assert_eq!(exact, Candidate::of(&asked()));
    }

    #[test]
    fn without_a_budget_the_work_of_the_settings_is_the_limit() {
        let exact = planned(Limit::Work, 1e-6, Freedom::ALL, 3);
        assert_eq!(exact, [Candidate::of(&asked()); 3]);
        let kept = Freedom { pixels: false, ..Freedom::ALL };
        assert_eq!(planned(Limit::Work, 1e-6, kept, 3), exact);
    }

    #[test]
    fn what_nothing_helps_gets_the_cheapest() {
        let last = *planned(Limit::Time(1.0), 1.0, Freedom::ALL, 9).last().unwrap();
        let work = |candidate: &Candidate| Costs::default().work(candidate, &asked());
        let all = Candidate::all(&asked(), Freedom::ALL);
        assert!(all.iter().all(|other| work(other) >= work(&last)));
    }

    #[test]
    fn changes_of_the_scene_count() {
        let mut planner = Planner::new();
        let mut total = 0.0;
        for _ in 0..40 {
            planner.choose(&asked(), Freedom::ALL, Limit::Time(100.0));
            let change_ms = if planner.candidate().unwrap().way == Way::CachedLight { 60.0 } else { 2.0 };
            let ms = took(&planner, 4e-6);
            planner.learn(&asked(), MadeFrame { ms, change_ms, scene_changed: true, ..MadeFrame::default() });
            total = ms + change_ms;
        }
        assert!(total <= 100.0, "{total} by {:?}", planner.candidate());
    }

    #[test]
    fn saved_plans_are_followed() {
        let mut planner = Planner::new();
        let saved = Candidate { way: Way::CachedLight, scale: 0.5, step: 2.0, density: 1.0 };
        planner.follow(saved);
        assert_eq!(planner.settings(&asked()).size.to_string(), "320x180");
        let plan = planner.plan(&asked()).unwrap();
        assert_eq!((plan.step, plan.psnr, plan.why.as_str()), (1.0, None, "as the session says"));
    }
}
