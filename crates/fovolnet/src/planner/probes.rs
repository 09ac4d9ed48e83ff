use super::costs::Costs;
use super::errors::Errors;
use super::scatter::Scatter;
use super::shown_error::ShownError;
use super::taps::Enlargement;
use crate::{Pipeline, RenderSettings, Result, Viewpoint};
use fovol_core::{Frame, FrameSize, Pixel, Region, SampleList, ShadowMode};
use std::time::Instant;

/// Frame whose error is measured, as it is shown: enlarged to the asked size.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// Frame as it was made.
    pub frame: &'a Frame,
    /// Whether a screen enlarges it, linearly; else it is enlarged cubically.
    pub on_screen: bool,
}

impl Shown<'_> {
    /// Colour that is shown at `pixel` of a frame of `size`.
    pub fn colour(&self, pixel: Pixel, size: FrameSize) -> [f32; 3] {
        self.enlargement().colour(self.frame, pixel, size)
    }

    /// Colour that would be shown at `pixel` of a frame of the size `large`, were the frame made `smaller` first.
    pub fn colour_made_smaller(&self, pixel: Pixel, [large, smaller]: [FrameSize; 2]) -> [f32; 3] {
        self.enlargement().colour_made_smaller(self.frame, pixel, [large, smaller])
    }

    fn enlargement(&self) -> Enlargement {
        if self.on_screen { Enlargement::Linear } else { Enlargement::Cubic }
    }
}

/// Weight of what was known of the error of cached light, which hardly changes from frame to frame.
const MEMORY: f64 = 0.8;
/// Probe pixels for each one that is marched exactly. Colours with cached light stand for the others.
const SUBSTITUTES: usize = 6;

/// Display values of pixels.
pub type Colours = Vec<[f32; 3]>;

/// Probe pixels of one frame.
pub struct Probes<'a> {
    pipeline: &'a mut Pipeline,
    viewpoint: &'a Viewpoint,
    asked: &'a RenderSettings,
    pixels: Vec<Pixel>,
    /// Where pixels of this frame are scattered.
    scatter: Scatter,
    number: u32,
    /// Weight of each pixel, 1 on average.
    weights: Vec<f64>,
    /// Colours of the first pixels with exact shadows at the asked step.
    exact: Colours,
    /// Colours of all pixels with cached light at the asked step, once they were marched.
    cached: Option<Colours>,
    /// The exact shadows of the settings.
    exact_shadows: ShadowMode,
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
        costs.see(region.size.pixels() as f64 / asked.size.pixels() as f64);
        let mut exact = vec![[0.0; 3]; count];
        // Rays at edges take longer. Those of an even part of the probes tell the cost of a frame.
        let [even, others] = even_part(&weights[..count]);
        for (part, is_even) in [(even, true), (others, false)] {
            let list = SampleList::new(asked.size, part.iter().map(|i| pixels[*i]).collect());
            let started = Instant::now();
            let how = (exact_shadows, asked.step);
            let Some((rays, samples)) = pipeline.march_as(how, &viewpoint.camera, &list)? else {
                return Ok(None);
            };
            if let (true, Some(samples)) = (is_even, samples) {
                costs.count(samples, part.len());
                costs.guess(part.len(), started.elapsed().as_secs_f64() * 1e3);
            }
            part.iter().zip(rays).for_each(|(i, ray)| exact[*i] = shown(ray.colour));
        }
        Ok(Some(Self {
            pipeline,
            viewpoint,
            asked,
            pixels,
            scatter,
            number,
            weights,
            exact,
            cached: None,
            exact_shadows,
        }))
    }

    /// Region of the asked frame in which the volume can be seen.
    pub fn region(&self) -> Region {
        self.scatter.region()
    }

    /// Adds the errors of the frame `made` to `error`. If the frame's `light_is_cached`, colours with cached light are substitutes
    /// of exact ones, and their error is added to `errors`.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn compare(
        &mut self,
        made: Shown<'_>,
        light_is_cached: bool,
        (error, errors): (&mut ShownError, &mut Errors),
    ) -> Result<()> {
        let size = self.asked.size;
        let shown: Colours = self.pixels.iter().map(|pixel| made.colour(*pixel, size)).collect();
        let exact: Vec<f64> = self.squares(&shown, &self.exact).collect();
        if !light_is_cached {
            error.add(&exact);
            return Ok(());
        }
        match self.colours(ShadowMode::Cached, 1.0)? {
            Some(cached) => {
                self.add_light(&cached, errors);
                error.add_substituted(&self.squares(&shown, &cached).collect::<Vec<_>>(), &exact);
            }
            None => error.add(&exact),
        }
        Ok(())
    }

    /// Measures the error of cached light.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn measure_light(&mut self, errors: &mut Errors) -> Result<()> {
        if let Some(cached) = self.colours(ShadowMode::Cached, 1.0)? {
            self.add_light(&cached, errors);
        }
        Ok(())
    }

    /// Adds the error of the colours `cached` of the first pixels to `errors`.
    fn add_light(&self, cached: &Colours, errors: &mut Errors) {
        errors.light.add(self.squares(&self.exact, cached), MEMORY);
    }

    /// Size of the frames that are asked for.
    pub fn size(&self) -> FrameSize {
        self.asked.size
    }

    /// The settings that are asked for.
    pub fn asked(&self) -> &RenderSettings {
        self.asked
    }

    /// The probe pixels. Exact shadows are known of the first ones alone.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Squared errors between two colours of the first probe pixels, by their weights.
    pub fn squares(&self, a: &Colours, b: &Colours) -> impl Iterator<Item = f64> {
        weighted(squared(a.iter().copied(), b.iter().copied()), &self.weights)
    }

    /// Colours of the probe pixels with such shadows at this factor of the asked step: of all, or with exact shadows of the first
    /// ones. `None` where the device cannot march them.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn colours(&mut self, shadows: ShadowMode, factor: f64) -> Result<Option<Colours>> {
        let is_exact = shadows == self.exact_shadows;
        if is_exact && factor == 1.0 {
            return Ok(Some(self.exact.clone()));
        }
        if shadows == ShadowMode::Cached && factor == 1.0 && self.cached.is_some() {
            return Ok(self.cached.clone());
        }
        let count = if is_exact { self.exact.len() } else { self.pixels.len() };
        let list = SampleList::new(self.asked.size, self.pixels[..count].to_vec());
        let colours = self.march((shadows, factor), &list)?;
        if shadows == ShadowMode::Cached && factor == 1.0 {
            self.cached.clone_from(&colours);
        }
        Ok(colours)
    }

    /// Milliseconds that the last cached shadows took to make, if they are known.
    pub fn cached_shadows_ms(&self) -> Option<f64> {
        self.pipeline.cached_shadows_ms()
    }

    /// `count` other places of this frame and their weights, which are 1 on average.
    pub fn places(&self, count: usize) -> Vec<(Pixel, f64)> {
        self.scatter.pixels(self.number, count)
    }

    /// The exact shadows of the settings.
    pub fn exact_shadows(&self) -> ShadowMode {
        self.exact_shadows
    }

    /// Colours of the pixels of `list` with such shadows, at this factor of the asked step. `None` where the device cannot
    /// march them.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn march(
        &mut self,
        (shadows, factor): (ShadowMode, f64),
        list: &SampleList,
    ) -> Result<Option<Colours>> {
        let how = (shadows, self.asked.step * factor);
        let marched = self.pipeline.march_as(how, &self.viewpoint.camera, list)?;
        Ok(marched.map(|(rays, _)| rays.iter().map(|ray| shown(ray.colour)).collect()))
    }
}

/// Indices of a part of the probes with these `weights` that is scattered evenly, and of the others. A probe is the likelier of
/// that part, the larger its weight.
fn even_part(weights: &[f64]) -> [Vec<usize>; 2] {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let is_even = |i: &usize| weights[*i] >= largest * (*i as f64 * GOLDEN).fract();
    let (even, others) = (0..weights.len()).partition(is_even);
    [even, others]
}

/// Display values, as metrics compare them.
fn shown(colour: [f32; 3]) -> [f32; 3] {
    colour.map(|value| value.clamp(0.0, 1.0))
}

/// `errors` of pixels by their weights.
fn weighted(errors: impl Iterator<Item = f64>, weights: &[f64]) -> impl Iterator<Item = f64> {
    errors.zip(weights).map(|(error, weight)| error * weight)
}

/// Squared errors of pixels: means over red, green and blue.
pub fn squared(
    a: impl Iterator<Item = [f32; 3]>,
    b: impl Iterator<Item = [f32; 3]>,
) -> impl Iterator<Item = f64> {
    a.zip(b).map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>() / 3.0)
}

/// Mean of squared errors; 0 if there are none.
pub fn mean_square(squares: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = squares.fold((0.0, 0u32), |(sum, count), square| (sum + square, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_at_edges_are_thinned_for_costs() {
        // Half of the probes have a quarter of the others' weight.
        let weights: Vec<f64> = (0..1000).map(|i| if i % 2 == 0 { 1.6 } else { 0.4 }).collect();
        let [even, others] = even_part(&weights);
        assert_eq!(even.len() + others.len(), 1000);
        let kept = even.iter().filter(|i| **i % 2 == 1).count();
        assert_eq!(even.len() - kept, 500);
        assert!((110..140).contains(&kept), "{kept}");
        assert!(even_part(&[1.0; 9])[1].is_empty());
    }
}
