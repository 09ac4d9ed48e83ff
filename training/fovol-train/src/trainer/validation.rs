use crate::clips::ClipSet;
use crate::lesson::{Augment, LessonConfig, LessonFrame, TrainingBatch, colours};
use crate::network::{Inputs, Network};
use crate::{Error, Result};
use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_net::Fill;
use fovolnet::io::image::{self, Alpha};
use fovolnet::metrics::ClipQuality;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::fmt;
use std::path::Path;
use tch::{Device, Kind, Tensor};

/// Quality of pictures: means over clips.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Scores {
    /// PSNR in decibels, from the mean squared error of each clip.
    pub psnr: f64,
    /// SSIM, at most 1.
    pub ssim: f64,
    /// tPSNR in decibels: PSNR of the differences between frames.
    pub tpsnr: f64,
}

impl fmt::Display for Scores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} dB, SSIM {:.4}, tPSNR {:.2} dB", self.psnr, self.ssim, self.tpsnr)
    }
}

/// Quality of hole filling without a network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Fills {
    /// Pull-push: averages over ever larger squares.
    pub pull_push: Scores,
    /// Linear interpolation between samples.
    pub linear: Scores,
}

/// Quality of a network and of plain hole filling on the validation clips.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Judgement {
    network: Scores,
    #[serde(flatten)]
    fills: Fills,
}

impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { network, fills } = self;
        write!(f, "{network} (pull-push {}; linear {})", fills.pull_push, fills.linear)
    }
}

/// Validation clips, always sampled with equal masks at a density of 3 %.
pub(super) struct Validation {
    lessons: Vec<Vec<LessonFrame>>,
    fills: Option<Fills>,
}

/// Sampling density of validation.
const DENSITY: f64 = 0.03;
/// First frame that is scored; the network needs some history first.
const FROM: usize = 4;
/// Rows of `preview.png`.
const PREVIEWS: usize = 6;

impl Validation {
    /// Prepares the clips of `set` with the noise of `lesson`.
    ///
    /// Networks that learn light ratios are judged by these.
    pub fn new(set: &ClipSet, lesson: &LessonConfig) -> Result<Self> {
        let whether = |probability: f64| if probability > 0.0 { 1.0 } else { 0.0 };
        let plain = LessonConfig {
            base: [DENSITY; 2],
            without_fovea: 1.0,
            guide: whether(lesson.guide),
            adaptive: whether(lesson.adaptive),
            augment: Augment::NONE,
            noise: lesson.noise.clone(),
            ..LessonConfig::default()
        };
        let plain = TrainingBatch::new(&plain)?;
        let mut random = ChaCha8Rng::seed_from_u64(77);
        let lessons = (0..set.len()).map(|i| {
            let clip = set.clip(i)?;
            let length = clip.len();
            Ok(plain.of(&[clip], length, &mut random))
        });
        Ok(Self { lessons: lessons.collect::<Result<_>>()?, fills: None })
    }

    /// Scores `network`. Draws sparse frames, fills, reconstructions and references to `preview`.
    pub fn judge(&mut self, network: &Network, preview: &Path) -> Result<Judgement> {
        let mut scores = Scores::default();
        let mut rows = Vec::new();
        for lesson in &self.lessons {
            let outputs = tch::no_grad(|| reconstructed(network, lesson))?;
            scores.add(&score(lesson, &outputs)?, self.lessons.len());
            if let (Some(frame), Some(output)) = (lesson.last(), outputs.last()) {
                let sparse = sparse_frame(frame)?;
                rows.push([
                    sparse.to_frame(),
                    filled(frame, Fill::PullPush)?,
                    output.clone(),
                    target_frame(frame)?,
                ]);
            }
        }
        rows.truncate(PREVIEWS);
        draw(&rows, preview)?;
        let fills = match self.fills {
            Some(known) => known,
            None => {
                let pull_push = self.filled(Fill::PullPush)?;
                let linear = self.filled(Fill::Linear)?;
                *self.fills.insert(Fills { pull_push, linear })
            }
        };
        Ok(Judgement { network: scores, fills })
    }

    fn filled(&self, fill: Fill) -> Result<Scores> {
        let mut scores = Scores::default();
        for lesson in &self.lessons {
            let frames: Vec<Frame> = lesson.iter().map(|frame| filled(frame, fill)).collect::<Result<_>>()?;
            scores.add(&score(lesson, &frames)?, self.lessons.len());
        }
        Ok(scores)
    }
}

impl Scores {
    fn add(&mut self, one: &Self, of: usize) {
        self.psnr += one.psnr / of as f64;
        self.ssim += one.ssim / of as f64;
        self.tpsnr += one.tpsnr / of as f64;
    }
}

/// Picture of the output `output` for `frame`.
fn shown(frame: &LessonFrame, output: &Tensor) -> Result<Frame> {
    frame_of(&frame.picture(&output.clamp(0.0, 1.0)).clamp(0.0, 1.0), None)
}

/// Reconstructs a clip with `network`.
fn reconstructed(network: &Network, lesson: &[LessonFrame]) -> Result<Vec<Frame>> {
    let size = lesson[0].colour.size();
    let mut state = network.initial_state([size[0], size[2], size[3]]);
    let mut outputs = Vec::new();
    for frame in lesson {
        let frame = frame.to_device(network.device());
        let inputs = Inputs { colour: &frame.colour, mask: Some(&frame.mask), motion: Some(&frame.motion) };
        let (output, next) = network.forward(&inputs, state)?;
        state = next;
        outputs.push(shown(&frame, &output)?);
    }
    Ok(outputs)
}

fn score(lesson: &[LessonFrame], outputs: &[Frame]) -> Result<Scores> {
    let mut quality = ClipQuality::new().without_ms_ssim();
    for (frame, output) in lesson.iter().zip(outputs).skip(FROM.min(lesson.len().saturating_sub(2))) {
        quality.push(&target_frame(frame)?, output).map_err(|e| Error::Input(e.to_string()))?;
    }
    let summary = quality.summary().ok_or_else(|| Error::Clip("a clip to judge by has no frames".into()))?;
    Ok(Scores { psnr: summary.psnr, ssim: summary.ssim.unwrap_or(0.0), tpsnr: summary.tpsnr.unwrap_or(0.0) })
}

/// Picture that `fill` makes of `frame`.
fn filled(frame: &LessonFrame, fill: Fill) -> Result<Frame> {
    shown(frame, &colours(&fill.reconstruct(&sparse_frame(frame)?)))
}

pub(super) fn sparse_frame(frame: &LessonFrame) -> Result<SparseFrame> {
    Ok(SparseFrame::from(&frame_of(&frame.colour, Some(&frame.mask))?))
}

fn target_frame(frame: &LessonFrame) -> Result<Frame> {
    frame_of(&frame.target, None)
}

/// First picture of a batch, with `alpha` or opaque.
fn frame_of(colour: &Tensor, alpha: Option<&Tensor>) -> Result<Frame> {
    let size = colour.size();
    let side = |n: i64| u32::try_from(n).unwrap_or(0);
    let size = FrameSize::new(side(size[3]), side(size[2]))?;
    let plane = |tensor: &Tensor, channel: i64| -> Vec<f32> {
        let flat =
            tensor.get(0).get(channel).to_device(Device::Cpu).to_kind(Kind::Float).contiguous().view([-1]);
        let mut values = vec![0.0; flat.numel()];
        flat.copy_data(&mut values, flat.numel());
        values
    };
    let [r, g, b] = [0, 1, 2].map(|c| plane(colour, c));
    let a = alpha.map(|alpha| plane(alpha, 0));
    let pixels = (0..size.pixels()).map(|i| [r[i], g[i], b[i], a.as_ref().map_or(1.0, |a| a[i])]).collect();
    Ok(Frame::from_pixels(size, pixels)?)
}

/// Draws rows of four pictures each into one image.
fn draw(rows: &[[Frame; 4]], path: &Path) -> Result<()> {
    let Some(first) = rows.first() else { return Ok(()) };
    let FrameSize { width, height } = first[0].size();
    let size = FrameSize::new(width * 4, height * rows.len() as u32)?;
    let mut sheet = Frame::new(size);
    for (row, frames) in rows.iter().enumerate() {
        for (column, frame) in frames.iter().enumerate() {
            for (i, &[r, g, b, _]) in frame.pixels().iter().enumerate() {
                let (x, y) = (
                    i % width as usize + column * width as usize,
                    i / width as usize + row * height as usize,
                );
                sheet.pixels_mut()[y * size.width as usize + x] = [r, g, b, 1.0];
            }
        }
    }
    image::write_png(path, &sheet, Alpha::Drop).map_err(|e| Error::Render(e.into()))
}
