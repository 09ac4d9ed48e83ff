use super::candidate::Candidate;
use super::way::Way;
use fovol_core::FrameSize;
use serde::{Deserialize, Serialize};

/// How a frame was made, why, and with what error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FramePlan {
    /// How the pixels were made.
    pub way: Way,
    /// Size of the frame before it was enlarged.
    pub size: FrameSize,
    /// Step along rays, in voxels.
    pub step: f64,
    /// Factor of the base density.
    #[serde(skip_serializing_if = "is_one")]
    pub density: f64,
    /// Milliseconds that were expected, with a budget in milliseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted_ms: Option<f64>,
    /// PSNR against the exact frame in dB, measured at probe pixels of this frame and the ones before; `None` where it
    /// cannot be measured.
    pub psnr: Option<f64>,
    /// Bounds between which that PSNR lies with 95 % confidence.
    pub psnr_range: Option<[f64; 2]>,
    /// Reason of the choice.
    pub why: String,
}

/// Consecutive frames that were made alike, in a session.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PlannedFrames {
    /// Number of the first one.
    pub first_frame: u32,
    /// How many they are.
    pub frames: u32,
    /// How their pixels are made.
    pub way: Way,
    /// Factor of the resolution along each side.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Factor of the step along rays.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub step: f64,
    /// Factor of the base density.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub density: f64,
}

fn one() -> f64 {
    1.0
}

fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

impl PlannedFrames {
    /// Candidate of frame `number`, if it is one of these.
    pub fn candidate(&self, number: u32) -> Option<Candidate> {
        let Self { way, scale, step, density, .. } = *self;
        let is_here = number.checked_sub(self.first_frame).is_some_and(|at| at < self.frames);
        is_here.then_some(Candidate { way, scale, step, density })
    }

    /// Adds frame number `frame` of `candidate` to `all`.
    pub fn push(all: &mut Vec<Self>, frame: u32, candidate: Candidate) {
        let Candidate { way, scale, step, density } = candidate;
        let alike = |last: &&mut Self| {
            last.first_frame + last.frames == frame && last.candidate(last.first_frame) == Some(candidate)
        };
        match all.last_mut().filter(alike) {
            Some(last) => last.frames += 1,
            None => all.push(Self { first_frame: frame, frames: 1, way, scale, step, density }),
        }
    }

    /// Checks that sizes, steps and densities are factors that frames can have.
    pub fn is_valid(&self) -> bool {
        let is_part = |factor: f64| factor > 0.0 && factor <= 1.0;
        is_part(self.scale) && is_part(self.density) && (1.0..=100.0).contains(&self.step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_are_made_alike_stand_together() {
        let cached = Candidate { way: Way::CachedLight, scale: 0.5, step: 1.0, density: 1.0 };
        let exact = Candidate { way: Way::ExactLight, ..cached };
        let mut all = Vec::new();
        for (frame, candidate) in [(3, cached), (4, cached), (5, exact), (9, exact)] {
            PlannedFrames::push(&mut all, frame, candidate);
        }
        assert_eq!(
            all.iter().map(|part| (part.first_frame, part.frames)).collect::<Vec<_>>(),
            [(3, 2), (5, 1), (9, 1)]
        );
        let found = |frame| all.iter().find_map(|part| part.candidate(frame));
        assert_eq!([3, 4, 5, 9].map(found), [cached, cached, exact, exact].map(Some));
        assert_eq!([2, 6].map(found), [None, None]);
        let text = toml::to_string(&all[0]).unwrap();
        assert_eq!(text, "first-frame = 3\nframes = 2\nway = \"cached light\"\nscale = 0.5\n");
        assert_eq!(toml::from_str::<PlannedFrames>(&text).unwrap(), all[0]);
    }
}
