use crate::console::{self, JsonOutput, Progress};
use crate::frame_source::FrameSource;
use crate::{interrupt, outputs};
use anyhow::{Context, Result, bail};
use fovolnet::core::memory::Estimate;
use fovolnet::core::{Frame, FrameSize, Region};
use fovolnet::io::video::{self, FrameRate};
use fovolnet::metrics::{ClipQuality, Display, Error, FovVideoVdp, FrameQuality};
use fovolnet::parse;
use serde::Serialize;
use std::path::PathBuf;

/// Compare two folders of frames, two clips, or two pictures
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

/// Viewing conditions of FovVideoVDP.
#[derive(clap::Args)]
struct Viewing {
    /// Frames a second, for the JOD: a number above 0 up to 1000, or a fraction, as 30000/1001
    #[arg(long, value_name = "F|N/D", default_value = "30", value_parser = frame_rate)]
    fps: f64,
    /// The display, for the JOD: standard_4k, standard_fhd or standard_hmd
    #[arg(long, value_name = "NAME", default_value = "standard_4k", value_parser = Display::named)]
    display: Display,
    /// Where the eye looks, for a foveated JOD: from the top left, as fractions of the frame where both are 0
    /// to 1 (as in --gaze), else in pixels; without it the eye looks everywhere
    #[arg(long, value_name = "X,Y", value_parser = parse::numbers::<2>)]
    fixation: Option<[f64; 2]>,
}

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
    /// Metric for a clip of `frames` frames; a single frame counts as a still picture.
    fn metric(&self, frames: usize) -> Result<FovVideoVdp> {
        let video = FovVideoVdp::video(&self.display, self.fps)?;
        Ok(if frames == 1 { FovVideoVdp::image(&self.display)? } else { video })
    }

    /// Estimate of the memory to compare two clips of `frames` frames, of the sizes of their first frames.
    fn estimate(&self, [a, b]: [FrameSize; 2], frames: usize) -> Estimate {
        let both = (a.pixels() + b.pixels()) as u64;
        // Of clips, the next frames are read while the last ones are kept for comparison.
        let kept = if frames == 1 { 1 } else { 2 };
        let seen = if frames == 1 { 1 } else { FovVideoVdp::frames_kept(self.fps).min(frames) };
        Estimate::new(format!("comparing frames of {a}"))
            .with(format!("{} frames", 2 * kept), both * kept * size_of::<[f32; 4]>() as u64)
            .with(format!("the luminance of {} frames", 2 * seen), both * (seen * size_of::<f32>()) as u64)
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

#[derive(Serialize)]
struct Report {
    frames: Vec<FrameQuality>,
    psnr: f64,
    ssim: Option<f64>,
    ms_ssim: Option<f64>,
    tpsnr: Option<f64>,
    jod: Option<f64>,
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
        let mut seen = self.viewing.metric(reference.len())?;
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
            match seen.push(&a, &b, self.viewing.gaze(a.size())) {
                // Such frames have no JOD, just as they have no SSIM.
                Ok(()) | Err(Error::TooSmall { .. }) => {}
                Err(error) => return Err(error).with_context(|| format!("frame {i}")),
            }
            progress.step();
        }
        drop(progress);
        let all = clip.summary().context("there are no frames to compare")?;
        let jod = seen.jod();
        let decimals = |value: Option<f64>, unit: &str| value.map_or("-".into(), |v| format!("{v:.4}{unit}"));
        self.json.say(format!(
            "{} frames: PSNR {:.4} dB, SSIM {}, MS-SSIM {}, tPSNR {}, JOD {}",
            frames.len(),
            all.psnr,
            decimals(all.ssim, ""),
            decimals(all.ms_ssim, ""),
            decimals(all.tpsnr, " dB"),
            decimals(jod, "")
        ))?;
        self.json.write(&Report {
            frames,
            psnr: all.psnr,
            ssim: all.ssim,
            ms_ssim: all.ms_ssim,
            tpsnr: all.tpsnr,
            jod,
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
