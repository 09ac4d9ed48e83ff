//! Frames with a transparent background.

use super::{Pipeline, RenderedFrame, Timings, Viewpoint};
use crate::{RenderSettings, Result};
use fovol_core::Frame;

impl Pipeline {
    /// Renders frame `i` with a transparent background, in straight alpha. Each frame is rendered over black and over
    /// white, and the difference gives its alpha. The sparse frame is the one over black.
    pub(super) fn render_without_background(
        &mut self,
        i: u32,
        viewpoint: &Viewpoint,
    ) -> Result<RenderedFrame> {
        let [black, white] = self.before_black_and_white(|pipeline| pipeline.render_from(i, viewpoint))?;
        let (b, w) = (black.timings, white.timings);
        let timings = Timings { march: b.march + w.march, total: b.total + w.total, ..b };
        Ok(RenderedFrame { frame: difference(&black.frame, &white.frame), timings, ..black })
    }

    /// Reference of frame `i` with a transparent background, in straight alpha.
    pub(super) fn transparent_reference(&mut self, i: u32) -> Result<Frame> {
        let [black, white] = self.before_black_and_white(|pipeline| pipeline.opaque_reference(i))?;
        Ok(difference(&black, &white))
    }

    /// Results of `make` with a black background and with a white one.
    fn before_black_and_white<T>(&mut self, mut make: impl FnMut(&mut Self) -> Result<T>) -> Result<[T; 2]> {
        let settings = self.settings.clone();
        let mut before = |background: f64| {
            let background = [background; 3];
            self.change(&RenderSettings { transparent: false, background, ..settings.clone() })?;
            make(self)
        };
        let both = before(0.0).and_then(|black| Ok([black, before(1.0)?]));
        // Restore the settings, also after an error.
        self.change(&settings)?;
        both
    }
}

/// Frame in straight alpha from its pictures over `black` and over `white`.
fn difference(black: &Frame, white: &Frame) -> Frame {
    let mut frame = Frame::new(black.size());
    let pairs = black.pixels().iter().zip(white.pixels());
    for (out, (black, white)) in frame.pixels_mut().iter_mut().zip(pairs) {
        let shows_through = (0..3).map(|c| white[c] - black[c]).sum::<f32>() / 3.0;
        let alpha = (1.0 - shows_through).clamp(0.0, 1.0);
        let [r, g, b] = std::array::from_fn(|c| if alpha > 0.0 { black[c] / alpha } else { 0.0 });
        *out = [r, g, b, alpha];
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Device, Sampling, SpeedSettings, VolumeSettings, open_volume};

    fn pipeline(settings: &RenderSettings) -> Result<Pipeline> {
        let volume = open_volume("head", &VolumeSettings { dims: Some([24; 3]), ..Default::default() })?;
        let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
        Pipeline::new(&volume, settings, &speed)
    }

    fn settings() -> RenderSettings {
        RenderSettings {
            size: "60x40".parse().unwrap(),
            background: [0.2, 0.4, 0.8],
            ..RenderSettings::default()
        }
    }

    #[test]
    fn a_transparent_frame_before_a_background_is_the_opaque_one() {
        let opaque = pipeline(&settings()).unwrap().render(3).unwrap().frame;
        let settings = RenderSettings { transparent: true, ..settings() };
        let mut pipeline = pipeline(&settings).unwrap();
        let transparent = pipeline.render(3).unwrap().frame;
        assert_eq!(pipeline.reference(3).unwrap(), transparent);
        assert_eq!(transparent.pixel(0, 0), [0.0; 4]);
        assert!(transparent.pixels().iter().any(|p| p[3] > 0.9));
        for (o, t) in opaque.pixels().iter().zip(transparent.pixels()) {
            for (c, background) in [0.2f32, 0.4, 0.8].into_iter().enumerate() {
                let over = t[c] * t[3] + background * (1.0 - t[3]);
                assert!((over - o[c]).abs() < 1e-4, "{o:?} {t:?}");
            }
        }
    }

    #[test]
    fn what_is_reconstructed_is_not_transparent_and_the_error_says_what_to_do() {
        let sparse = RenderSettings { sampling: Sampling::Compact, transparent: true, ..settings() };
        assert!(pipeline(&sparse).unwrap_err().to_string().contains("--sampling full"));
        let mut pipeline = pipeline(&settings()).unwrap();
        assert!(pipeline.change(&sparse).is_err());
        assert_eq!(pipeline.render(0).unwrap().frame.pixel(0, 0)[3], 1.0);
    }
}
