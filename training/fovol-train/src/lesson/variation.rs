use super::config::{LessonConfig, MOST_PADDING};
use crate::clips::Clip;
use fovol_core::{FrameSize, f16};
use rand::{Rng, RngExt};
use tch::{Kind, Tensor};

/// Random choices for one use of a clip.
pub(super) struct Variation {
    /// Source channel of each output channel.
    channels: [usize; 3],
    is_grey: bool,
    flips: Vec<i64>,
    /// Whether light ratios are learned, not colours.
    pub has_guide: bool,
    /// Whether densities follow the last frame.
    pub is_adaptive: bool,
    /// Frame at which the clip freezes.
    pub stop: usize,
    /// Blank columns and rows: left, top, right, bottom.
    border: [u32; 4],
    pub base: f64,
    /// Standard deviation of the fovea in pixels; 0 for no fovea.
    pub sigma: f64,
    /// Gaze at the first and the last frame, in pixels of the crop.
    pub gaze: [[f64; 2]; 2],
    /// Offset of the crop in the noise tile: x, y, and the first frame.
    pub offset: [u32; 3],
    pub length: usize,
}

impl Variation {
    pub fn draw(clip: &Clip, length: usize, config: &LessonConfig, random: &mut impl Rng) -> Self {
        let augment = &config.augment;
        let mut happens = |probability: f64| random.random::<f64>() < probability;
        let [colours, horizontal, vertical, is_grey, still, padding] = [
            augment.colours,
            augment.flip_horizontal,
            augment.flip_vertical,
            augment.grey,
            augment.still,
            augment.padding,
        ]
        .map(&mut happens);
        let has_fovea = !happens(config.without_fovea);
        let [has_guide, is_adaptive] = [config.guide, config.adaptive].map(&mut happens);
        let between = |random: &mut dyn FnMut() -> f64, [low, high]: [f64; 2]| low + (high - low) * random();
        let mut unit = || random.random::<f64>();
        let side = [clip.scenery.part.width, clip.scenery.part.height].map(f64::from);
        // The gaze often lies outside the crop, since most of a frame is far from the fovea.
        let mut look = || side.map(|side| (unit() * 2.0 - 0.5) * side);
        let gaze = [look(), look()];
        let base = between(&mut unit, config.base.map(f64::ln)).exp();
        let sigma = if has_fovea { between(&mut unit, config.sigma) } else { 0.0 };
        let stop = match still {
            false => clip.len(),
            true if unit() < 0.5 => 0,
            true => (unit() * clip.len() as f64) as usize,
        };
        let mut border = [0; 4];
        if padding {
            border = border.map(|_: u32| (unit() * f64::from(MOST_PADDING + 1)) as u32);
        }
        let mut channels = [0, 1, 2];
        if colours {
            for i in [2, 1] {
                channels.swap(i, (unit() * (i + 1) as f64) as usize);
            }
        }
        let offset = [128.0, 128.0, 64.0].map(|most| (unit() * most) as u32);
        let flips = [(horizontal, 3), (vertical, 2)].into_iter().filter(|flip| flip.0).map(|flip| flip.1);
        let flips = flips.collect();
        Self {
            channels,
            is_grey,
            flips,
            has_guide,
            is_adaptive,
            stop,
            border,
            base,
            sigma,
            gaze,
            offset,
            length,
        }
    }

    /// Whether pixel (`x`, `y`) of frames of `size` lies in the blank border.
    pub fn is_blank(&self, x: usize, y: usize, size: FrameSize) -> bool {
        let [width, height] = [size.width, size.height].map(|side| side as usize);
        let [left, top, right, bottom] = self.border.map(|side| side as usize);
        x < left || y < top || x + right >= width || y + bottom >= height
    }

    /// `colour` with its channels changed.
    pub fn recoloured(&self, colour: [f16; 3]) -> [f32; 3] {
        let colour = self.channels.map(|c| colour[c].to_f32());
        if self.is_grey { [(colour[0] + colour[1] + colour[2]) / 3.0; 3] } else { colour }
    }

    pub fn flipped(&self, image: &Tensor) -> Tensor {
        if self.flips.is_empty() { image.shallow_clone() } else { image.flip(self.flips.as_slice()) }
    }

    /// Flips a motion field in space and negates the flipped components.
    pub fn flipped_motion(&self, motion: &Tensor) -> Tensor {
        let sign = |axis: i64| if self.flips.contains(&axis) { -1.0f32 } else { 1.0 };
        let signs = Tensor::from_slice(&[sign(3), sign(2)]).view([1, 2, 1, 1]);
        self.flipped(motion) * signs.to_kind(Kind::Float)
    }
}
