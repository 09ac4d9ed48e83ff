use crate::console::{self, JsonOutput, Progress};
use crate::frame_files::{Format, FrameFiles, Keep};
use crate::frame_maker::{FrameMaker, Planning};
use crate::picture_arguments::PictureArguments;
use crate::{interrupt, outputs};
use anyhow::{Result, bail, ensure};
use fovolnet::core::{path_of_text, shown_path};
use fovolnet::io::video::{self, FrameRate, VideoWriter};
use fovolnet::metrics::ClipQuality;
use fovolnet::{
    Choice, FrameReport, Freedom, Guide, Limit, MeanReport, OpenVolume, Quality, Reconstruction,
    RenderReport, RenderSettings, Sampling, Session, TimeChoice, TimeClip, Visibility, open_volume, parse,
    presets,
};
use std::path::{Path, PathBuf};

/// Render frames of a volume
#[derive(clap::Args)]
pub struct Render {
    /// Volume file, folder of slices, procedural volume, or session (.toml)
    #[arg(value_parser = parse::file())]
    volume: String,
    /// Folder for the frames; or for one frame, a picture (.png, .exr)
    #[arg(short, long, value_name = "DIR|PICTURE")]
    output: PathBuf,
    #[command(flatten)]
    picture: PictureArguments,
    /// Pictures to write: frame, sparse, mask, reference, motion, guide (with the light ratio)
    #[arg(long, value_name = "WHAT,…", value_delimiter = ',', default_value = "frame")]
    keep: Vec<Keep>,
    /// Format of the frames [default: png]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// Also write the frames as a clip (.y4m; .mp4, .gif and others where ffmpeg is installed)
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// Frames a second of the clip: a number or a fraction, as 30000/1001; 23.976 is 24000/1001
    #[arg(long, value_name = "F|N/D", default_value = "30")]
    fps: FrameRate,
    /// Also write a session file that replays this picture
    #[arg(long, value_name = "FILE.toml")]
    save_session: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOutput,
}

impl Render {
    pub fn run(mut self) -> Result<()> {
        let mut session = self.session()?;
        let keeps_samples =
            self.keep.iter().any(|keep| matches!(keep, Keep::Sparse | Keep::Mask | Keep::Guide))
                || (session.render.limit()?.is_some() && self.keep.contains(&Keep::Motion));
        if keeps_samples && session.render.sampling.and_then(Choice::fixed).is_none() {
            session.render.sampling = Some(Sampling::Compact.into());
        }
        session.render.integration.get_or_insert(RenderSettings::default().integration);
        let over_time = take_length_of_time(&mut session)?;
        let mut settings = session.render.resolve()?;
        if self.video.is_some() && settings.transparent {
            bail!(
                "a clip has no alpha, so --video cannot be transparent; leave out --video and take the frames, or --transparent"
            );
        }
        let numbers = settings.frame_numbers();
        ensure!(!numbers.is_empty(), "there are no frames to render; give --frames 1 or more");
        let files = FrameFiles::new(&self.output, &self.keep, self.format, numbers.len())?
            .with_alpha(settings.transparent);
        self.video.iter().try_for_each(|path| video::check_name(path))?;
        let opened = match over_time {
            Some(opened) => opened,
            None => open_volume(&session.volume, &session.read)?,
        };
        console::remark(&opened);
        let clip = TimeClip::new(&session.volume, &session.read, &opened, &settings)?;
        if clip.is_some() {
            settings = TimeClip::settled(&settings, &opened)?;
        }
        for note in presets::notes(&session.render, &opened) {
            console::note(note);
        }
        let limit = session.render.limit()?;
        let planning = limit.map(|limit| {
            let size = self.keep.iter().all(|keep| matches!(keep, Keep::Frame | Keep::Reference));
            let freedom = Freedom { size, ..session.render.freedom() };
            Planning { freedom, limit, saved: &session.plan }
        });
        let mut maker = FrameMaker::new(&opened, &settings, planning.as_ref(), clip, &self.picture.speed)?;
        let pipeline = maker.pipeline();
        console::warn(pipeline);
        if files.has(Keep::Motion) {
            pipeline.find_motion();
        }
        if files.has(Keep::Guide) {
            ensure!(
                pipeline.guide() != Guide::None,
                "there is no guide: shadows are off or cached, or another network than wnet-fast fills the frames; add \
                 --guide quarter"
            );
            pipeline.keep_guide();
        }
        if files.has(Keep::Reference) {
            pipeline.check_references()?;
        }
        let frames = files.paths(&numbers);
        let others = [self.video.as_deref(), self.save_session.as_deref(), self.json.file()];
        outputs::check(frames.iter().map(PathBuf::as_path).chain(others.into_iter().flatten()))?;
        self.save_session.iter().try_for_each(|path| check_session_name(path))?;
        files.doubt().into_iter().for_each(console::note);
        files.make_folder()?;
        outputs::have_folders(others.into_iter().flatten())?;
        let mut video =
            self.video.as_ref().map(|p| VideoWriter::create(p, settings.size, self.fps)).transpose()?;
        if let Some(path) = &self.save_session {
            session.write(path)?;
        }
        let older = files.older(&numbers);
        let mut progress = Progress::new("rendering", numbers.len() as u64);
        let mut quality = ClipQuality::new().without_ms_ssim();
        let mut visibility = Visibility::new(&settings);
        let mut frames = Vec::new();
        // Planned frames count what they wait for.
        let mut shadow_grid_ms = if limit.is_none() { maker.pipeline().shadow_grid_ms() } else { 0.0 };
        for i in numbers {
            let made = interrupt::unless_asked(|| {
                let (rendered, plan) = maker.render(i)?;
                let reference = files.has(Keep::Reference).then(|| maker.reference(i)).transpose()?;
                let measured = reference.as_ref().map(|r| quality.push(r, &rendered.frame)).transpose()?;
                Ok((rendered, plan, reference, measured))
            })?;
            let Some((rendered, plan, reference, measured)) = made else { break };
            files.write(&rendered, reference.as_ref())?;
            let camera = maker.camera(i);
            visibility.look(&rendered, &camera, &opened.volume);
            if let Some(video) = &mut video {
                video.push(&rendered.frame)?;
            }
            let report = FrameReport {
                // The first frame waited for the grid of cached shadows.
                ms: rendered.timings.with_shadow_grid(std::mem::take(&mut shadow_grid_ms)),
                ..FrameReport::of(i, &rendered, measured.as_ref())
            };
            frames.push(match plan {
                Some(plan) => report.planned(plan, settings.size),
                None => report,
            });
            progress.step();
        }
        drop(progress);
        let complete = frames.len();
        let mean = MeanReport::of(&frames, quality.summary().as_ref());
        let report = RenderReport {
            volume: shown_path(&session.volume),
            size: settings.size,
            quality: if limit.is_some() { Quality::Auto } else { Quality::Fixed }.to_string(),
            budget_ms: session.render.budget,
            sampling: settings.sampling.name().into(),
            reconstruct: reconstruction(&settings).to_string(),
            guide: maker.guide(&settings).to_string(),
            integration: settings.integration.to_string(),
            nan: settings.nan.to_string(),
            frames,
            mean,
            machine: maker.machine(),
        };
        self.summarise(&report)?;
        self.json.write(&report)?;
        if let (Some(path), Some(Limit::Time(_))) = (&self.save_session, limit) {
            session.plan = maker.plans().to_vec();
            session.write(path)?;
        }
        note_older(&older, &self.output);
        interrupt::check(&format!("{complete} complete frames are in {}", self.output.display()))?;
        if let Some(problem) = visibility.problem(&opened, &settings) {
            console::note(problem);
        }
        if let Some(video) = video {
            let path = video.finish()?;
            if let Some(wanted) = self.video.as_ref().filter(|&wanted| *wanted != path) {
                let (path, wanted) = (path.display(), wanted.display());
                console::note(format!(
                    "ffmpeg is not installed, so the clip is {path}; where it is, `ffmpeg -i {path} {wanted}` converts it"
                ));
            }
        }
        Ok(())
    }

    /// Session of the arguments: that of a session file, if one is named, overridden by the flags.
    fn session(&mut self) -> Result<Session> {
        let flags = std::mem::take(&mut self.picture.settings);
        flags.check_flags()?;
        let read = std::mem::take(&mut self.picture.read);
        let path: &Path = &path_of_text(&self.volume);
        if path.extension().is_some_and(|e| e == "toml") {
            let mut session = Session::read(path)?;
            session.check_volume(path)?;
            if flags.tf.is_none() {
                session.check_transfer_function(path)?;
            }
            session.check_unchanged(path)?;
            if !session.weights_are_unchanged()? {
                console::warning(format!(
                    "the weights are not those that {} was saved with; pictures will not be the same",
                    self.volume
                ));
            }
            if flags.quality.is_some() || flags.budget.is_some() {
                session.plan.clear();
            }
            session.render = session.render.overridden_by(flags);
            session.read = session.read.overridden_by(read);
            return Ok(session);
        }
        Ok(Session::new(&self.volume, read, flags)?)
    }

    fn summarise(&self, report: &RenderReport) -> Result<()> {
        let mean = &report.mean;
        let mut line = format!(
            "{} frame{} of {} in {}: density {:.4}, {:.1} ms a frame (mask {:.2}, march {:.1}, reconstruct {:.1})",
            report.frames.len(),
            if report.frames.len() == 1 { "" } else { "s" },
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

/// Checks that `path` has the ending by which sessions are known. Pipes and devices may have any name.
fn check_session_name(path: &Path) -> Result<()> {
    let is_file = path.is_file() || !path.exists();
    let is_toml = path.extension().is_some_and(|extension| extension == "toml");
    ensure!(
        is_toml || !is_file,
        "{} would not be known as a session, whose name ends in .toml; give --save-session FILE.toml",
        path.display()
    );
    Ok(())
}

/// Completes a clip over time of `session`: without `--frames` it has one frame for each time point, and without a camera
/// or path it is seen from the default view. Returns the volume that was opened to count them.
fn take_length_of_time(session: &mut Session) -> Result<Option<OpenVolume>> {
    if !matches!(session.read.time, Some(TimeChoice::Clip { .. })) {
        return Ok(None);
    }
    let opened = open_volume(&session.volume, &session.read)?;
    let length = TimeClip::length(&session.read, &opened)?;
    let render = &mut session.render;
    render.frames = render.frames.or(length);
    if render.camera.is_none() && render.path.is_none() && render.turn.is_none() {
        render.turn = Some(0.0);
    }
    Ok(Some(opened))
}

/// Method of filling frames; none if every pixel is marched.
fn reconstruction(settings: &RenderSettings) -> Reconstruction {
    match settings.sampling {
        Sampling::Full => Reconstruction::None,
        _ => settings.reconstruction,
    }
}

/// Notes that the frames `older` of an earlier run are still in the folder `output`.
fn note_older(older: &[String], output: &Path) {
    let (Some(first), Some(last)) = (older.first(), older.last()) else { return };
    let output = output.display();
    match older.len() {
        1 => console::note(format!("{output} also holds an older frame, {first}, which was left in place")),
        count => console::note(format!(
            "{output} also holds {count} older frames, {first} to {last}, which were left in place"
        )),
    }
}
