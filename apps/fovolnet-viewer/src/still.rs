//! A view that stands still becomes the full frame.

use anyhow::Result;
use fovolnet::core::{Camera, Fovea, Frame, SampleMask};
use fovolnet::metrics::{Display, FovVideoVdp, psnr};
use fovolnet::render::cpu;
use fovolnet::render::noise::Noise;
use fovolnet::{Pipeline, RenderSettings, RenderedFrame};
use std::time::Instant;

/// A frame whose pixels are measured one after the other, in the order of the noise that chose the first of them, until all
/// are: then it is the frame that `--sampling full` renders.
#[derive(Debug)]
pub struct Still {
    camera: Camera,
    fovea: Fovea,
    noise: Noise,
    index: u32,
    /// What was made of the first samples.
    reconstructed: Frame,
    /// The same, with everything that was measured since.
    picture: Frame,
    measured: SampleMask,
    /// Milliseconds a pixel.
    pixel_ms: f64,
    /// The noise below which everything is measured.
    level: f64,
}

/// How good the reconstruction was, as the full frame shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Peak signal-to-noise ratio in dB.
    pub psnr: f64,
    /// FovVideoVDP without foveation, in just-objectionable differences from 10.
    pub jod: Option<f64>,
}

/// Milliseconds between two pictures that are shown while one converges.
const PIECE_MS: f64 = 70.0;

impl Still {
    /// Begins with what a pipeline of `settings` rendered from `camera`.
    pub fn new(settings: &RenderSettings, camera: Camera, fovea: Fovea, first: RenderedFrame) -> Self {
        let noise = Noise::new(settings.noise.unwrap_or_default(), settings.seed.unwrap_or(0));
        let pixel_ms = (first.timings.mask + first.timings.march) / first.samples.max(1) as f64;
        Self {
            camera,
            fovea,
            noise,
            index: first.index,
            picture: first.frame.clone(),
            reconstructed: first.frame,
            measured: first.mask,
            pixel_ms,
            level: 0.0,
        }
    }

    /// Measures more pixels of the frame.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn advance(&mut self, pipeline: &mut Pipeline) -> Result<()> {
        let pixels = self.picture.size().pixels() as f64;
        let share = PIECE_MS / self.pixel_ms.max(1e-9) / pixels;
        self.level = (self.level + share.max(1e-3)).min(1.0);
        let mut wanted = self.below(self.level);
        for (word, measured) in wanted.words_mut().iter_mut().zip(self.measured.words()) {
            *word &= !measured;
        }
        let list = cpu::compact(&wanted);
        if list.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let marched = pipeline.march(&self.camera, &list)?;
        let ms = started.elapsed().as_secs_f64() * 1e3 / list.len() as f64;
        self.pixel_ms = 0.5 * (self.pixel_ms + ms);
        let width = self.picture.size().width;
        for (pixel, marched) in list.pixels().iter().zip(marched) {
            let [r, g, b] = marched.colour;
            self.picture.pixels_mut()[pixel.index(width)] = [r, g, b, 1.0];
            self.measured.set(pixel.x.into(), pixel.y.into());
        }
        Ok(())
    }

    /// The pixels whose noise lies below `level`.
    fn below(&self, level: f64) -> SampleMask {
        let size = self.picture.size();
        if level >= 1.0 {
            return SampleMask::full(size);
        }
        let everywhere = Fovea { base: level, sigma: 0.0, gaze: self.fovea.gaze };
        cpu::mask(&everywhere, size, &self.noise, self.index)
    }

    /// Whether every pixel is measured.
    pub fn is_complete(&self) -> bool {
        self.level >= 1.0
    }

    /// The share of pixels that are measured.
    pub fn share(&self) -> f64 {
        self.measured.density()
    }

    /// How samples were chosen.
    pub fn fovea(&self) -> &Fovea {
        &self.fovea
    }

    /// The frame as far as it is measured; reconstructed elsewhere.
    pub fn picture(&self) -> &Frame {
        &self.picture
    }

    /// The frame as it was made of its first samples.
    pub fn reconstructed(&self) -> &Frame {
        &self.reconstructed
    }

    /// Which pixels are measured.
    pub fn measured(&self) -> &SampleMask {
        &self.measured
    }

    /// How good the reconstruction was, where the frame is complete.
    pub fn quality(&self) -> Option<Quality> {
        self.is_complete().then(|| Quality {
            psnr: psnr(&self.picture, &self.reconstructed).unwrap_or(0.0),
            jod: jod(&self.picture, &self.reconstructed),
        })
    }
}

/// FovVideoVDP of `test`; none for frames that are too small for it.
fn jod(reference: &Frame, test: &Frame) -> Option<f64> {
    let display = Display::named("standard_4k").ok()?;
    let mut measure = FovVideoVdp::image(&display).ok()?;
    measure.push(reference, test, None).ok()?;
    measure.jod()
}
