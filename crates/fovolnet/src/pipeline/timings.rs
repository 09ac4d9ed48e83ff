use serde::Serialize;
use std::time::Instant;

/// Times of the stages of a frame in milliseconds; 0 for stages that did not run or were not timed apart. Reports hold
/// mask, march, guide, reconstruct, total, and plan where a planner was asked; [`Timings::finer`] splits them further.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Timings {
    /// Mask and compaction, or drawing random positions.
    pub mask: f64,
    /// Compaction of the mask to a list of pixels; part of `mask`.
    #[serde(skip)]
    pub compact: f64,
    /// Marching, and its results in a sparse frame.
    pub march: f64,
    /// Marching of the guide and its interpolation.
    pub guide: f64,
    /// Ray results to the sparse frame; part of `march`.
    #[serde(skip)]
    pub scatter: f64,
    /// Motion and filling.
    pub reconstruct: f64,
    /// Estimation of motion; part of `reconstruct`.
    #[serde(skip)]
    pub motion: f64,
    /// Measurements of a planner.
    #[serde(skip_serializing_if = "is_zero")]
    pub plan: f64,
    /// Whole frame.
    pub total: f64,
}

impl Timings {
    /// Applies `reduce`, such as a mean or a median, to each stage over `all`.
    pub fn reduced(all: &[Self], reduce: impl Fn(&mut [f64]) -> f64) -> Self {
        let part = |of: fn(&Self) -> f64| reduce(&mut all.iter().map(of).collect::<Vec<_>>());
        Self {
            mask: part(|t| t.mask),
            compact: part(|t| t.compact),
            march: part(|t| t.march),
            guide: part(|t| t.guide),
            scatter: part(|t| t.scatter),
            reconstruct: part(|t| t.reconstruct),
            motion: part(|t| t.motion),
            plan: part(|t| t.plan),
            total: part(|t| t.total),
        }
    }

    /// Adds `ms` milliseconds for the grid of cached shadows to the march and the total.
    #[must_use]
    pub fn with_shadow_grid(self, ms: f64) -> Self {
        Self { march: self.march + ms, total: self.total + ms, ..self }
    }

    /// Names and times of all stages. Their sum is the total without the gaps between stages.
    pub fn finer(&self) -> [(&'static str, f64); 7] {
        [
            ("mask", self.mask - self.compact),
            ("compact", self.compact),
            ("march", self.march - self.scatter),
            ("scatter", self.scatter),
            ("guide", self.guide),
            ("motion", self.motion),
            ("fill", self.reconstruct - self.motion),
        ]
    }
}

fn is_zero(ms: &f64) -> bool {
    *ms == 0.0
}

/// Stopwatch.
pub struct Timer(Instant);

impl Timer {
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    pub fn ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}
