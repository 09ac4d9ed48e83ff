use super::mask;
use crate::console::{self, JsonOutput, Progress};
use crate::interrupt;
use anyhow::{Context, Result, bail};
use fovolnet::core::Frame;
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::{atomic, video::VideoWriter};
use fovolnet::metrics::ClipQuality;
use fovolnet::{
    FrameReport, MeanReport, Pipeline, RenderReport, RenderSettings, RenderedFrame, Session, SpeedSettings,
    VolumeSettings, open_volume,
};
use std::path::{Path, PathBuf};

/// Render frames of a volume
#[derive(clap::Args)]
pub struct Render {
    /// Volume file, folder of slices, procedural volume, or session (.toml)
    volume: String,
    /// Folder for the frames
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    settings: RenderSettings,
    #[command(flatten)]
    speed: SpeedSettings,
    /// What to write: frame, sparse, mask, reference, motion
    #[arg(long, value_name = "WHAT,…", value_delimiter = ',', default_value = "frame")]
    keep: Vec<Keep>,
    /// Format of the frames
    #[arg(long, value_name = "FORMAT", default_value = "png")]
    format: Format,
    /// Also write the frames as a clip (.y4m; other formats where ffmpeg is installed)
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// Frames a second of the clip
    #[arg(long, value_name = "F", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=1000))]
    fps: u32,
    /// Also write a session file that replays this picture
    #[arg(long, value_name = "FILE.toml")]
    save_session: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Keep {
    Frame,
    Sparse,
    Mask,
    Reference,
    Motion,
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

impl Render {
    pub fn run(mut self) -> Result<()> {
        let session = self.session()?;
        if self.video.is_some() && session.render.is_transparent() {
            bail!(
                "a clip has no alpha, so --video cannot be transparent; leave out --video and take the frames, or --transparent"
            );
        }
        let opened = open_volume(&session.volume, &session.read)?;
        opened.remarks().iter().for_each(|remark| eprintln!("warning: {remark}"));
        let mut pipeline = Pipeline::new(&opened, &session.render, &self.speed)?;
        console::warn(&pipeline);
        if self.keep.contains(&Keep::Motion) {
            pipeline.find_motion();
        }
        atomic::make_folder(&self.output)?;
        if let Some(path) = &self.save_session {
            session.write(path)?;
        }
        let numbers = session.render.frame_numbers();
        let mut progress = Progress::new("rendering", u64::from(numbers.end - numbers.start));
        let mut video =
            self.video.as_ref().map(|p| VideoWriter::create(p, pipeline.size(), self.fps)).transpose()?;
        let mut quality = ClipQuality::new().without_ms_ssim();
        let mut frames = Vec::new();
        for i in numbers {
            if interrupt::asked() {
                break;
            }
            let rendered = pipeline.render(i)?;
            let reference =
                self.keep.contains(&Keep::Reference).then(|| pipeline.reference(i)).transpose()?;
            let measured = reference.as_ref().map(|r| quality.push(r, &rendered.frame)).transpose()?;
            self.write(&rendered, reference.as_ref(), session.render.is_transparent())?;
            if let Some(video) = &mut video {
                video.push(&rendered.frame)?;
            }
            frames.push(FrameReport {
                index: i,
                samples: rendered.samples,
                density: rendered.mask.density(),
                lost_samples: rendered.lost,
                ms: rendered.timings,
                psnr: measured.map(|q| q.psnr),
                ssim: measured.and_then(|q| q.ssim),
            });
            progress.step();
        }
        drop(progress);
        let complete = frames.len();
        let summary = quality.summary();
        let mean = MeanReport {
            psnr: summary.map(|s| s.psnr),
            ssim: summary.and_then(|s| s.ssim),
            tpsnr: summary.and_then(|s| s.tpsnr),
            ..MeanReport::of(&frames)
        };
        let report = RenderReport {
            volume: session.volume.clone(),
            size: pipeline.size(),
            sampling: session.render.sampling().name().into(),
            reconstruct: session.render.reconstruction().to_string(),
            frames,
            mean,
            machine: pipeline.machine(),
        };
        self.summarise(&report)?;
        self.json.write(&report)?;
        interrupt::check(&format!("{complete} complete frames are in {}", self.output.display()))?;
        if let Some(video) = video {
            let wanted = video.path().to_owned();
            let path = video.finish()?;
            if self.video.as_ref() != Some(&wanted) {
                eprintln!("note: ffmpeg is not installed, so the clip is {}", path.display());
            }
        }
        Ok(())
    }

    /// The session that the arguments describe: the file's, if a file is named, with the flags on top.
    fn session(&mut self) -> Result<Session> {
        let flags = std::mem::take(&mut self.settings);
        let read = std::mem::take(&mut self.read);
        let path = Path::new(&self.volume);
        if path.extension().is_some_and(|e| e == "toml") {
            let mut session = Session::read(path)?;
            if !session.volume_is_unchanged()? {
                bail!(
                    "{} has changed since {} was saved; save the session again, or restore the volume",
                    session.volume,
                    self.volume
                );
            }
            if !session.weights_are_unchanged()? {
                eprintln!(
                    "warning: the weights are not those that {} was saved with; pictures will not be the same",
                    self.volume
                );
            }
            session.render = session.render.overridden_by(flags);
            session.read = session.read.overridden_by(read);
            return Ok(session);
        }
        Ok(Session::new(&self.volume, read, flags)?)
    }

    fn write(&self, rendered: &RenderedFrame, reference: Option<&Frame>, is_transparent: bool) -> Result<()> {
        let i = rendered.index;
        let alpha = if is_transparent { Alpha::Keep } else { Alpha::Drop };
        let frame = |name: &str, frame: &Frame, alpha: Alpha| -> Result<()> {
            let path = |extension: &str| self.output.join(format!("{name}_{i:04}.{extension}"));
            match self.format {
                Format::Png => image::write_png(&path("png"), frame, alpha)?,
                // Straight colours are PNG's convention, premultiplied ones OpenEXR's; of opaque frames both are the same.
                Format::Exr if is_transparent => {
                    image::write_exr(&path("exr"), &frame.clone().premultiplied())?;
                }
                Format::Exr => image::write_exr(&path("exr"), frame)?,
            }
            Ok(())
        };
        for keep in &self.keep {
            match keep {
                Keep::Frame => frame("frame", &rendered.frame, alpha)?,
                Keep::Sparse => frame("sparse", &rendered.sparse, Alpha::Keep)?,
                Keep::Mask => mask::write(&self.output.join(format!("mask_{i:04}.png")), &rendered.mask)?,
                Keep::Reference => {
                    frame("reference", reference.context("the reference was not rendered")?, alpha)?;
                }
                Keep::Motion => {
                    let path = self.output.join(format!("motion_{i:04}.exr"));
                    image::write_exr(&path, &motion_picture(rendered))?;
                }
            }
        }
        Ok(())
    }

    fn summarise(&self, report: &RenderReport) -> Result<()> {
        let mean = &report.mean;
        let mut line = format!(
            "{} frames of {} in {}: density {:.4}, {:.1} ms a frame (mask {:.2}, march {:.1}, reconstruct {:.1})",
            report.frames.len(),
            report.size,
            self.output.display(),
            mean.density,
            mean.ms.total,
            mean.ms.mask,
            mean.ms.march,
            mean.ms.reconstruct
        );
        if let (Some(psnr), Some(ssim)) = (mean.psnr, mean.ssim) {
            line += &format!(", PSNR {psnr:.2} dB, SSIM {ssim:.4}");
        }
        self.json.say(line)
    }
}

/// The motion of a frame as a picture: red is the way right, green the way down, in pixels; still where none is known.
fn motion_picture(rendered: &RenderedFrame) -> Frame {
    let mut picture = Frame::new(rendered.frame.size());
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        let [right, down] = rendered.motion.as_ref().map_or([0.0; 2], |motion| motion[i]);
        *pixel = [right, down, 0.0, 1.0];
    }
    picture
}
