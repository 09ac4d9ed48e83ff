//! FovVideoVDP 1.2: Mantiuk, Denes, Chapiro, Kaplanyan, Rufo, Bachy, Lian and Patney, "FovVideoVDP: A visible
//! difference predictor for wide field-of-view video" (ACM TOG 40(4), 2021).
//!
//! Display values become light ([`Display`]), which two temporal channels filter ([`temporal`]). A pyramid splits
//! each channel into bands of contrast ([`Pyramid`], [`band`]). Sensitivity ([`sensitivity`], and [`visual_field`]
//! for a fixed gaze) and masking ([`masking`]) give the visible differences. Norms pool them to one number
//! ([`pooling`]).

mod band;
mod masking;
mod pooling;
mod sensitivity;
mod temporal;
mod visual_field;

use crate::error::{at_least, same_size};
use crate::planes::Plane;
use crate::vdp::history::History;
use crate::vdp::pyramid::{LOWEST, MIN_SIDE, Pyramid, expand_row, octaves};
use crate::vdp::{Display, check_rate};
use crate::{Error, Result};
use band::{Band, BandDifference, View};
use fovol_core::{Frame, FrameSize, stop};
use rayon::prelude::*;
use sensitivity::SensitivityTable;
use temporal::TemporalFilters;
use visual_field::VisualField;

/// Measures a clip or a picture in just-objectionable differences (JOD). 10 means no difference; 9 is a difference
/// that three of four people notice.
///
/// Keeps the frames of the last quarter second and running sums. The first frame is assumed to have been shown before
/// the clip began.
///
/// ```
/// use fovol_core::{Frame, FrameSize};
/// use fovol_metrics::{Display, FovVideoVdp};
///
/// let size = FrameSize::new(64, 64)?;
/// let black = Frame::new(size);
/// let mut spot = black.clone();
/// spot.pixels_mut()[32 * 64 + 32] = [1.0; 4];
/// let mut clip = FovVideoVdp::video(&Display::named("standard_fhd")?, 30.0)?;
/// clip.push(&black, &black, None)?;
/// assert_eq!(clip.jod(), Some(10.0));
/// clip.push(&black, &spot, None)?;
/// assert!(clip.jod().unwrap() < 9.9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FovVideoVdp {
    display: Display,
    filters: TemporalFilters,
    /// Histories of the reference and of the test.
    histories: [History; 2],
    pyramids: Vec<Pyramid>,
    /// One per band; made when the first frame comes with a gaze.
    fields: Vec<VisualField>,
    size: Option<FrameSize>,
    sum: f64,
    frames: usize,
}

impl FovVideoVdp {
    /// Metric for pictures: frames are judged independently, without regard to time.
    ///
    /// # Errors
    /// Impossible display parameters.
    pub fn image(display: &Display) -> Result<Self> {
        Self::new(display, TemporalFilters::still())
    }

    /// Metric for a clip of `fps` frames a second.
    ///
    /// # Errors
    /// Impossible display parameters, or `fps` not above 0 and up to [`MAX_FPS`](crate::MAX_FPS).
    pub fn video(display: &Display, fps: f64) -> Result<Self> {
        Self::new(display, TemporalFilters::new(check_rate(fps)?))
    }

    fn new(display: &Display, filters: TemporalFilters) -> Result<Self> {
        display.check()?;
        Ok(Self {
            display: *display,
            filters,
            histories: Default::default(),
            pyramids: Vec::new(),
            fields: Vec::new(),
            size: None,
            sum: 0.0,
            frames: 0,
        })
    }

    /// Measures the next frame. With `gaze`, the eye looks at that point: fractions of the frame from its top left
    /// (pixel `x` of the published program is (x + ½) / width). Without it, every pixel is seen in the fovea.
    ///
    /// With a gaze, the frame is assumed to fill the display, whatever its size, as in the published program.
    ///
    /// # Errors
    /// Frames that differ in size from each other or from earlier frames, frames with a side below
    /// [`MIN_SIDE`](crate::FVVDP_MIN_SIDE), or a gaze that is not finite. The metric is then unchanged.
    pub fn push(&mut self, reference: &Frame, test: &Frame, gaze: Option<[f64; 2]>) -> Result<()> {
        self.measure([reference, test], gaze, false).map(drop)
    }

    /// Measures the next frame like [`Self::push`], and returns the difference of each pixel in JOD, row by row. A
    /// pixel's value is the loss of a frame whose pixels all differ as this one does.
    ///
    /// The differences of both channels are summed over the bands at full resolution. The transient channel counts by
    /// ¼, and all bands but the finest by ½, as in the published program's map `raw`.
    ///
    /// # Errors
    /// Errors of [`Self::push`].
    pub fn push_mapped(
        &mut self,
        reference: &Frame,
        test: &Frame,
        gaze: Option<[f64; 2]>,
    ) -> Result<Vec<f32>> {
        self.measure([reference, test], gaze, true)
    }

    /// Frames that the temporal filters reach back in a clip of `fps` frames a second, the current one included. The
    /// luminance of that many frames is kept, of reference and test.
    pub fn frames_kept(fps: f64) -> usize {
        TemporalFilters::new(fps).taps.len()
    }

    /// Number of frames measured so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Quality of all frames so far in JOD, at most 10, or `None` before the first.
    pub fn jod(&self) -> Option<f64> {
        (self.frames > 0).then(|| 10.0 - pooling::loss(self.sum / self.frames as f64))
    }

    fn measure(&mut self, frames: [&Frame; 2], gaze: Option<[f64; 2]>, mapped: bool) -> Result<Vec<f32>> {
        let size = self.check(frames, gaze)?;
        if self.size.is_none() {
            self.prepare(size);
        }
        if gaze.is_some() && self.fields.is_empty() {
            self.fields = self.fields();
        }
        for (history, frame) in self.histories.iter_mut().zip(frames) {
            let mut plane = history.recycle(self.filters.taps.len(), size.pixels());
            self.display.luminance(frame, &mut plane);
            history.push(plane);
        }
        self.fill_pyramids();
        let bands = self.bands(gaze, mapped);
        let mut totals = [0.0; 2];
        for (level, found) in bands.iter().enumerate() {
            let plane = self.pyramids[0].level(level);
            for channel in 0..2 {
                totals[channel] += pooling::band(found.sums[channel], plane.width * plane.height);
            }
        }
        self.sum += pooling::frame(totals);
        self.frames += 1;
        Ok(if mapped { self.map(bands) } else { Vec::new() })
    }

    fn check(&self, [reference, test]: [&Frame; 2], gaze: Option<[f64; 2]>) -> Result<FrameSize> {
        let size = same_size(reference, test)?;
        at_least("FovVideoVDP", MIN_SIDE, size)?;
        if let Some(before) = self.size.filter(|&before| before != size) {
            return Err(Error::SizeChanged { before, now: size });
        }
        match gaze {
            Some([x, y]) if !(x.is_finite() && y.is_finite()) => {
                Err(Error::Gaze { found: format!("{x},{y}") })
            }
            _ => Ok(size),
        }
    }

    /// Allocates pyramids for frames of this size: for reference and test, and again for the transient channel if it
    /// exists.
    fn prepare(&mut self, size: FrameSize) {
        let (width, height) = (size.width as usize, size.height as usize);
        let bands = band_frequencies(width, height, self.display.pixels_per_degree()).len();
        let planes = if self.filters.taps.len() > 1 { 4 } else { 2 };
        self.pyramids = (0..planes).map(|_| Pyramid::new(width, height, bands + 1)).collect();
        self.size = Some(size);
    }

    /// Centre frequencies of the bands, in cycles per degree.
    fn frequencies(&self) -> Vec<f64> {
        let finest = self.pyramids[0].level(0);
        band_frequencies(finest.width, finest.height, self.display.pixels_per_degree())
    }

    fn fields(&self) -> Vec<VisualField> {
        let levels = (0..self.frequencies().len()).map(|level| self.pyramids[0].level(level));
        levels.map(|plane| VisualField::new(&self.display, plane.width, plane.height)).collect()
    }

    /// Computes the temporal channels of the newest frames and their pyramids.
    fn fill_pyramids(&mut self) {
        let width = self.pyramids[0].level(0).width;
        let (sustained, transient) = self.pyramids.split_at_mut(2);
        for (i, history) in self.histories.iter().enumerate() {
            let steady = &mut sustained[i].finest_mut().values;
            let Some(transient) = transient.get_mut(i) else {
                steady.copy_from_slice(history.newest());
                continue;
            };
            let change = &mut transient.finest_mut().values;
            let rows = steady.par_chunks_mut(width).zip(change.par_chunks_mut(width)).enumerate();
            rows.for_each(|(y, (steady, change))| {
                stop::point();
                history.filter(&self.filters.taps, y * width, [steady, change]);
            });
        }
        self.pyramids.iter_mut().for_each(Pyramid::build);
    }

    fn bands(&self, gaze: Option<[f64; 2]>, mapped: bool) -> Vec<BandDifference> {
        let frequencies = self.frequencies();
        let measure = |(level, rho): (usize, &f64)| {
            let log_rho = rho.log2() as f32;
            let view = match gaze {
                None => View::Foveal(SensitivityTable::shared().foveal(log_rho)),
                Some(gaze) => {
                    let field = &self.fields[level];
                    View::Around { field, gaze: field.direction(gaze), log_rho }
                }
            };
            // A band-pass keeps about half of a pattern's amplitude; the finest band is a high-pass.
            let gain = if level == 0 { 1.0 } else { 2.0 };
            Band { pyramids: &self.pyramids, level, gain, view }.difference(mapped)
        };
        frequencies.iter().enumerate().map(measure).collect()
    }

    /// Sums the bands' difference maps at full resolution, in JOD.
    fn map(&self, bands: Vec<BandDifference>) -> Vec<f32> {
        let mut coarser: Option<Plane> = None;
        for (level, found) in bands.into_iter().enumerate().rev() {
            let like = self.pyramids[0].level(level);
            let gain = if level == 0 { 1.0 } else { 0.5 };
            let mut sum = Plane { values: found.map, ..*like };
            sum.values.par_chunks_mut(like.width).enumerate().for_each_init(
                || (Vec::new(), vec![0.0; like.width]),
                |(line, expanded), (y, row)| {
                    if let Some(coarser) = &coarser {
                        expand_row(coarser, y, line, expanded);
                    }
                    for (value, below) in row.iter_mut().zip(expanded.iter()) {
                        *value = gain * *value + below;
                    }
                },
            );
            coarser = Some(sum);
        }
        let mut values = coarser.map_or_else(Vec::new, |plane| plane.values);
        values.par_iter_mut().for_each(|v| *v = pooling::loss(f64::from(v.max(0.0))) as f32);
        values
    }
}

/// Centre frequencies of the contrast bands in cycles per degree, finest first; at least one. Lower frequencies are the
/// base, which is not judged.
fn band_frequencies(width: usize, height: usize, pixels_per_degree: f64) -> Vec<f64> {
    let mut frequencies = octaves(width, height, pixels_per_degree);
    let judged = frequencies.iter().take_while(|&&f| f > LOWEST).count();
    frequencies.truncate(judged.max(1));
    frequencies
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_720p_frame_on_the_4k_display_has_the_published_bands() {
        let found = band_frequencies(1280, 720, 75.4024);
        let expected = [37.70, 12.17, 6.08, 3.04, 1.52, 0.761, 0.380];
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            assert!((f / e - 1.0).abs() < 2e-3, "{f} {e}");
        }
        assert_eq!(band_frequencies(1280, 720, 0.3).len(), 1);
    }
}
