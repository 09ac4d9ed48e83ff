use super::way::Way;
use crate::{Guide, RenderOverrides, RenderSettings, Sampling};
use fovol_core::ShadowMode;

/// Settings that a planner may decide: those that are not given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// Which pixels are marched, and how the others are filled: sampling, reconstruction, weights and guide.
    pub pixels: bool,
    /// Shadows.
    pub shadows: bool,
    /// Shadow rays of a pixel.
    pub shadow_rays: bool,
    /// Size of the frame before it is enlarged.
    pub size: bool,
}

impl Freedom {
    /// Everything.
    pub const ALL: Self = Self { pixels: true, shadows: true, shadow_rays: true, size: true };

    /// Nothing.
    pub const NOTHING: Self = Self { pixels: false, shadows: false, shadow_rays: false, size: false };

    /// Ways that are open to frames of `asked`. There is always one.
    pub fn ways(self, asked: &RenderSettings) -> Vec<Way> {
        let is_full = asked.sampling == Sampling::Full;
        let sparse = sparse(asked);
        let has_rays = asked.shadows == ShadowMode::On && sparse.guide_kind() != Guide::None;
        let is_open = |way: Way| match way {
            Way::ExactLight => self.pixels || is_full,
            Way::CachedLight => {
                (self.pixels || is_full)
                    && self.shadows
                    && self.shadow_rays
                    && asked.shadows == ShadowMode::On
            }
            Way::LightRatio | Way::Colours => (self.pixels || !is_full) && Way::of(&sparse) == way,
            Way::FewShadowRays => (self.pixels || !is_full) && self.shadow_rays && has_rays,
        };
        // A transparent background needs every pixel.
        Way::ALL.into_iter().filter(|way| is_open(*way) && (way.is_full() || !asked.transparent)).collect()
    }
}

/// `asked`, with sparse pixels.
pub fn sparse(asked: &RenderSettings) -> RenderSettings {
    let sampling = if asked.sampling == Sampling::Full { Sampling::Compact } else { asked.sampling };
    RenderSettings { sampling, ..asked.clone() }
}

impl RenderOverrides {
    /// Settings that a planner may decide for these frames.
    pub fn freedom(&self) -> Freedom {
        let is_free = |is_given: bool| !is_given;
        Freedom {
            pixels: is_free(
                self.sampling.is_some_and(|choice| choice.fixed().is_some())
                    || self.reconstruct.is_some()
                    || self.weights.is_some()
                    || self.random_weights.is_some()
                    || self.guide.is_some_and(|choice| choice.fixed().is_some()),
            ),
            shadows: is_free(self.shadows.is_some()),
            shadow_rays: is_free(self.shadow_rays.is_some()),
            size: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ways(given: &RenderOverrides) -> Vec<Way> {
        given.freedom().ways(&given.resolve().unwrap())
    }

    #[test]
    fn what_is_given_is_kept() {
        let free = RenderOverrides { frames: Some(3), ..Default::default() };
        let open = [Way::ExactLight, Way::CachedLight, Way::LightRatio, Way::FewShadowRays];
        assert_eq!(ways(&free), open);
        let kept = |change: fn(&mut RenderOverrides)| {
            let mut given = free.clone();
            change(&mut given);
            ways(&given)
        };
        assert_eq!(kept(|g| g.sampling = Some(Sampling::Full.into())), open[..2]);
        assert_eq!(kept(|g| g.shadows = Some(ShadowMode::On)), [open[0], open[2], open[3]]);
        assert_eq!(kept(|g| g.guide = Some(Guide::None.into())), [Way::Colours]);
        assert_eq!(kept(|g| g.reconstruct = Some("linear".parse().unwrap())), [Way::Colours]);
        assert_eq!(kept(|g| g.reconstruct = Some("wnet".parse().unwrap())), open[2..]);
        assert_eq!(kept(|g| g.shadow_rays = Some("8".parse().unwrap())), [open[0], open[2]]);
        assert_eq!(kept(|g| g.shadows = Some(ShadowMode::Off)), [Way::ExactLight, Way::Colours]);
        let transparent = RenderOverrides { transparent: Some(true), ..Default::default() };
        assert_eq!(ways(&transparent), open[..2]);
    }
}
