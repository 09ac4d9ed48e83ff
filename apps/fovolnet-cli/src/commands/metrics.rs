use super::reconstruct::frames_named;
use crate::console::{JsonOutput, Progress};
use crate::interrupt;
use anyhow::{Context, Result, bail};
use fovolnet::core::Frame;
use fovolnet::io::{image, video};
use fovolnet::metrics::{ClipQuality, FrameQuality};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Compare two folders of frames, or two clips
#[derive(clap::Args)]
pub struct Metrics {
    /// Folder of reference frames (reference_*, else frame_*, else all pictures), or a clip
    reference: PathBuf,
    /// Folder of frames to judge (frame_*, else all pictures), or a clip
    test: PathBuf,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    frames: Vec<FrameQuality>,
    psnr: f64,
    ssim: Option<f64>,
    ms_ssim: Option<f64>,
    tpsnr: Option<f64>,
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
        let mut progress = Progress::new("comparing", reference.len() as u64);
        let mut clip = ClipQuality::new();
        let mut frames = Vec::new();
        for i in 0..reference.len() {
            interrupt::check("nothing was written")?;
            let measured = clip.push(&reference.frame(i)?, &test.frame(i)?);
            frames.push(measured.with_context(|| format!("frame {i}"))?);
            progress.step();
        }
        drop(progress);
        let all = clip.summary().context("there are no frames to compare")?;
        let decimals = |value: Option<f64>, unit: &str| value.map_or("-".into(), |v| format!("{v:.4}{unit}"));
        self.json.say(format!(
            "{} frames: PSNR {:.4} dB, SSIM {}, MS-SSIM {}, tPSNR {}",
            frames.len(),
            all.psnr,
            decimals(all.ssim, ""),
            decimals(all.ms_ssim, ""),
            decimals(all.tpsnr, " dB")
        ))?;
        self.json.write(&Report {
            frames,
            psnr: all.psnr,
            ssim: all.ssim,
            ms_ssim: all.ms_ssim,
            tpsnr: all.tpsnr,
        })
    }
}

/// Frames in files or in memory.
enum Clip {
    Files(Vec<PathBuf>),
    Video(Vec<Frame>),
}

impl Clip {
    /// The clip at `path`; in a folder, the pictures of the first prefix that there are any of.
    fn open(path: &Path, prefixes: &[&str]) -> Result<Self> {
        if !path.is_dir() {
            return Ok(Self::Video(video::read(path)?));
        }
        let found = prefixes.iter().find_map(|prefix| frames_named(path, prefix).ok());
        found
            .map(Self::Files)
            .with_context(|| format!("{}: there are no pictures in it; check the folder", path.display()))
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
