//! Refinement of a resting view to the full frame.

use fovolnet::core::{Camera, Fovea, Frame, SampleMask};
use fovolnet::render::cpu;
use fovolnet::render::noise::Noise;
use fovolnet::{PiecedPicture, Pipeline, RenderSettings, Result};

/// A picture whose pixels are marched in the order of blue noise, around the gaze first, until all are. The last picture equals
/// a frame with every pixel marched.
pub struct Refinement {
    camera: Camera,
    noise: Noise,
    picture: PiecedPicture,
    /// Density below which all pixels are marched.
    level: f64,
}

/// Share of the pixels in the first piece, before their cost is known.
const FIRST_SHARE: f64 = 0.02;
/// Least share of the pixels in a piece.
const LEAST_SHARE: f64 = 0.004;
/// Steps of the search for the level of a piece.
const HALVINGS: usize = 5;
/// Standard deviation of the region around the gaze that is refined first, in widths of the picture.
const SIGMA: f64 = 0.12;

impl Refinement {
    /// Starts with `picture`, an approximation of the full frame from `camera` that `settings` ask for.
    pub fn new(settings: &RenderSettings, camera: Camera, picture: Frame) -> Self {
        let measured = SampleMask::none(picture.size());
        let picture = PiecedPicture::new(picture, measured, 0.0);
        let noise = Noise::new(settings.noise, settings.seed);
        Self { camera, noise, picture, level: 0.0 }
    }

    /// Marches about as many pixels as `ms` milliseconds allow, near `gaze` first. The pipeline has the asked size and shadows.
    ///
    /// # Errors
    /// A lost device.
    pub fn advance(&mut self, pipeline: &mut Pipeline, gaze: [f64; 2], ms: f64) -> Result<()> {
        let pixels = self.picture.frame().size().pixels() as f64;
        let pixel_ms = self.picture.pixel_ms();
        let fitting = if pixel_ms > 0.0 { ms / pixel_ms / pixels } else { FIRST_SHARE };
        // Where other programs hold a piece up, its pixels seem to take long.
        let mut piece = fitting.max(LEAST_SHARE);
        let list = loop {
            let share = (self.picture.measured().density() + piece).min(1.0);
            self.level = self.level_of(gaze, share);
            let list = self.picture.missing(self.due(gaze, self.level));
            if !list.is_empty() {
                break list;
            }
            if self.level >= 1.0 {
                return Ok(());
            }
            // The noise has fewer levels than the picture has pixels.
            piece *= 2.0;
        };
        self.picture.take(&list, |list| pipeline.march(&self.camera, list))
    }

    /// Least level at which `share` of the pixels are due, about.
    fn level_of(&self, gaze: [f64; 2], share: f64) -> f64 {
        if share >= 1.0 {
            return 1.0;
        }
        // Around the gaze more pixels are due than the level says.
        let (mut low, mut high) = (self.level.min(share), share);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.due(gaze, middle).density() < share { low = middle } else { high = middle }
        }
        high
    }

    /// Pixels that are due at `level`.
    fn due(&self, gaze: [f64; 2], level: f64) -> SampleMask {
        let size = self.picture.frame().size();
        if level >= 1.0 {
            return SampleMask::full(size);
        }
        let sigma = SIGMA * level.sqrt();
        cpu::mask(&Fovea { base: level, sigma, gaze }, size, &self.noise, 0)
    }

    /// The picture so far.
    pub fn picture(&self) -> &Frame {
        self.picture.frame()
    }

    /// Share of the pixels that are marched, 0 to 1.
    pub fn share(&self) -> f64 {
        if self.level >= 1.0 { 1.0 } else { self.picture.measured().density() }
    }
}
