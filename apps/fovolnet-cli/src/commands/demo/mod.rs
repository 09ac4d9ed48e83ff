mod gaze;

use crate::console::{self, JsonOutput, Progress};
use crate::{interrupt, label, picture};
use anyhow::Result;
use fovolnet::core::{CameraPath, Frame, FrameSize, GazePath};
use fovolnet::io::atomic;
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::procedural::Procedural;
use fovolnet::io::video::{self, VideoWriter};
use fovolnet::metrics::ClipQuality;
use fovolnet::net::Fill;
use fovolnet::{
    FrameReport, MeanReport, NanColour, Pipeline, Quality, Reconstruction, RenderReport, RenderSettings,
    Sampling, SpeedSettings, Viewpoint, VolumeSettings, open_volume, parse,
};
use gaze::Gaze;
use std::path::PathBuf;
use std::time::Instant;

/// Render a short foveated fly-through of a built-in volume, with pictures of every stage
#[derive(clap::Args)]
pub struct Demo {
    /// Folder for the results
    #[arg(short, long, value_name = "DIR", default_value = "fovolnet-demo")]
    output: PathBuf,
    /// Procedural volume
    #[arg(long, value_name = "NAME", default_value = "supernova")]
    volume: Procedural,
    /// Voxels along x, y, z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::whole_numbers::<3>, default_value = "160,160,160")]
    dims: [usize; 3],
    /// Frame size in pixels
    #[arg(long, value_name = "WxH", default_value = "640x360")]
    size: FrameSize,
    /// Number of frames
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=5000))]
    frames: u32,
    /// Share of pixels sampled away from the gaze, 0 to 1
    #[arg(long, value_name = "P", default_value_t = 0.05, value_parser = parse::number)]
    pb: f64,
    /// Standard deviation of the fovea in image widths
    #[arg(long, value_name = "S", default_value_t = 0.06, value_parser = parse::number)]
    sigma: f64,
    #[command(flatten)]
    speed: SpeedSettings,
    #[command(flatten)]
    json: JsonOutput,
}

/// White pixels between the rows of the contact sheet.
const GAP: u32 = 4;
/// Rows of the contact sheet.
const SHEET_ROWS: u32 = 4;
/// Step between frames of the fly-through, so that a short clip covers a whole round.
const STRIDE: u32 = 2;

impl Demo {
    pub fn run(self) -> Result<()> {
        let started = Instant::now();
        let read = VolumeSettings { dims: Some(self.dims), ..VolumeSettings::default() };
        let opened = open_volume(self.volume.name(), &read)?;
        let mut pipeline = Pipeline::new(&opened, &self.settings(), &self.speed)?;
        let mut pull_push = Pipeline::new(&opened, &self.pull_push(), &self.speed)?;
        console::warn(&pipeline);
        atomic::make_folder(&self.output)?;
        // Two panels beside and below each other: the film has the shape of a frame, and even sides.
        let film = FrameSize::new(2 * self.size.width, 2 * self.size.height)?;
        let mut video =
            VideoWriter::create(&self.output.join(format!("demo.{}", video::best_extension())), film, 24)?;
        let mut gaze = Gaze::default();
        let mut progress = Progress::new("demo frames", u64::from(self.frames));
        let [mut quality, mut filled_quality] = [(); 2].map(|()| ClipQuality::new().without_ms_ssim());
        let (mut frames, mut rows, mut reference_ms) = (Vec::new(), Vec::new(), 0.0);
        for i in 0..self.frames {
            let made = interrupt::unless_asked(|| {
                let fovea = gaze.fovea(&mut pipeline, i * STRIDE)?;
                let viewpoint = Viewpoint { camera: pipeline.camera(i * STRIDE), fovea };
                let rendered = pipeline.render_from(i * STRIDE, &viewpoint)?;
                let filled = pull_push.render_from(i * STRIDE, &viewpoint)?.frame;
                let before = Instant::now();
                let reference = pipeline.reference(i * STRIDE)?;
                Ok(((rendered, filled), reference, before.elapsed().as_secs_f64() * 1e3))
            })?;
            let ((rendered, filled), reference, ms) = made.ok_or_else(|| {
                interrupt::error(&format!(
                    "{} complete frames are in {}",
                    frames.len(),
                    self.output.display()
                ))
            })?;
            reference_ms += ms / f64::from(self.frames);
            let measured = quality.push(&reference, &rendered.frame)?;
            let sparse = rendered.samples_picture();
            filled_quality.push(&reference, &filled)?;
            let figures = FrameReport::of(i * STRIDE, &rendered, Some(&measured));
            let panels = [sparse, filled, rendered.frame, reference];
            let labelled = labelled(&panels, figures.density);
            let sheet = two_by_two(&labelled);
            image::write_png(&self.output.join(format!("demo_{i:04}.png")), &sheet, Alpha::Drop)?;
            video.push(&sheet)?;
            if i % self.frames.div_ceil(SHEET_ROWS) == 0 {
                let row = if rows.is_empty() { &labelled } else { &panels };
                rows.push(picture::side_by_side(&row.each_ref(), GAP));
            }
            frames.push(figures);
            progress.step();
        }
        drop(progress);
        let sheet: Frame = picture::stacked(&rows, GAP);
        image::write_png(&self.output.join("contact_sheet.png"), &sheet, Alpha::Drop)?;
        let clip = video.finish()?;
        let mean = MeanReport::of(&frames, quality.summary().as_ref());
        let report = RenderReport {
            volume: self.volume.name().into(),
            size: self.size,
            quality: Quality::Fixed.to_string(),
            budget_ms: None,
            sampling: "compact".into(),
            reconstruct: "wnet".into(),
            guide: pipeline.guide().to_string(),
            integration: self.settings().integration.to_string(),
            nan: NanColour::default().to_string(),
            frames,
            mean,
            machine: pipeline.machine(),
        };
        let filled = filled_quality.summary().map(|summary| summary.psnr);
        self.table(&report, reference_ms, filled)?;
        self.json.say(format!(
            "sparse | pull-push | reconstructed | every pixel: {}/contact_sheet.png, demo_*.png, {} ({:.0} s in all)",
            self.output.display(),
            clip.display(),
            started.elapsed().as_secs_f64()
        ))?;
        self.json.write(&report)
    }

    fn settings(&self) -> RenderSettings {
        RenderSettings {
            size: self.size,
            camera: CameraPath::Flythrough.into(),
            gaze: GazePath::Wander { seed: 0 },
            sampling: Sampling::Compact,
            pb: self.pb,
            sigma: self.sigma,
            reconstruction: Reconstruction::WNet,
            ..RenderSettings::default()
        }
    }

    /// Settings of as many samples, the same everywhere away from the gaze, filled by pull-push.
    fn pull_push(&self) -> RenderSettings {
        RenderSettings { reconstruction: Reconstruction::Fill(Fill::PullPush), ..self.settings() }
    }

    fn table(&self, report: &RenderReport, reference_ms: f64, filled: Option<f64>) -> Result<()> {
        let m = &report.mean;
        let rows = [
            (
                "volume".to_owned(),
                format!("{} {}x{}x{}", report.volume, self.dims[0], self.dims[1], self.dims[2]),
            ),
            ("frames".into(), format!("{} of {}", report.frames.len(), report.size)),
            ("pixels marched".into(), format!("{:.2} %", 100.0 * m.density)),
            ("mask and compaction".into(), format!("{:.2} ms", m.ms.mask)),
            ("march".into(), format!("{:.2} ms", m.ms.march)),
            ("guide, without shadow rays".into(), format!("{:.2} ms", m.ms.guide)),
            ("reconstruction (wnet-fast)".into(), format!("{:.2} ms", m.ms.reconstruct)),
            ("whole frame".into(), format!("{:.2} ms", m.ms.total)),
            (
                "marching every pixel".into(),
                format!("{reference_ms:.2} ms, {:.1} times as long", reference_ms / m.ms.total),
            ),
            ("PSNR".into(), decibels(m.psnr)),
            ("PSNR of pull-push alone".into(), decibels(filled)),
            ("SSIM".into(), m.ssim.map_or("-".into(), |v| format!("{v:.4}"))),
            ("tPSNR".into(), decibels(m.tpsnr)),
            (
                "machine".into(),
                format!(
                    "{}, {} threads, {}",
                    report.machine.cpu, report.machine.threads, report.machine.simd
                ),
            ),
        ];
        for (name, value) in rows {
            self.json.say(format!("{name:<28} {value}"))?;
        }
        Ok(())
    }
}

/// Names the four `panels` in their corners. `density` is the share of marched pixels.
fn labelled(panels: &[Frame; 4], density: f64) -> [Frame; 4] {
    let sampled = format!("{:.0}% of the pixels", 100.0 * density);
    let texts = [&sampled, "filled by pull-push", "reconstructed", "every pixel"];
    std::array::from_fn(|i| {
        let mut panel = panels[i].clone();
        label::label(&mut panel, texts[i]);
        panel
    })
}

/// Grey value of the lines between panels.
const LINE: f32 = 0.3;

/// The four `panels` in two rows, with thin lines between them that cover their edges.
fn two_by_two(panels: &[Frame; 4]) -> Frame {
    let rows = [[0, 1], [2, 3]].map(|row| picture::side_by_side(&row.map(|panel| &panels[panel]), 0));
    let mut sheet = picture::stacked(&rows, 0);
    let FrameSize { width, height } = sheet.size();
    for (i, pixel) in (0..).zip(sheet.pixels_mut()) {
        let (x, y) = (i % width, i / width);
        if x == width / 2 || y == height / 2 {
            *pixel = [LINE, LINE, LINE, 1.0];
        }
    }
    sheet
}

fn decibels(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| format!("{v:.2} dB"))
}
