use crate::Result;
use fovol_core::{Frame, SampleList, SampleMask};
use fovol_render::cpu;
use fovol_render::scene::RayResult;
use std::time::Instant;

/// Picture whose pixels are replaced by marched ones, piece by piece.
#[derive(Debug, Clone)]
pub struct PiecedPicture {
    frame: Frame,
    measured: SampleMask,
    pixel_ms: f64,
}

impl PiecedPicture {
    /// Starts with `frame`, whose pixels of `measured` are marched already. `pixel_ms` estimates the milliseconds of a pixel; 0 if they
    /// are not known.
    pub fn new(frame: Frame, measured: SampleMask, pixel_ms: f64) -> Self {
        Self { frame, measured, pixel_ms }
    }

    /// Pixels of `due` that are not yet marched.
    pub fn missing(&self, mut due: SampleMask) -> SampleList {
        for (word, measured) in due.words_mut().iter_mut().zip(self.measured.words()) {
            *word &= !measured;
        }
        cpu::compact(&due)
    }

    /// Replaces the pixels of `list` by what `march` returns for them, and learns how long they take.
    ///
    /// # Errors
    /// Errors of `march`. The picture is then unchanged.
    pub fn take(
        &mut self,
        list: &SampleList,
        march: impl FnOnce(&SampleList) -> Result<Vec<RayResult>>,
    ) -> Result<()> {
        if list.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let marched = march(list)?;
        let ms = started.elapsed().as_secs_f64() * 1e3 / list.len() as f64;
        self.pixel_ms = if self.pixel_ms > 0.0 { 0.5 * (self.pixel_ms + ms) } else { ms };
        let width = self.frame.size().width;
        for (pixel, marched) in list.pixels().iter().zip(marched) {
            let [r, g, b] = marched.colour;
            self.frame.pixels_mut()[pixel.index(width)] = [r, g, b, 1.0];
            self.measured.set(pixel.x.into(), pixel.y.into());
        }
        Ok(())
    }

    /// The picture so far.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Pixels that are marched.
    pub fn measured(&self) -> &SampleMask {
        &self.measured
    }

    /// Milliseconds of a pixel, as the last pieces took; 0 if they are not known.
    pub fn pixel_ms(&self) -> f64 {
        self.pixel_ms
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    #[test]
    fn marched_pixels_replace_those_of_the_picture_once() {
        let size = FrameSize::new(4, 2).unwrap();
        let mut picture = PiecedPicture::new(Frame::new(size), SampleMask::none(size), 0.0);
        let mut due = SampleMask::none(size);
        due.set(1, 0);
        due.set(3, 1);
        let list = picture.missing(due.clone());
        let red = |list: &SampleList| {
            let ray =
                RayResult { colour: [1.0, 0.0, 0.0], unshadowed: [1.0, 0.0, 0.0], opacity: 1.0, depth: 1.0 };
            Ok(vec![ray; list.len()])
        };
        picture.take(&list, red).unwrap();
        assert_eq!(
            (picture.frame().pixel(3, 1), picture.frame().pixel(0, 0)[0]),
            ([1.0, 0.0, 0.0, 1.0], 0.0)
        );
        assert!(picture.pixel_ms() > 0.0 && picture.measured().contains(1, 0));
        assert!(picture.missing(due).is_empty());
        assert_eq!(picture.missing(SampleMask::full(size)).len(), 6);
    }
}
