//! Training batches: network inputs and targets made from clips.
//!
//! Each use of a clip draws augmentations (Table 2 of the paper), a gaze and a density. Frames are sampled with the
//! program's own masks (docs/guide/src/internals/algorithm.md, section 7.3). Motion is found from the depths of samples
//! and guide alone, as at run time. With a guide, networks learn light ratios.

mod config;
mod frame;
mod mask;
mod picture;
mod variation;

pub use config::{Augment, LessonConfig, MOST_PADDING};
pub use frame::LessonFrame;

use crate::Result;
use crate::clips::Clip;
use crate::mask_noise::MaskNoise;
use fovol_core::{Frame, FrameSize, Region, Reprojection, SparseFrame};
use fovolnet::guide::{
    EPSILON, MarchedGuide, UpsampledGuide, importance_of_colours, importance_of_ratios, light_ratios,
};
use fovolnet::render::Importance;
use fovolnet::{Depths, motion, motion_of_depths};
use frame::batch;
use picture::{BACKGROUND, Picture};
use rand::Rng;
use rayon::prelude::*;
use std::collections::VecDeque;
use tch::{Device, Kind, Tensor};
use variation::Variation;

/// Makes training batches from clips.
pub struct TrainingBatch {
    config: LessonConfig,
    noise: MaskNoise,
}

impl TrainingBatch {
    /// Prepares the noise that `config` asks for.
    ///
    /// # Errors
    /// Noise that cannot be made.
    pub fn new(config: &LessonConfig) -> Result<Self> {
        Ok(Self { config: config.clone(), noise: MaskNoise::new(&config.noise)? })
    }

    /// Makes `length` frames from each of `clips`, joined as a batch. All clips must have one size.
    pub fn of(&self, clips: &[Clip], length: usize, random: &mut impl Rng) -> Vec<LessonFrame> {
        let draw = |clip| (clip, Variation::draw(clip, length, &self.config, random));
        let drawn: Vec<(&Clip, Variation)> = clips.iter().map(draw).collect();
        let each = drawn.par_iter().map(|(clip, variation)| {
            let mut past = Past::default();
            (0..length.min(clip.len())).map(|t| variation.frame(clip, t, &self.noise, &mut past)).collect()
        });
        batch(each.collect())
    }
}

/// Earlier frames that later frames of the clip use.
#[derive(Default)]
struct Past {
    /// Number and sample depths of each of the last frames.
    depths: VecDeque<(usize, Depths)>,
    /// The last full frame. It stands in for the network's last output, which does not exist yet.
    last: Option<Frame>,
    /// Importance of samples for the next frame, if densities follow the last one.
    importance: Option<Importance>,
}

impl Past {
    fn add(&mut self, shown: usize, sparse: &SparseFrame, picture: &Picture, variation: &Variation) {
        if self.depths.len() == fovolnet::REMEMBERED {
            self.depths.pop_front();
        }
        self.depths.push_back((shown, Depths::new(sparse)));
        let full = picture.frame();
        self.importance = variation.is_adaptive.then(|| match variation.has_guide {
            true => importance_of_ratios(&picture.ratios(), &picture.whole_guide()),
            false => importance_of_colours(&full, Region::whole(picture.size())),
        });
        self.last = Some(full);
    }
}

/// Subject of a lesson frame.
struct Subject {
    /// Samples of colours or ratios.
    sparse: SparseFrame,
    /// Guide of ratios.
    guide: Option<UpsampledGuide>,
}

impl Variation {
    /// Makes frame `t` of `clip`, which follows the frames in `past`.
    fn frame(&self, clip: &Clip, t: usize, noise: &MaskNoise, past: &mut Past) -> LessonFrame {
        let shown = t.min(self.stop);
        let before = if t == 0 { 0 } else { (t - 1).min(self.stop) };
        let picture = Picture::new(clip, shown, self);
        let sampled = self.sampled(picture.size(), t, noise, past.importance.as_ref());
        let sparse = picture.samples(|at| sampled[at]);
        let guide = self.has_guide.then(|| picture.guide(self.offset[2] + t as u32, &sparse));
        let still = || vec![[0.0; 2]; sampled.len()];
        let [moves, truly] = match past.last.as_ref().filter(|_| shown != before) {
            None => [still(), still()],
            Some(last) => {
                let to_last = clip.reprojection(shown, before);
                let moves = match &guide {
                    Some(guide) => by_depths(&Depths::new(&sparse).with(guide.distances()), &to_last),
                    None => {
                        let earlier = past.depths.iter();
                        let earlier = earlier.map(|(then, depths)| (clip.reprojection(*then, shown), depths));
                        motion(&sparse, &earlier.collect::<Vec<_>>(), &to_last, last)
                    }
                };
                [moves, by_depths(&Depths::new(&picture.samples(|_| true)), &to_last)]
            }
        };
        past.add(shown, &sparse, &picture, self);
        let guide = guide.map(MarchedGuide::into_upsampled);
        let subject = match guide {
            Some(guide) => Subject { sparse: light_ratios(&sparse, &guide, BACKGROUND), guide: Some(guide) },
            None => Subject { sparse: sparse.clone(), guide: None },
        };
        self.tensors(&picture, &sparse, &subject, [moves, truly])
    }

    fn tensors(
        &self,
        picture: &Picture,
        sparse: &SparseFrame,
        subject: &Subject,
        [moves, truly]: [Vec<[f32; 2]>; 2],
    ) -> LessonFrame {
        let size = picture.size();
        let known = subject.sparse.to_frame();
        let mut shown = vec![0.0; size.pixels()];
        sparse.pixels().iter().for_each(|pixel| shown[pixel.index(size.width)] = 1.0);
        let (scale, offset) = match &subject.guide {
            Some(guide) => (colours(&guide.to_frame(size)) + f64::from(EPSILON), EPSILON),
            None => (Tensor::ones([1, 3, i64::from(size.height), i64::from(size.width)], CPU), 0.0),
        };
        let mask: Vec<f32> = known.pixels().iter().map(|pixel| pixel[3]).collect();
        let mask = image(&mask, 1, size);
        LessonFrame {
            colour: self.flipped(&(colours(&known) * &mask)),
            mask: self.flipped(&mask),
            motion: self.flipped_motion(&planes(&moves, size)),
            true_motion: self.flipped_motion(&planes(&truly, size)),
            target: self.flipped(&colours(&picture.frame())),
            shown: self.flipped(&image(&shown, 1, size)),
            scale: self.flipped(&scale),
            offset: Tensor::from_slice(&[offset]).view([1, 1, 1, 1]),
        }
    }
}

/// Kind and place of tensors of lessons.
const CPU: (Kind, Device) = (Kind::Float, Device::Cpu);

/// Motion of every pixel by `reprojection`, with the distances of `depths` between.
fn by_depths(depths: &Depths, reprojection: &Reprojection) -> Vec<[f32; 2]> {
    motion_of_depths(&depths.filled(), reprojection)
}

/// RGB of `frame`: \[1, 3, rows, columns\].
pub(crate) fn colours(frame: &Frame) -> Tensor {
    let planes: Vec<f32> = (0..3).flat_map(|c| frame.pixels().iter().map(move |pixel| pixel[c])).collect();
    image(&planes, 3, frame.size())
}

/// Motion as a tensor: \[1, 2, rows, columns\].
fn planes(motion: &[[f32; 2]], size: FrameSize) -> Tensor {
    let planes: Vec<f32> = (0..2).flat_map(|c| motion.iter().map(move |way| way[c])).collect();
    image(&planes, 2, size)
}

fn image(planes: &[f32], channels: i64, size: FrameSize) -> Tensor {
    Tensor::from_slice(planes).view([1, channels, i64::from(size.height), i64::from(size.width)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clips::{Recipe, VolumeSource, record};
    use crate::loss::flow::warp;
    use fovolnet::OpenDevice;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn clip() -> Clip {
        let recipe = Recipe::draw(11, &VolumeSource::parse("marschner-lobb:24:0").unwrap()).with_part(64, 4);
        record(&recipe, &recipe.source.open().unwrap(), &OpenDevice::Cpu).unwrap()
    }

    fn plain() -> LessonConfig {
        LessonConfig {
            base: [0.05, 0.05],
            without_fovea: 1.0,
            augment: Augment::NONE,
            ..LessonConfig::default()
        }
    }

    fn lesson(clip: &Clip, config: &LessonConfig, random: &mut ChaCha8Rng) -> Vec<LessonFrame> {
        TrainingBatch::new(config).unwrap().of(std::slice::from_ref(clip), 4, random)
    }

    fn largest(tensor: &Tensor) -> f64 {
        tensor.abs().max().double_value(&[])
    }

    #[test]
    fn samples_are_the_target_where_the_mask_is_one() {
        let clip = clip();
        let frames = lesson(&clip, &plain(), &mut ChaCha8Rng::seed_from_u64(1));
        assert_eq!(frames.len(), 4);
        for frame in &frames {
            assert_eq!(frame.colour.size(), [1, 3, 64, 64]);
            assert_eq!(largest(&(&frame.colour - &frame.target * &frame.mask)), 0.0);
            let density = frame.mask.mean(Kind::Float).double_value(&[]);
            assert!((density - 0.05).abs() < 0.02, "{density}");
        }
        assert!(largest(&(&frames[0].mask - &frames[1].mask)) > 0.0);
        assert!(largest(&frames[0].motion) == 0.0);
    }

    /// The picture of the true ratio is the target where the guide is exact, and near it elsewhere.
    #[test]
    fn ratios_times_the_guide_are_the_target() {
        let clip = clip();
        let config = LessonConfig { guide: 1.0, adaptive: 1.0, ..plain() };
        let frames = lesson(&clip, &config, &mut ChaCha8Rng::seed_from_u64(1));
        let samples = |frame: &LessonFrame| frame.shown.sum(Kind::Float).double_value(&[]);
        for (t, frame) in frames.iter().enumerate() {
            let picture = Picture::new(
                &clip,
                t,
                &Variation::draw(&clip, 4, &config, &mut ChaCha8Rng::seed_from_u64(1)),
            );
            let ratios = colours(&picture.ratios());
            assert_eq!(largest(&((&frame.colour - &ratios) * &frame.mask)), 0.0);
            let off = (frame.picture(&ratios) - &frame.target).abs();
            assert_eq!(largest(&(&off * &frame.shown)), 0.0);
            let off = off.mean(Kind::Float).double_value(&[]);
            assert!(off < 0.01, "{off}");
            assert!((samples(frame) / samples(&frames[0]) - 1.0).abs() < 0.1);
            // Faint samples are shown, but have no ratio.
            assert!(largest(&(&frame.mask * (1.0 - &frame.shown))) == 0.0);
        }
        assert!(largest(&frames[2].motion) > 0.0);
    }

    #[test]
    fn flips_turn_pictures_and_motion_alike() {
        let clip = clip();
        let config = plain();
        let flipped = Augment { flip_horizontal: 1.0, flip_vertical: 1.0, ..config.augment.clone() };
        let draw = |augment: &Augment| {
            let config = LessonConfig { augment: augment.clone(), ..config.clone() };
            lesson(&clip, &config, &mut ChaCha8Rng::seed_from_u64(2))
        };
        let (plain, turned) = (draw(&config.augment), draw(&flipped));
        for (a, b) in plain.iter().zip(&turned) {
            assert_eq!(largest(&(a.target.flip([2, 3]) - &b.target)), 0.0);
            assert_eq!(largest(&(a.true_motion.flip([2, 3]) + &b.true_motion)), 0.0);
        }
        assert!(largest(&plain[2].true_motion) > 0.0);
    }

    #[test]
    fn a_still_clip_repeats_its_frame_under_new_masks() {
        let mut config = plain();
        config.augment.still = 1.0;
        let clip = clip();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let frames = (0..9).map(|_| lesson(&clip, &config, &mut random));
        let last = frames.map(|frames| largest(&(&frames[3].target - &frames[2].target)));
        // If the clip freezes before the last frame, the last two are equal.
        assert!(last.filter(|&difference| difference == 0.0).count() > 3);
    }

    #[test]
    fn the_last_frame_moved_along_the_motion_is_nearer_to_this_frame() {
        let (mut still, mut moved) = (0.0, 0.0);
        for seed in 10..22 {
            let recipe = Recipe::draw(seed, &VolumeSource::parse("head:48:0").unwrap()).with_part(64, 4);
            let clip = record(&recipe, &recipe.source.open().unwrap(), &OpenDevice::Cpu).unwrap();
            let frames = lesson(&clip, &plain(), &mut ChaCha8Rng::seed_from_u64(1));
            let (before, now) = (&frames[2].target, &frames[3]);
            // 1 where the pixel was inside the previous frame.
            let inside = warp(&before.ones_like(), &now.true_motion).ge(0.999).to_kind(Kind::Float);
            let error =
                |other: &Tensor| ((other - &now.target).abs() * &inside).mean(Kind::Float).double_value(&[]);
            still += error(before);
            moved += error(&warp(before, &now.true_motion));
        }
        assert!(moved < 0.7 * still, "{moved} {still}");
    }
}
