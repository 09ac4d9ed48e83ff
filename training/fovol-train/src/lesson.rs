//! Training batches: network inputs and targets made from clips.
//!
//! Each use of a clip draws augmentations (Table 2 of the paper), a gaze and a density. Frames are sampled with the
//! program's own masks (docs/guide/src/internals/algorithm.md, section 7.3). Motion is found from the depths of the
//! samples alone, as at run time.

use crate::Result;
use crate::clips::Clip;
use crate::mask_noise::{MaskNoise, NoiseConfig};
use fovol_core::{Frame, FrameSize, Pixel, SampleList, SparseFrame, f16};
use fovolnet::{Depths, motion, motion_of_depths};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use tch::{Device, Kind, Tensor};

/// Augmentation and sampling of clips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct LessonConfig {
    /// Lowest and highest base density; drawn log-uniformly.
    pub base: [f64; 2],
    /// Lowest and highest standard deviation of the fovea, in pixels.
    pub sigma: [f64; 2],
    /// Probability of a mask without a fovea.
    pub without_fovea: f64,
    /// Probabilities of augmentations.
    pub augment: Augment,
    /// Noise of the masks.
    pub noise: NoiseConfig,
}

/// Probabilities of augmentations, by default those of Table 2 of the paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Augment {
    /// Permutation of the colour channels.
    pub colours: f64,
    /// Horizontal flip.
    pub flip_horizontal: f64,
    /// Vertical flip.
    pub flip_vertical: f64,
    /// Conversion to grey.
    pub grey: f64,
    /// Freezing the clip at a frame.
    pub still: f64,
    /// Blanking a border of up to [`MOST_PADDING`] pixels.
    pub padding: f64,
}

/// Largest width of the blank border, in pixels.
pub const MOST_PADDING: u32 = 32;

impl Augment {
    /// No augmentation.
    pub const NONE: Self =
        Self { colours: 0.0, flip_horizontal: 0.0, flip_vertical: 0.0, grey: 0.0, still: 0.0, padding: 0.0 };
}

impl Default for LessonConfig {
    fn default() -> Self {
        Self {
            base: [0.008, 0.12],
            sigma: [10.0, 60.0],
            without_fovea: 0.3,
            augment: Augment::default(),
            noise: NoiseConfig::default(),
        }
    }
}

impl Default for Augment {
    fn default() -> Self {
        Self { colours: 0.6, flip_horizontal: 0.5, flip_vertical: 0.5, grey: 0.3, still: 0.3, padding: 0.1 }
    }
}

/// One frame of a batch of clips.
#[derive(Debug)]
pub struct LessonFrame {
    /// Sampled colours, 0 elsewhere: \[batch, 3, rows, columns\].
    pub colour: Tensor,
    /// 1 where sampled: \[batch, 1, rows, columns\].
    pub mask: Tensor,
    /// Motion from each pixel to its previous position, from the depths of samples: \[batch, 2, rows, columns\] in
    /// pixels.
    pub motion: Tensor,
    /// Motion from the depths of all pixels: \[batch, 2, rows, columns\] in pixels.
    pub true_motion: Tensor,
    /// Fully rendered frame: \[batch, 3, rows, columns\].
    pub target: Tensor,
}

impl LessonFrame {
    /// Slice of `count` clips of the batch, from clip `first` on.
    #[must_use]
    pub fn clips(&self, first: i64, count: i64) -> Self {
        self.each(|tensor| tensor.narrow(0, first, count))
    }

    /// Copies the tensors to `device` asynchronously, after the work queued there.
    #[must_use]
    pub fn to_device(&self, device: Device) -> Self {
        self.each(|tensor| tensor.to_device_(device, tensor.kind(), true, false))
    }

    /// Moves the tensors to pinned memory if `device` is a GPU, so that copies overlap with computation.
    #[must_use]
    pub fn ready_for(&self, device: Device) -> Self {
        // `pin_memory` does this too, but warns for each tensor that its argument is deprecated.
        self.each(|tensor| match device.is_cuda() {
            true => tensor.internal_pin_memory(device),
            false => tensor.shallow_clone(),
        })
    }

    fn each(&self, change: impl Fn(&Tensor) -> Tensor) -> Self {
        Self {
            colour: change(&self.colour),
            mask: change(&self.mask),
            motion: change(&self.motion),
            true_motion: change(&self.true_motion),
            target: change(&self.target),
        }
    }
}

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

/// Joins the frames of `single` clips as batches, up to the shortest length.
fn batch(single: Vec<Vec<LessonFrame>>) -> Vec<LessonFrame> {
    let length = single.iter().map(Vec::len).min().unwrap_or(0);
    let mut moments: Vec<Vec<LessonFrame>> = (0..length).map(|_| Vec::new()).collect();
    for clip in single {
        moments.iter_mut().zip(clip).for_each(|(moment, frame)| moment.push(frame));
    }
    moments.into_par_iter().map(|frames| beside(&frames)).collect()
}

/// Joins frames of the same time step along the batch dimension.
fn beside(frames: &[LessonFrame]) -> LessonFrame {
    let all =
        |part: fn(&LessonFrame) -> &Tensor| Tensor::cat(&frames.iter().map(part).collect::<Vec<_>>(), 0);
    LessonFrame {
        colour: all(|frame| &frame.colour),
        mask: all(|frame| &frame.mask),
        motion: all(|frame| &frame.motion),
        true_motion: all(|frame| &frame.true_motion),
        target: all(|frame| &frame.target),
    }
}

/// Earlier frames that later frames of the clip use.
#[derive(Default)]
struct Past {
    /// Number and sample depths of each of the last frames.
    depths: VecDeque<(usize, Depths)>,
    /// The last full frame. It stands in for the network's last output, which does not exist yet.
    last: Option<Frame>,
}

impl Past {
    fn add(&mut self, shown: usize, depths: Depths, full: Frame) {
        if self.depths.len() == fovolnet::REMEMBERED {
            self.depths.pop_front();
        }
        self.depths.push_back((shown, depths));
        self.last = Some(full);
    }
}

/// RGB of `frame`: \[1, 3, rows, columns\].
fn colours(frame: &Frame) -> Tensor {
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

/// Random choices for one use of a clip.
struct Variation {
    /// Source channel of each output channel.
    channels: [usize; 3],
    is_grey: bool,
    flips: Vec<i64>,
    /// Frame at which the clip freezes.
    stop: usize,
    /// Blank columns and rows: left, top, right, bottom.
    border: [u32; 4],
    base: f64,
    /// Standard deviation of the fovea in pixels; 0 for no fovea.
    sigma: f64,
    /// Gaze at the first and the last frame, in pixels of the crop.
    gaze: [[f64; 2]; 2],
    /// Offset of the crop in the noise tile: x, y, and the first frame.
    offset: [u32; 3],
    length: usize,
}

impl Variation {
    fn draw(clip: &Clip, length: usize, config: &LessonConfig, random: &mut impl Rng) -> Self {
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
        Self { channels, is_grey, flips: flips.collect(), stop, border, base, sigma, gaze, offset, length }
    }

    /// Makes frame `t`, which follows the frames in `past`.
    fn frame(&self, clip: &Clip, t: usize, noise: &MaskNoise, past: &mut Past) -> LessonFrame {
        let shown = t.min(self.stop);
        let before = if t == 0 { 0 } else { (t - 1).min(self.stop) };
        let size = clip.scenery.part;
        let (width, height) = (size.width as usize, size.height as usize);
        let sampled = self.sampled(size.width, size.height, t, noise);
        let mut full = Frame::new(size);
        let [mut known, mut all] = [Samples::default(), Samples::default()];
        for at in 0..size.pixels() {
            let (x, y) = (at % width, at / width);
            let (mut colour, mut depth) = ([0.0; 3], f32::INFINITY);
            if !self.is_blank(x, y, width, height) {
                colour = self.recoloured(std::array::from_fn(|c| clip.frames[shown][3 * at + c]));
                depth = 1.0 / clip.inverse_distances[shown][at].to_f32();
            }
            let pixel = Pixel { x: x as u16, y: y as u16 };
            all.push(pixel, colour, depth);
            if sampled[at] {
                known.push(pixel, colour, depth);
            }
            let [r, g, b] = colour;
            full.pixels_mut()[at] = [r, g, b, 1.0];
        }
        let [sparse, all] = [known, all].map(|samples| samples.frame(size));
        let still = || vec![[0.0; 2]; size.pixels()];
        let [moves, truly] = match past.last.as_ref().filter(|_| shown != before) {
            None => [still(), still()],
            Some(last) => {
                let to_last = clip.reprojection(shown, before);
                let earlier =
                    past.depths.iter().map(|(then, depths)| (clip.reprojection(*then, shown), depths));
                let moves = motion(&sparse, &earlier.collect::<Vec<_>>(), &to_last, last);
                [moves, motion_of_depths(&Depths::new(&all).filled(), &to_last)]
            }
        };
        let [motion, true_motion] = [moves, truly].map(|motion| self.flipped_motion(&planes(&motion, size)));
        let target = self.flipped(&colours(&full));
        let mask: Vec<f32> = sampled.iter().map(|sampled| f32::from(u8::from(*sampled))).collect();
        let mask = self.flipped(&image(&mask, 1, size));
        past.add(shown, Depths::new(&sparse), full);
        LessonFrame { colour: &target * &mask, motion, true_motion, mask, target }
    }

    /// Sampling mask of frame `t`.
    fn sampled(&self, width: u32, height: u32, t: usize, noise: &MaskNoise) -> Vec<bool> {
        let along = if self.length > 1 { t as f64 / (self.length - 1) as f64 } else { 0.0 };
        let gaze: [f64; 2] =
            std::array::from_fn(|a| self.gaze[0][a] + (self.gaze[1][a] - self.gaze[0][a]) * along);
        let [left, top, slice] = self.offset;
        let noise = noise.frame(slice + t as u32);
        let falloff = |at: u32, gaze: f64| {
            if self.sigma > 0.0 {
                (-0.5 * ((f64::from(at) + 0.5 - gaze) / self.sigma).powi(2)).exp()
            } else {
                0.0
            }
        };
        let columns: Vec<f64> = (0..width).map(|x| falloff(x, gaze[0])).collect();
        let mut sampled = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            let row = falloff(y, gaze[1]);
            sampled.extend((0..width).map(|x| {
                let density = self.base + (1.0 - self.base) * row * columns[x as usize];
                noise.threshold(x + left, y + top) < density
            }));
        }
        sampled
    }

    fn is_blank(&self, x: usize, y: usize, width: usize, height: usize) -> bool {
        let [left, top, right, bottom] = self.border.map(|side| side as usize);
        x < left || y < top || x + right >= width || y + bottom >= height
    }

    fn recoloured(&self, colour: [f16; 3]) -> [f32; 3] {
        let colour = self.channels.map(|c| colour[c].to_f32());
        if self.is_grey { [(colour[0] + colour[1] + colour[2]) / 3.0; 3] } else { colour }
    }

    fn flipped(&self, image: &Tensor) -> Tensor {
        if self.flips.is_empty() { image.shallow_clone() } else { image.flip(self.flips.as_slice()) }
    }

    /// Flips a motion field in space and negates the flipped components.
    fn flipped_motion(&self, motion: &Tensor) -> Tensor {
        let sign = |axis: i64| if self.flips.contains(&axis) { -1.0f32 } else { 1.0 };
        let signs = Tensor::from_slice(&[sign(3), sign(2)]).view([1, 2, 1, 1]);
        self.flipped(motion) * signs.to_kind(Kind::Float)
    }
}

/// Samples of a frame, as they are collected in raster order.
#[derive(Default)]
struct Samples {
    pixels: Vec<Pixel>,
    colours: Vec<[f32; 3]>,
    depths: Vec<f32>,
}

impl Samples {
    fn push(&mut self, pixel: Pixel, colour: [f32; 3], depth: f32) {
        self.pixels.push(pixel);
        self.colours.push(colour);
        self.depths.push(depth);
    }

    fn frame(self, size: FrameSize) -> SparseFrame {
        SparseFrame::new(SampleList::new(size, self.pixels), self.colours, self.depths)
    }
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
