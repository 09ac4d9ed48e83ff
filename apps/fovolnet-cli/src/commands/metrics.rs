use crate::console::{self, JsonOutput, Progress};
use crate::frame_sequence::{self, is_picture};
use crate::{interrupt, outputs};
use anyhow::{Context, Result, bail};
use fovolnet::core::{Frame, FrameSize, Region, input};
use fovolnet::io::video::FrameRate;
use fovolnet::io::{image, video};
use fovolnet::metrics::{ClipQuality, Display, Error, FovVideoVdp, FrameQuality};
use fovolnet::parse;
use serde::Serialize;
use std::path::{Path, PathBuf};

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

/// How FovVideoVDP's viewer sees the frames.
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

/// Frames a second, of a number or a fraction.
fn frame_rate(text: &str) -> Result<f64, String> {
    if !text.contains('/') {
        return parse::number(text);
    }
    let rate: FrameRate = text.parse()?;
    Ok(f64::from(rate.numerator()) / f64::from(rate.denominator()))
}

impl Viewing {
    /// The metric for a clip of `frames` frames; one alone is a picture.
    fn metric(&self, frames: usize) -> Result<FovVideoVdp> {
        let video = FovVideoVdp::video(&self.display, self.fps)?;
        Ok(if frames == 1 { FovVideoVdp::image(&self.display)? } else { video })
    }

    /// The gaze as fractions of a frame.
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
        let reference = Clip::open(&self.reference, &["reference_", "frame_", ""])?;
        let test = Clip::open(&self.test, &["frame_", ""])?;
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
            let (a, b) = (reference.frame(i)?, test.frame(i)?);
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
                // The JOD then stays out, as SSIM does.
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

/// `frame` without the row and column that clips of even sizes have besides; said once.
fn crop(frame: &Frame, size: FrameSize, is_cropped: &mut bool) -> Frame {
    if !std::mem::replace(is_cropped, true) {
        console::note(format!(
            "frames of {} in the clip are compared without their padding, as {size}",
            frame.size()
        ));
    }
    Region { x: 0, y: 0, size }.of(frame)
}

/// Frames in files or in memory.
enum Clip {
    Files(Vec<PathBuf>),
    Video(Vec<Frame>),
}

impl Clip {
    /// The clip at `path`; in a folder, the pictures of the first prefix that there are any of.
    fn open(path: &Path, prefixes: &[&str]) -> Result<Self> {
        if is_picture(path) && path.is_file() {
            input::add(path);
            return Ok(Self::Files(vec![path.to_owned()]));
        }
        if !path.is_dir() {
            return Ok(Self::Video(video::read(path)?));
        }
        for prefix in prefixes {
            let files = frame_sequence::pictures_if_any(path, prefix)?;
            if !files.is_empty() {
                return Ok(Self::Files(files));
            }
        }
        bail!("{}: there are no pictures in it; check the folder", path.display())
    }

    fn is_video(&self) -> bool {
        matches!(self, Self::Video(_))
    }

    fn len(&self) -> usize {
        match self {
            Self::Files(files) => files.len(),
            Self::Video(frames) => frames.len(),
        }
    }

    fn frame(&self, i: usize) -> Result<Frame> {
        match self {
            Self::Files(files) => Ok(image::read(&files[i])?),
            Self::Video(frames) => Ok(frames[i].clone()),
        }
    }
}
