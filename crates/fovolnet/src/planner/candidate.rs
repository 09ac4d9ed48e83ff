use super::freedom::{Freedom, sparse};
use super::way::{FEW, Way};
use crate::{RenderSettings, Sampling, ShadowRays};
use fovol_core::{FrameSize, ShadowMode};
use std::num::NonZero;

/// One way to make frames, with the size, step and density that it is made at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// How the pixels are made.
    pub way: Way,
    /// Factor of the resolution along each side, at most 1. Smaller frames are enlarged.
    pub scale: f64,
    /// Factor of the step along rays, at least 1.
    pub step: f64,
    /// Factor of the base density, at most 1; the fovea's width scales by its square root. 1 where every pixel is marched.
    pub density: f64,
}

/// Sizes of frames with every pixel marched.
const SCALES: [f64; 13] = [1.0, 0.9, 0.85, 0.75, 0.7, 0.6, 0.5, 0.42, 0.3333, 0.25, 0.2, 0.15, 0.1];
/// Sizes of frames that are reconstructed.
const RECONSTRUCTED_SCALES: [f64; 4] = [1.0, 0.75, 0.6, 0.5];
/// Factors of the step along rays.
pub const STEPS: [f64; 4] = [1.0, 1.5, 2.0, 4.0];
/// Factors of the density.
const DENSITIES: [f64; 2] = [1.0, 0.6];
/// Largest step that a scene may have.
const MOST_STEP: f64 = 100.0;

impl Candidate {
    /// Frames as `settings` say.
    pub fn of(settings: &RenderSettings) -> Self {
        Self { way: Way::of(settings), scale: 1.0, step: 1.0, density: 1.0 }
    }

    /// All that are open to frames of `asked`. The first one has the most work in each way.
    pub fn all(asked: &RenderSettings, freedom: Freedom) -> Vec<Self> {
        let mut all = Vec::new();
        for way in freedom.ways(asked) {
            let scales = if way.is_full() { &SCALES[..] } else { &RECONSTRUCTED_SCALES };
            let scales = if freedom.size { scales } else { &[1.0] };
            let densities = if way.is_full() { &DENSITIES[..1] } else { &DENSITIES };
            for &scale in scales {
                for step in STEPS.into_iter().filter(|step| *step == 1.0 || asked.step * step <= MOST_STEP) {
                    all.extend(densities.iter().map(|&density| Self { way, scale, step, density }));
                }
            }
        }
        all
    }

    /// `asked`, changed to frames of this candidate.
    pub fn settings(&self, asked: &RenderSettings) -> RenderSettings {
        let mut settings = if self.way.is_full() {
            RenderSettings { sampling: Sampling::Full, ..asked.clone() }
        } else {
            sparse(asked)
        };
        settings.size = self.size(asked.size);
        settings.pb *= self.density;
        settings.sigma *= self.density.sqrt();
        settings.step *= self.step;
        match self.way {
            Way::CachedLight => settings.shadows = ShadowMode::Cached,
            Way::FewShadowRays => {
                settings.shadow_rays = ShadowRays::Few(const { NonZero::new(FEW).unwrap() });
            }
            Way::ExactLight | Way::LightRatio | Way::Colours => {}
        }
        settings
    }

    /// `whole`, scaled, to at least one pixel.
    pub fn size(&self, whole: FrameSize) -> FrameSize {
        scaled(whole, self.scale)
    }
}

/// `size`, scaled, to at least one pixel.
pub fn scaled(size: FrameSize, scale: f64) -> FrameSize {
    let side = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
    FrameSize { width: side(size.width), height: side(size.height) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_change_what_they_say() {
        let asked = RenderSettings { size: FrameSize::new(1280, 720).unwrap(), ..Default::default() };
        let half = Candidate { way: Way::CachedLight, scale: 0.5, step: 2.0, density: 1.0 };
        let settings = half.settings(&asked);
        assert_eq!((settings.size.to_string().as_str(), settings.step), ("640x360", 1.0));
        assert_eq!((settings.shadows, settings.sampling), (ShadowMode::Cached, Sampling::Full));
        let few =
            Candidate { way: Way::FewShadowRays, scale: 1.0, step: 1.0, density: 0.25 }.settings(&asked);
        assert_eq!((few.sampling, few.shadow_rays.to_string().as_str()), (Sampling::Compact, "16"));
        assert_eq!((few.pb, few.sigma), (asked.pb * 0.25, asked.sigma * 0.5));
        let clip = sparse(&asked);
        assert_eq!(Candidate::of(&asked).settings(&asked), asked);
        assert_eq!(Candidate::of(&clip).settings(&clip), clip);
    }

    #[test]
    fn every_setting_has_candidates_and_fixed_sizes_stay() {
        let asked = RenderSettings { step: 70.0, ..Default::default() };
        let all = Candidate::all(&asked, Freedom { size: false, ..Freedom::ALL });
        assert!(all.iter().all(|candidate| candidate.scale == 1.0 && candidate.step == 1.0));
        assert_eq!(
            Candidate::all(&RenderSettings::default(), Freedom::ALL)[0],
            Candidate::of(&RenderSettings::default())
        );
    }
}
