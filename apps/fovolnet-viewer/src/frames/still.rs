//! Progressive refinement of still views to the full frame.

use anyhow::Result;
use fovolnet::core::{Camera, Fovea, Frame, FrameSize, Pixel, SampleList, SampleMask, ShadowMode};
use fovolnet::metrics::{Display, FovVideoVdp, psnr};
use fovolnet::render::cpu;
use fovolnet::render::noise::Noise;
use fovolnet::{PiecedPicture, Pipeline, RenderSettings, RenderedFrame};

/// Progressively refined frame. Pixels are rendered in the order of the mask's noise until all are done. The result
/// equals `--sampling full`.
#[derive(Debug)]
pub struct Still {
    camera: Camera,
    fovea: Fovea,
    noise: Noise,
    index: u32,
    /// Reconstruction from the first samples.
    reconstructed: Frame,
    /// The reconstruction, with all pixels replaced that were rendered since.
    picture: PiecedPicture,
    /// Noise threshold below which all pixels are rendered.
    level: f64,
    /// Frame with exact shadows, if the picture has cached ones.
    reference: Option<Reference>,
}

/// Frame with exact shadows, rendered row by row, for comparison with cached shadows.
#[derive(Debug)]
struct Reference {
    picture: PiecedPicture,
    /// Number of rendered rows.
    rows: u32,
}

/// Quality of the reconstruction, compared with the full frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// PSNR in dB.
    pub psnr: f64,
    /// FovVideoVDP without foveation, in JOD; 10 is best. `None` for frames too small to measure.
    pub jod: Option<f64>,
}

/// Milliseconds of rendering between two displayed refinements.
const PIECE_MS: f64 = 70.0;

impl Still {
    /// Starts with a frame `first` that a pipeline with `settings` rendered from `camera`.
    pub fn new(settings: &RenderSettings, camera: Camera, fovea: Fovea, first: RenderedFrame) -> Self {
        let noise = Noise::new(settings.noise, settings.seed);
        let pixel_ms = (first.timings.mask + first.timings.march) / first.samples.max(1) as f64;
        let is_exact = settings.shadows != ShadowMode::Cached;
        let reference = (!is_exact).then(|| Reference::new(first.frame.size(), pixel_ms));
        Self {
            camera,
            fovea,
            noise,
            index: first.index,
            picture: PiecedPicture::new(first.frame.clone(), first.mask, pixel_ms),
            reconstructed: first.frame,
            level: 0.0,
            reference,
        }
    }

    /// Renders more pixels of the frame; once it is complete, more of the reference.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn advance(&mut self, pipeline: &mut Pipeline) -> Result<()> {
        if self.is_complete() {
            return match &mut self.reference {
                Some(reference) => reference.advance(pipeline, &self.camera),
                None => Ok(()),
            };
        }
        let pixels = self.picture.frame().size().pixels() as f64;
        let share = PIECE_MS / self.picture.pixel_ms().max(1e-9) / pixels;
        self.level = (self.level + share.max(1e-3)).min(1.0);
        let list = self.picture.missing(self.below(self.level));
        Ok(self.picture.take(&list, |list| pipeline.march(&self.camera, list))?)
    }

    /// Pixels whose noise is below `level`.
    fn below(&self, level: f64) -> SampleMask {
        let size = self.picture.frame().size();
        if level >= 1.0 {
            return SampleMask::full(size);
        }
        let everywhere = Fovea { base: level, sigma: 0.0, gaze: self.fovea.gaze };
        cpu::mask(&everywhere, size, &self.noise, self.index)
    }

    /// Whether every pixel is rendered.
    pub fn is_complete(&self) -> bool {
        self.level >= 1.0
    }

    /// Whether frame and reference are complete.
    pub fn is_done(&self) -> bool {
        self.is_complete() && self.reference.as_ref().is_none_or(Reference::is_complete)
    }

    /// Fraction of pixels that are rendered.
    pub fn share(&self) -> f64 {
        self.picture.measured().density()
    }

    /// Fovea of the first mask.
    pub fn fovea(&self) -> &Fovea {
        &self.fovea
    }

    /// Current picture: rendered pixels, reconstructed elsewhere.
    pub fn picture(&self) -> &Frame {
        self.picture.frame()
    }

    /// Reconstruction from the first samples.
    pub fn reconstructed(&self) -> &Frame {
        &self.reconstructed
    }

    /// Mask of rendered pixels.
    pub fn measured(&self) -> &SampleMask {
        self.picture.measured()
    }

    /// Quality of the reconstruction against the full frame with exact shadows; `None` until that is complete.
    pub fn quality(&self) -> Option<Quality> {
        let exact = self.reference.as_ref().map_or(&self.picture, |reference| &reference.picture).frame();
        self.is_done().then(|| Quality {
            psnr: psnr(exact, &self.reconstructed).unwrap_or(0.0),
            jod: jod(exact, &self.reconstructed),
        })
    }
}

impl Reference {
    /// Empty reference with the estimated cost `pixel_ms` in milliseconds per pixel.
    fn new(size: FrameSize, pixel_ms: f64) -> Self {
        Self { picture: PiecedPicture::new(Frame::new(size), SampleMask::none(size), pixel_ms), rows: 0 }
    }

    fn is_complete(&self) -> bool {
        self.rows >= self.picture.frame().size().height
    }

    /// Renders more rows, seen from `camera`.
    fn advance(&mut self, pipeline: &mut Pipeline, camera: &Camera) -> Result<()> {
        let size = self.picture.frame().size();
        let row_ms = self.picture.pixel_ms().max(1e-9) * f64::from(size.width);
        let rows = self.rows..(self.rows + (PIECE_MS / row_ms).max(1.0) as u32).min(size.height);
        let pixel = |x, y| Pixel { x: x as u16, y: y as u16 };
        let pixels: Vec<Pixel> =
            rows.clone().flat_map(|y| (0..size.width).map(move |x| pixel(x, y))).collect();
        let list = SampleList::new(size, pixels);
        self.picture.take(&list, |list| pipeline.march_reference(camera, list))?;
        self.rows = rows.end;
        Ok(())
    }
}

/// FovVideoVDP of `test`; `None` for frames that are too small.
fn jod(reference: &Frame, test: &Frame) -> Option<f64> {
    let display = Display::named("standard_4k").ok()?;
    let mut measure = FovVideoVdp::image(&display).ok()?;
    measure.push(reference, test, None).ok()?;
    measure.jod()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::{Device, OpenVolume, Sampling, SpeedSettings, Viewpoint, VolumeSettings, open_volume};

    fn pipeline(volume: &OpenVolume, settings: &RenderSettings) -> Pipeline {
        let speed = SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() };
        Pipeline::new(volume, settings, &speed).unwrap()
    }

    #[test]
    fn frames_with_cached_shadows_are_compared_with_exact_ones() {
        let read = VolumeSettings { dims: Some([32; 3]), ..VolumeSettings::default() };
        let volume = open_volume("head", &read).unwrap();
        let cached = RenderSettings {
            size: "64x48".parse().unwrap(),
            sampling: Sampling::Compact,
            shadows: ShadowMode::Cached,
            ..RenderSettings::default()
        };
        let full = |shadows| {
            let settings = RenderSettings { shadows, sampling: Sampling::Full, ..cached.clone() };
            pipeline(&volume, &settings).render(0).unwrap().frame
        };
        let mut pipeline = pipeline(&volume, &cached);
        let (camera, fovea) = (pipeline.camera(0), pipeline.fovea(0));
        let first = pipeline.render_from(0, &Viewpoint { camera, fovea }).unwrap();
        let mut still = Still::new(&cached, camera, fovea, first);
        while !still.is_done() {
            assert_eq!(still.quality(), None);
            still.advance(&mut pipeline).unwrap();
        }
        assert!(*still.picture() == full(ShadowMode::Cached), "the picture is as the session says");
        let exact = full(ShadowMode::On);
        assert!(exact != *still.picture());
        let found = still.quality().unwrap().psnr;
        assert_eq!(found, psnr(&exact, still.reconstructed()).unwrap());
        assert_ne!(found, psnr(still.picture(), still.reconstructed()).unwrap());
    }
}
