use super::candidate::{STEPS, scaled};
use super::costs::Costs;
use super::errors::{Errors, SCALES};
use super::running_error::RunningError;
use super::scatter::Scatter;
use super::shown_error::ShownError;
use super::taps::{Enlargement, Taps, blended};
use crate::{Pipeline, RenderSettings, Result, Viewpoint};
use fovol_core::{Frame, FrameSize, Pixel, SampleList, ShadowMode};
use std::time::Instant;

/// Frame whose error is measured, as it is shown: enlarged to the asked size.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// Frame as it was made.
    pub frame: &'a Frame,
    /// Whether a screen enlarges it, linearly; else it is enlarged cubically.
    pub on_screen: bool,
}

/// Cause of error that a frame's probes measure, besides the frame itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// Cached light against shadow rays.
    Light,
    /// Frames of [`SCALES`], with these shadows.
    Scale(usize, ShadowMode),
    /// [`STEPS`] besides the first.
    Step(usize),
}

impl Measured {
    /// How many there are.
    pub const COUNT: u32 = (SCALES.len() + STEPS.len()) as u32;

    /// Number `turn` of all, which repeat. Light comes in between only if it `may_be_cached`.
    pub fn number(turn: u32, may_be_cached: bool, shadows: ShadowMode) -> Self {
        let turn = (turn % Self::COUNT) as usize;
        match turn {
            0 if may_be_cached => Self::Light,
            0 => Self::Scale(0, shadows),
            turn if turn <= SCALES.len() => Self::Scale(turn - 1, shadows),
            turn => Self::Step(turn - SCALES.len() - 1),
        }
    }
}

/// Most pixels that measure the error of other light and steps, and of other sizes. Each of the latter marches up to 17.
const FEWER: usize = 512;
const FEWEST: usize = 96;
/// Probe pixels for each one that measures the error of other sizes.
const TAPPED: usize = 3;
/// Weight of what was known, for errors that are measured in turn.
const MEMORY: f64 = 0.7;
/// Probe pixels for each one that is marched exactly. Colours with cached light stand for the others.
const SUBSTITUTES: usize = 6;

/// Display values of pixels.
type Colours = Vec<[f32; 3]>;

/// Probe pixels of one frame.
pub struct Probes<'a> {
    pipeline: &'a mut Pipeline,
    viewpoint: &'a Viewpoint,
    asked: &'a RenderSettings,
    pixels: Vec<Pixel>,
    /// Weight of each pixel, 1 on average.
    weights: Vec<f64>,
    /// Colours of the first pixels with exact shadows at the asked step.
    exact: Colours,
    /// The exact shadows of the settings.
    exact_shadows: ShadowMode,
    /// Milliseconds of marching a pixel exactly.
    pixel_ms: f64,
}

impl<'a> Probes<'a> {
    /// Marches `count` pixels of frame `number` exactly, more of them at edges of the frame that is `shown`, and counts their
    /// samples in `costs`. `None` where the volume cannot be seen, or where the device cannot march them.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn new(
        (pipeline, viewpoint, asked): (&'a mut Pipeline, &'a Viewpoint, &'a RenderSettings),
        (number, count, shown_frame): (u32, usize, Option<Shown<'_>>),
        costs: &mut Costs,
    ) -> Result<Option<Self>> {
        let Some(region) = pipeline.visible_region(&viewpoint.camera, asked.size) else {
            return Ok(None);
        };
        let scatter = match shown_frame {
            Some(Shown { frame, .. }) => Scatter::by_contrast(region, asked.size, frame),
            None => Scatter::even(region),
        };
        let scattered = scatter.pixels(number, SUBSTITUTES * count);
        let (pixels, weights): (Vec<Pixel>, Vec<f64>) = scattered.into_iter().unzip();
        let exact_shadows = match asked.shadows {
            ShadowMode::Off => ShadowMode::Off,
            ShadowMode::On | ShadowMode::Cached => ShadowMode::On,
        };
        let list = SampleList::new(asked.size, pixels[..count].to_vec());
        let started = Instant::now();
        let Some((exact, samples)) =
            pipeline.march_as((exact_shadows, asked.step), &viewpoint.camera, &list)?
        else {
            return Ok(None);
        };
        let exact_ms = started.elapsed().as_secs_f64() * 1e3;
        costs.see(region.size.pixels() as f64 / asked.size.pixels() as f64);
        if let Some(samples) = samples {
            costs.count(samples, count);
            costs.guess(count, exact_ms);
        }
        let exact = exact.iter().map(|ray| shown(ray.colour)).collect();
        let pixel_ms = exact_ms / count as f64;
        Ok(Some(Self { pipeline, viewpoint, asked, pixels, weights, exact, exact_shadows, pixel_ms }))
    }

    /// Milliseconds that marching a pixel exactly took.
    pub fn pixel_ms(&self) -> f64 {
        self.pixel_ms
    }

    /// Adds the errors of the frame `made` to `error`. Colours with cached light are substitutes of exact ones if the frame's
    /// `light_is_cached`.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn compare(&mut self, made: Shown<'_>, light_is_cached: bool, error: &mut ShownError) -> Result<()> {
        let enlargement = if made.on_screen { Enlargement::Linear } else { Enlargement::Cubic };
        let size = self.asked.size;
        let shown = |pixel: &Pixel| enlargement.colour(made.frame, *pixel, size);
        let exact = squared(self.pixels.iter().map(shown), self.exact.iter().copied());
        let exact: Vec<f64> = weighted(exact, &self.weights).collect();
        if !light_is_cached {
            error.add(&exact);
            return Ok(());
        }
        let list = SampleList::new(size, self.pixels.clone());
        match self.march((ShadowMode::Cached, self.asked.step), &list)? {
            Some(cached) => {
                let errors = squared(self.pixels.iter().map(shown), cached.into_iter());
                error.add_substituted(&weighted(errors, &self.weights).collect::<Vec<_>>(), &exact);
            }
            None => error.add(&exact),
        }
        Ok(())
    }

    /// Measures what `measured` says, at `step` times the asked step.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn measure(&mut self, measured: Measured, step: f64, errors: &mut Errors) -> Result<()> {
        let step = self.asked.step * step;
        match measured {
            Measured::Light => {
                let exact = self.marched_exactly(step)?;
                let cached = self.marched((ShadowMode::Cached, step), FEWER)?;
                add(&mut errors.light, exact.zip(cached), &self.weights);
            }
            Measured::Step(i) => {
                let longer = self.marched_exactly(self.asked.step * STEPS[i + 1])?;
                add(&mut errors.steps[i], longer.map(|longer| (longer, self.exact.clone())), &self.weights);
            }
            Measured::Scale(i, shadows) => {
                let small = scaled(self.asked.size, SCALES[i]);
                let count = self.exact.len().div_ceil(TAPPED).min(FEWEST);
                let sized = self.marched_smaller(small, count, (shadows, step))?;
                let whole = self.marched((shadows, step), count)?;
                add(&mut errors.scales[i], sized.zip(whole), &self.weights);
            }
        }
        Ok(())
    }

    /// Colours with exact shadows at `step`.
    fn marched_exactly(&mut self, step: f64) -> Result<Option<Colours>> {
        if step == self.asked.step {
            return Ok(Some(self.exact.clone()));
        }
        self.marched((self.exact_shadows, step), FEWER)
    }

    /// Colours of the first `count` pixels that are marched exactly, or of all if there are fewer.
    fn marched(&mut self, how: (ShadowMode, f64), count: usize) -> Result<Option<Colours>> {
        let list = SampleList::new(self.asked.size, self.first(count).to_vec());
        self.march(how, &list)
    }

    fn first(&self, count: usize) -> &[Pixel] {
        &self.pixels[..count.min(self.exact.len())]
    }

    fn march(&mut self, how: (ShadowMode, f64), list: &SampleList) -> Result<Option<Colours>> {
        let marched = self.pipeline.march_as(how, &self.viewpoint.camera, list)?;
        Ok(marched.map(|(rays, _)| rays.iter().map(|ray| shown(ray.colour)).collect()))
    }

    /// Colours of the first `count` pixels in a frame of size `small` that is enlarged.
    fn marched_smaller(
        &mut self,
        small: FrameSize,
        count: usize,
        how: (ShadowMode, f64),
    ) -> Result<Option<Colours>> {
        let pixels = self.first(count).iter();
        let taps: Vec<Taps> =
            pixels.map(|pixel| Enlargement::Cubic.taps(*pixel, self.asked.size, small)).collect();
        let list = SampleList::new(small, taps.iter().flatten().map(|(pixel, _)| *pixel).collect());
        let Some(marched) = self.march(how, &list)? else { return Ok(None) };
        let mut marched = marched.into_iter();
        let enlarged = taps.iter().map(|taps| {
            let weights = taps.iter().map(|(_, weight)| *weight);
            blended(marched.by_ref().take(taps.len()).zip(weights))
        });
        Ok(Some(enlarged.collect()))
    }
}

/// Display values, as metrics compare them.
fn shown(colour: [f32; 3]) -> [f32; 3] {
    colour.map(|value| value.clamp(0.0, 1.0))
}

/// Adds the errors between the two colours of pixels, if they are known.
fn add(error: &mut RunningError, pair: Option<(Colours, Colours)>, weights: &[f64]) {
    if let Some((a, b)) = pair {
        error.add(weighted(squared(a.into_iter(), b.into_iter()), weights), MEMORY);
    }
}

/// `errors` of pixels by their weights.
fn weighted(errors: impl Iterator<Item = f64>, weights: &[f64]) -> impl Iterator<Item = f64> {
    errors.zip(weights).map(|(error, weight)| error * weight)
}

/// Squared errors of pixels: means over red, green and blue.
fn squared(
    a: impl Iterator<Item = [f32; 3]>,
    b: impl Iterator<Item = [f32; 3]>,
) -> impl Iterator<Item = f64> {
    a.zip(b).map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>() / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_has_its_turn() {
        let all: Vec<Measured> =
            (0..Measured::COUNT).map(|turn| Measured::number(turn, true, ShadowMode::Off)).collect();
        assert_eq!(all[0], Measured::Light);
        assert!((0..SCALES.len()).all(|i| all.contains(&Measured::Scale(i, ShadowMode::Off))));
        assert!((0..STEPS.len() - 1).all(|i| all.contains(&Measured::Step(i))));
        assert!(!(0..20).any(|turn| Measured::number(turn, false, ShadowMode::On) == Measured::Light));
    }
}
