use super::march_model;
use super::marching::marching;
use super::repeat::{Times, alternating};
use super::subject::Subject;
use crate::console::JsonOutput;
use crate::outputs;
use anyhow::Result;
use fovolnet::core::FrameSize;
use fovolnet::io::image::{self, Alpha};
use fovolnet::render::cpu::march::SampleCount;
use fovolnet::{Machine, WorldBox, camera_path, scene};
use serde::Serialize;
use std::path::PathBuf;

/// Marching every pixel: times, samples, samples per second
#[derive(clap::Args)]
pub struct MarchBench {
    #[command(flatten)]
    subject: Subject,
    /// Repetitions of every measurement
    #[arg(long, value_name = "N", default_value_t = 7)]
    repeats: usize,
    /// Also write the picture
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// Measure nothing: follow the rays of the frame, and say what they would cost on this GPU (h200, h100, rtx-4090,
    /// rtx-3060 or integrated), for every pixel and for the sampled ones
    #[arg(long, value_name = "GPU", num_args = 0..=1, default_missing_value = "h200", conflicts_with = "picture")]
    model: Option<String>,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Row {
    /// Instruction set, or `gpu`.
    simd: String,
    skip_empty: bool,
    #[serde(flatten)]
    times: Times,
    /// Numbers of samples along rays and towards the light, if they are counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    primary_samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shadow_samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    million_samples_per_s: Option<f64>,
}

impl Row {
    fn new((simd, skip_empty): (&str, bool), times: Times, count: Option<SampleCount>) -> Self {
        let per_s = |c: SampleCount| (c.primary + c.shadow) as f64 / times.median_ms / 1e3;
        Self {
            simd: simd.into(),
            skip_empty,
            times,
            primary_samples: count.map(|c| c.primary),
            shadow_samples: count.map(|c| c.shadow),
            million_samples_per_s: count.map(per_s),
        }
    }
}

#[derive(Serialize)]
struct Report {
    volume: String,
    size: FrameSize,
    rows: Vec<Row>,
    machine: Machine,
}

impl MarchBench {
    pub fn run(self) -> Result<()> {
        let opened = self.subject.open()?;
        let settings = self.subject.settings(None)?;
        let scene = scene(&opened, &settings)?;
        let world = WorldBox::new(&opened.volume, &settings)?;
        let camera = camera_path(&settings, &world)?.camera(settings.first_frame);
        let camera = world.camera(&camera);
        let size = settings.size;
        if let Some(name) = &self.model {
            outputs::check(self.json.file())?;
            outputs::have_folders(self.json.file())?;
            return march_model::report(&scene, &camera, &settings, &march_model::gpu(name)?, &self.json);
        }
        let mut marching = marching(&scene, self.subject.speed(), size)?;
        let files = [self.picture.as_deref(), self.json.file()];
        outputs::check(files.into_iter().flatten())?;
        outputs::have_folders(files.into_iter().flatten())?;
        if let Some(path) = &self.picture {
            image::write_png(path, &marching.picture(&camera)?, Alpha::Drop)?;
        }
        let mut rows = Vec::new();
        for (way, name) in marching.ways().iter().enumerate() {
            let skips = [false, true];
            let mut counts = [None; 2];
            let times = alternating(self.repeats, skips.len(), |task| {
                marching.choose(way, skips[task]);
                let (lap, count) = marching.full(&camera)?;
                counts[task] = count;
                Ok(lap)
            })?;
            let measured = skips.into_iter().zip(times).zip(counts);
            rows.extend(measured.map(|((skip, times), count)| Row::new((name, skip), times, count)));
        }
        let machine = marching.machine();
        self.report(&Report { volume: self.subject.name(), size, rows, machine })
    }

    fn report(&self, report: &Report) -> Result<()> {
        let m = &report.machine;
        self.json.say(format!(
            "{} at {}, {} ({} threads)",
            report.volume,
            report.size,
            m.gpu.as_ref().unwrap_or(&m.cpu),
            m.threads,
        ))?;
        self.json.say("simd      skip   median ms      min ms     primary      shadow  Msamples/s")?;
        let count = |samples: Option<u64>| samples.map_or("-".into(), |n| n.to_string());
        for r in &report.rows {
            self.json.say(format!(
                "{:<9} {:<5} {:>10.2} {:>11.2} {:>11} {:>11} {:>11}",
                r.simd,
                if r.skip_empty { "on" } else { "off" },
                r.times.median_ms,
                r.times.min_ms,
                count(r.primary_samples),
                count(r.shadow_samples),
                r.million_samples_per_s.map_or("-".into(), |m| format!("{m:.0}"))
            ))?;
        }
        self.json.write(report)
    }
}
