//! Refinement of a resting view to the full frame.

use fovolnet::core::{Camera, Fovea, Frame, SampleMask};
use fovolnet::render::cpu;
use fovolnet::render::noise::Noise;
use fovolnet::{Pipeline, RenderSettings, Result};
use std::time::Instant;

/// A picture whose pixels are marched in the order of blue noise, around the gaze first, until all are. The last picture equals
/// a frame with every pixel marched.
pub struct Refinement {
    camera: Camera,
    noise: Noise,
    picture: Frame,
    measured: SampleMask,
    /// Density below which all pixels are marched.
    level: f64,
    /// Milliseconds per pixel.
    pixel_ms: f64,
}

/// Share of the pixels in the first piece, before their cost is known.
const FIRST_SHARE: f64 = 0.02;
/// Standard deviation of the region around the gaze that is refined first, in widths of the picture.
const SIGMA: f64 = 0.12;

impl Refinement {
    /// Starts with `picture`, an approximation of the full frame from `camera` that `settings` ask for.
    pub fn new(settings: &RenderSettings, camera: Camera, picture: Frame) -> Self {
        let measured = SampleMask::none(picture.size());
        let noise = Noise::new(settings.noise, settings.seed);
        Self { camera, noise, picture, measured, level: 0.0, pixel_ms: 0.0 }
    }

    /// Marches about as many pixels as `ms` milliseconds allow, near `gaze` first. The pipeline has the asked size and shadows.
    ///
    /// # Errors
    /// A lost device.
    pub fn advance(&mut self, pipeline: &mut Pipeline, gaze: [f64; 2], ms: f64) -> Result<()> {
        let pixels = self.picture.size().pixels() as f64;
        let fitting = if self.pixel_ms > 0.0 { ms / self.pixel_ms / pixels } else { FIRST_SHARE };
        let share = (self.measured.density() + fitting).min(1.0);
        let list = loop {
            // Around the gaze more pixels are due than the level says, so levels rise until there are enough.
            self.level = if share >= 1.0 { 1.0 } else { self.level.max(0.5 * share) + 0.25 * fitting };
            let mut wanted = self.due(gaze);
            let due = wanted.density();
            for (word, measured) in wanted.words_mut().iter_mut().zip(self.measured.words()) {
                *word &= !measured;
            }
            if self.level >= 1.0 || due >= share {
                break cpu::compact(&wanted);
            }
        };
        if list.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let marched = pipeline.march(&self.camera, &list)?;
        let ms = started.elapsed().as_secs_f64() * 1e3 / list.len() as f64;
        self.pixel_ms = if self.pixel_ms > 0.0 { 0.5 * (self.pixel_ms + ms) } else { ms };
        let width = self.picture.size().width;
        for (pixel, marched) in list.pixels().iter().zip(marched) {
            let [r, g, b] = marched.colour;
            self.picture.pixels_mut()[pixel.index(width)] = [r, g, b, 1.0];
            self.measured.set(pixel.x.into(), pixel.y.into());
        }
        Ok(())
    }

    /// Pixels that should be marched by now.
    fn due(&self, gaze: [f64; 2]) -> SampleMask {
        let size = self.picture.size();
        if self.level >= 1.0 {
            return SampleMask::full(size);
        }
        let sigma = SIGMA * self.level.sqrt();
        cpu::mask(&Fovea { base: self.level, sigma, gaze }, size, &self.noise, 0)
    }

    /// The picture so far.
    pub fn picture(&self) -> &Frame {
        &self.picture
    }

    /// Share of the pixels that are marched, 0 to 1.
    pub fn share(&self) -> f64 {
        if self.level >= 1.0 { 1.0 } else { self.measured.density() }
    }
}
