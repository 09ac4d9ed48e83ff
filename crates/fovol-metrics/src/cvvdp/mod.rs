//! ColorVideoVDP 0.5.7: Mantiuk, Hanji, Ashraf, Asano and Chapiro, "ColorVideoVDP: A visual difference predictor for
//! image, video and display distortions" (ACM TOG 43(4), 2024).
//!
//! Display values become light in three opponent channels ([`opponent`]), which temporal filters split into four
//! ([`temporal`]). A pyramid splits each into bands of contrast ([`Pyramid`], [`band`]) and a base ([`base`]).
//! Sensitivity ([`sensitivity`]) and masking, also across channels ([`masking`]), give the visible differences. Norms
//! pool them to one number ([`pooling`]).

mod band;
mod base;
mod blur;
mod masking;
mod opponent;
mod pooling;
mod power;
mod sensitivity;
mod temporal;

use crate::error::{at_least, same_size};
use crate::vdp::history::History;
use crate::vdp::pyramid::{LOWEST, MIN_SIDE, Pyramid, octaves};
use crate::vdp::{Display, check_rate};
use crate::{Error, Result};
use band::Band;
use blur::Blur;
use fovol_core::{Frame, FrameSize, stop};
use masking::Masking;
use opponent::Opponent;
use rayon::prelude::*;
use sensitivity::Sensitivity;
use temporal::TemporalFilters;

/// Measures a clip or a picture in just-objectionable differences (JOD), colour included. 10 means no difference; 9 is
/// a difference that three of four people notice.
///
/// The eye may look anywhere: there is no gaze. Keeps the frames of the last quarter second and running sums. The first
/// frame is assumed to have been shown before the clip began.
///
/// ```
/// use fovol_core::{Frame, FrameSize};
/// use fovol_metrics::{ColorVideoVdp, Display};
///
/// let size = FrameSize::new(64, 64)?;
/// let (mut grey, mut pink) = (Frame::new(size), Frame::new(size));
/// grey.fill([0.5, 0.5, 0.5, 1.0]);
/// pink.fill([0.6, 0.45, 0.5, 1.0]);
/// let mut clip = ColorVideoVdp::video(&Display::named("standard_fhd")?, 30.0)?;
/// clip.push(&grey, &grey)?;
/// assert_eq!(clip.jod(), Some(10.0));
/// clip.push(&grey, &pink)?;
/// assert!(clip.jod().unwrap() < 9.9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ColorVideoVdp {
    display: Display,
    opponent: Opponent,
    /// `None` for pictures.
    filters: Option<TemporalFilters>,
    /// Opponent channels of the reference and of the test.
    histories: [[History; 3]; 2],
    /// Channels of the reference and of the test: achromatic, red-green, violet-yellow and, in clips, transient.
    pyramids: [Vec<Pyramid>; 2],
    /// One per band, and one for the base.
    sensitivities: Vec<Sensitivity>,
    blur: Blur,
    masking: Masking,
    store: Vec<f32>,
    size: Option<FrameSize>,
    sum: f64,
    frames: usize,
}

impl ColorVideoVdp {
    /// Metric for pictures: frames are judged independently, without regard to time.
    ///
    /// # Errors
    /// Impossible display parameters.
    pub fn image(display: &Display) -> Result<Self> {
        Self::new(display, None)
    }

    /// Metric for a clip of `fps` frames a second. The published program judges a clip of one frame as a picture
    /// ([`Self::image`]).
    ///
    /// # Errors
    /// Impossible display parameters, or `fps` not above 0 and up to [`MAX_FPS`](crate::MAX_FPS).
    pub fn video(display: &Display, fps: f64) -> Result<Self> {
        Self::new(display, Some(TemporalFilters::new(check_rate(fps)?)))
    }

    fn new(display: &Display, filters: Option<TemporalFilters>) -> Result<Self> {
        display.check()?;
        Ok(Self {
            display: *display,
            opponent: Opponent::new(display),
            filters,
            histories: Default::default(),
            pyramids: Default::default(),
            sensitivities: Vec::new(),
            blur: Blur::new(),
            masking: Masking::new(),
            store: Vec::new(),
            size: None,
            sum: 0.0,
            frames: 0,
        })
    }

    /// Measures the next frame.
    ///
    /// # Errors
    /// Frames that differ in size from each other or from earlier frames, or frames with a side below
    /// [`MIN_SIDE`](crate::CVVDP_MIN_SIDE). The metric is then unchanged.
    pub fn push(&mut self, reference: &Frame, test: &Frame) -> Result<()> {
        let size = self.check(reference, test)?;
        if self.size.is_none() {
            self.prepare(size);
        }
        for (side, frame) in [reference, test].into_iter().enumerate() {
            self.fill_pyramids(side, frame);
        }
        let difference = pooling::frame(&self.bands());
        self.sum += match self.filters {
            Some(_) => pooling::moment(difference),
            None => pooling::picture(difference).powi(2),
        };
        self.frames += 1;
        Ok(())
    }

    /// Frames that the temporal filters reach back in a clip of `fps` frames a second, the current one included. Three
    /// channels of that many frames are kept, of reference and test.
    pub fn frames_kept(fps: f64) -> usize {
        TemporalFilters::new(fps).len()
    }

    /// Number of frames measured so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Quality of all frames so far in JOD, at most 10, or `None` before the first. Of several pictures it is the
    /// quality of their root-mean-square difference.
    pub fn jod(&self) -> Option<f64> {
        let pooled = match self.filters {
            Some(_) => pooling::clip(self.sum, self.frames),
            None => (self.sum / self.frames as f64).sqrt(),
        };
        (self.frames > 0).then(|| 10.0 - pooling::loss(pooled))
    }

    fn check(&self, reference: &Frame, test: &Frame) -> Result<FrameSize> {
        let size = same_size(reference, test)?;
        at_least("ColorVideoVDP", MIN_SIDE, size)?;
        match self.size.filter(|&before| before != size) {
            Some(before) => Err(Error::SizeChanged { before, now: size }),
            None => Ok(size),
        }
    }

    /// Allocates pyramids for frames of this size, and looks up the sensitivities of their bands.
    fn prepare(&mut self, size: FrameSize) {
        let (width, height) = (size.width as usize, size.height as usize);
        let bands = band_frequencies(width, height, self.display.pixels_per_degree());
        let channels = if self.filters.is_some() { 4 } else { 3 };
        let pyramid = |_| Pyramid::new(width, height, bands.len() + 1);
        self.pyramids = [0, 1].map(|_| (0..channels).map(pyramid).collect());
        self.sensitivities = bands.into_iter().chain([base::FREQUENCY]).map(Sensitivity::new).collect();
        self.store = vec![0.0; 2 * channels * size.pixels()];
        self.size = Some(size);
    }

    /// Computes the channels of the newest `frame` and their pyramids; `side` is 0 for the reference, 1 for the test.
    fn fill_pyramids(&mut self, side: usize, frame: &Frame) {
        let pyramids = &mut self.pyramids[side];
        if let Some(filters) = &self.filters {
            let histories = &mut self.histories[side];
            let mut planes =
                histories.each_mut().map(|history| history.recycle(filters.len(), frame.size().pixels()));
            self.opponent.channels(frame, planes.each_mut().map(|plane| &mut plane[..]));
            histories.iter_mut().zip(planes).for_each(|(history, plane)| history.push(plane));
            filter(filters, histories, pyramids);
        } else if let [light, red_green, violet_yellow] = &mut pyramids[..] {
            let planes = [light, red_green, violet_yellow];
            self.opponent.channels(frame, planes.map(|pyramid| &mut pyramid.finest_mut().values[..]));
        }
        pyramids.iter_mut().for_each(Pyramid::build);
    }

    /// Differences of the channels in each band, finest first, and in the base.
    fn bands(&mut self) -> Vec<[f64; 4]> {
        let Self { pyramids, sensitivities, blur, masking, store, .. } = self;
        let base = sensitivities.len() - 1;
        let measure = |(level, sensitivity): (usize, &Sensitivity)| {
            let sums = if level == base {
                base::sums(pyramids, level, sensitivity)
            } else {
                Band { pyramids, level, sensitivity, blur, masking }.sums(store)
            };
            let pixels = pyramids[0][0].level(level).values.len();
            sums.map(|sum| pooling::band(sum, pixels))
        };
        sensitivities.iter().enumerate().map(measure).collect()
    }
}

/// Filters the histories of a picture's channels into the finest levels of its four pyramids.
fn filter(filters: &TemporalFilters, histories: &[History; 3], pyramids: &mut [Pyramid]) {
    let [light, red_green, violet_yellow, change] = pyramids else {
        unreachable!("a clip has four channels");
    };
    let (steady, change) = (light.finest_mut(), change.finest_mut());
    let width = steady.width;
    let pairs = steady.values.par_chunks_mut(width).zip(change.values.par_chunks_mut(width)).enumerate();
    pairs.for_each(|(y, (steady, change))| {
        stop::point();
        histories[0].filter(&filters.light, y * width, [steady, change]);
    });
    let colours = [red_green, violet_yellow].into_iter().zip(&histories[1..]).zip(&filters.colour);
    for ((pyramid, history), taps) in colours {
        pyramid.finest_mut().values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            stop::point();
            history.filter(taps, y * width, [out]);
        });
    }
}

/// Centre frequencies of the contrast bands in cycles per degree, finest first. They end with the first one of at most
/// 0.2 cycles per degree; the base follows.
fn band_frequencies(width: usize, height: usize, pixels_per_degree: f64) -> Vec<f64> {
    let mut frequencies = octaves(width, height, pixels_per_degree);
    let above = frequencies.iter().take_while(|&&f| f > LOWEST).count();
    frequencies.truncate(above + 1);
    frequencies
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bands_end_below_the_lowest_frequency_or_where_no_more_fit() {
        let found = band_frequencies(1280, 720, 75.4024);
        assert_eq!(found.len(), 8);
        assert!((found[7] - 0.1902).abs() < 1e-3, "{found:?}");
        assert_eq!(band_frequencies(3840, 2160, 75.4024).len(), 8);
        assert_eq!(band_frequencies(16, 900, 75.4024).len(), 3);
    }
}
