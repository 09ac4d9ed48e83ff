use crate::console::{self, JsonOutput, Progress};
use crate::frame_source::FrameSource;
use crate::{interrupt, outputs};
use anyhow::{Context, Result, bail};
use fovolnet::core::memory::Estimate;
use fovolnet::core::{Frame, FrameSize, Region};
use fovolnet::io::video::{self, FrameRate};
use fovolnet::metrics::{ClipQuality, ColorVideoVdp, Display, Error, FovVideoVdp, FrameQuality};
use fovolnet::parse;
use serde::Serialize;
use std::path::PathBuf;

/// Compare two folders of frames, two clips, or two pictures
///
/// Prints PSNR, SSIM, MS-SSIM, tPSNR and two JODs: FovVideoVDP, and ColorVideoVDP, which judges colours too.
#[derive(clap::Args)]
pub struct Metrics {
    /// Folder of reference frames (reference_*, else frame_*, else all pictures), a clip, or a picture
    reference: PathBuf,
    /// Folder of frames to judge (frame_*, else all pictures), a clip, or a picture
    test: PathBuf,
    #[command(flatten)]
    viewing: Viewing,
    #[command(flatten)]
    json: JsonOutput,
}

/// Viewing conditions of FovVideoVDP and ColorVideoVDP.
#[derive(clap::Args)]
struct Viewing {
    /// Frames a second, for both JODs: a number above 0 up to 1000, or a fraction, as 30000/1001
    #[arg(long, value_name = "F|N/D", default_value = "30", value_parser = frame_rate)]
    fps: f64,
    /// The display, for both JODs: standard_4k, standard_fhd or standard_hmd
    #[arg(long, value_name = "NAME", default_value = "standard_4k", value_parser = Display::named)]
    display: Display,
    /// Where the eye looks, for a foveated JOD of FovVideoVDP: from the top left, as fractions of the frame where both
    /// are 0 to 1 (as in --gaze), else in pixels; without it, and for ColorVideoVDP, the eye looks everywhere
    #[arg(long, value_name = "X,Y", value_parser = parse::numbers::<2>)]
    fixation: Option<[f64; 2]>,
}

/// Values that the metrics hold per pixel of a frame besides earlier frames, for the reference or for the test: pyramids
/// of two and of four channels, and a record of four.
const BANDS: u64 = 12;

/// Advice for errors about clips that need too much memory.
const SMALLER_CLIPS: &str = "smaller frames need less, and so does a smaller --fps";

/// Parses a frame rate: a number or a fraction.
fn frame_rate(text: &str) -> Result<f64, String> {
    if !text.contains('/') {
        return parse::number(text);
    }
    let rate: FrameRate = text.parse()?;
    Ok(f64::from(rate.numerator()) / f64::from(rate.denominator()))
}

impl Viewing {
    /// Metrics for a clip of `frames` frames; a single frame counts as a still picture.
    fn judges(&self, frames: usize) -> Result<Judges> {
        let display = &self.display;
        let light = FovVideoVdp::video(display, self.fps)?;
        let colour = ColorVideoVdp::video(display, self.fps)?;
        if frames != 1 {
            return Ok(Judges { light, colour });
        }
        Ok(Judges { light: FovVideoVdp::image(display)?, colour: ColorVideoVdp::image(display)? })
    }

    /// Estimate of the memory to compare two clips of `frames` frames, of the sizes of their first frames.
    fn estimate(&self, [a, b]: [FrameSize; 2], frames: usize) -> Estimate {
        let both = (a.pixels() + b.pixels()) as u64;
        // Of clips, the next frames are read while the last ones are kept for comparison.
        let kept = if frames == 1 { 1 } else { 2 };
        let light = FovVideoVdp::frames_kept(self.fps).min(frames);
        let colour = ColorVideoVdp::frames_kept(self.fps).min(frames);
        let values = size_of::<f32>() as u64;
        Estimate::new(format!("comparing frames of {a}"))
            .with(format!("{} frames", 2 * kept), both * kept * size_of::<[f32; 4]>() as u64)
            .with(format!("the luminance of {} frames", 2 * light), both * light as u64 * values)
            .with(format!("the opponent colours of {} frames", 2 * colour), both * colour as u64 * 3 * values)
            .with("bands of contrast", both * BANDS * values)
    }

    /// Gaze as fractions of a frame.
    fn gaze(&self, size: FrameSize) -> Option<[f64; 2]> {
        self.fixation.map(|[x, y]| {
            let fractions = [x, y].iter().all(|v| (0.0..=1.0).contains(v));
            let middle = |v: f64, side: u32| (v + 0.5) / f64::from(side);
            if fractions { [x, y] } else { [middle(x, size.width), middle(y, size.height)] }
        })
    }
}

/// The metrics that model a viewer.
struct Judges {
    light: FovVideoVdp,
    colour: ColorVideoVdp,
}

impl Judges {
    /// Measures the next frame. Frames that are too small have no JOD, just as they have no SSIM.
    fn push(&mut self, a: &Frame, b: &Frame, gaze: Option<[f64; 2]>) -> Result<(), Error> {
        match self.light.push(a, b, gaze).and_then(|()| self.colour.push(a, b)) {
            Err(Error::TooSmall { .. }) => Ok(()),
            other => other,
        }
    }
}

#[derive(Serialize)]
struct Report {
    frames: Vec<FrameQuality>,
    psnr: f64,
    ssim: Option<f64>,
    ms_ssim: Option<f64>,
    tpsnr: Option<f64>,
    /// JOD of FovVideoVDP.
    jod: Option<f64>,
    /// JOD of ColorVideoVDP.
    cvvdp_jod: Option<f64>,
}

impl Metrics {
    pub fn run(self) -> Result<()> {
        let mut reference = FrameSource::open(&self.reference, &["reference_", "frame_", ""])?;
        let mut test = FrameSource::open(&self.test, &["frame_", ""])?;
        if reference.len() != test.len() {
            bail!(
                "{} has {} frames and {} has {}; give two clips of equal length",
                self.reference.display(),
                reference.len(),
                self.test.display(),
                test.len()
            );
        }
        outputs::check(self.json.file())?;
        let mut progress = Progress::new("comparing", reference.len() as u64);
        let mut clip = ClipQuality::new();
        let mut judges = self.viewing.judges(reference.len())?;
        let mut is_cropped = false;
        let mut frames = Vec::new();
        for i in 0..reference.len() {
            interrupt::check("nothing was written")?;
            let (a, b) = (reference.next()?, test.next()?);
            if i == 0 {
                self.viewing.estimate([a.size(), b.size()], reference.len()).check(SMALLER_CLIPS)?;
            }
            let (a, b) = match [a.size(), b.size()].map(|size| (size, video::padded_to_even(size))) {
                [(of_a, padded), (of_b, _)] if test.is_video() && of_a != of_b && padded == of_b => {
                    (a, crop(&b, of_a, &mut is_cropped))
                }
                [(of_a, _), (of_b, padded)] if reference.is_video() && of_a != of_b && padded == of_a => {
                    (crop(&a, of_b, &mut is_cropped), b)
                }
                _ => (a, b),
            };
            frames.push(clip.push(&a, &b).with_context(|| format!("frame {i}"))?);
            let gaze = self.viewing.gaze(a.size());
            judges.push(&a, &b, gaze).with_context(|| format!("frame {i}"))?;
            progress.step();
        }
        drop(progress);
        let all = clip.summary().context("there are no frames to compare")?;
        let [jod, cvvdp_jod] = [judges.light.jod(), judges.colour.jod()];
        let decimals = |value: Option<f64>, unit: &str| value.map_or("-".into(), |v| format!("{v:.4}{unit}"));
        self.json.say(format!(
            "{} frames: PSNR {:.4} dB, SSIM {}, MS-SSIM {}, tPSNR {}, JOD {}, ColorVideoVDP {}",
            frames.len(),
            all.psnr,
            decimals(all.ssim, ""),
            decimals(all.ms_ssim, ""),
            decimals(all.tpsnr, " dB"),
            decimals(jod, ""),
            decimals(cvvdp_jod, " JOD")
        ))?;
        self.json.write(&Report {
            frames,
            psnr: all.psnr,
            ssim: all.ssim,
            ms_ssim: all.ms_ssim,
            tpsnr: all.tpsnr,
            jod,
            cvvdp_jod,
        })
    }
}

/// Crops `frame` by the extra row and column of clips with even sizes. Prints a note the first time.
fn crop(frame: &Frame, size: FrameSize, is_cropped: &mut bool) -> Frame {
    if !std::mem::replace(is_cropped, true) {
        console::note(format!(
            "frames of {} in the clip are compared without their padding, as {size}",
            frame.size()
        ));
    }
    Region { x: 0, y: 0, size }.of(frame)
}
