use super::repeat::{Times, alternating};
use crate::console::JsonOutput;
use anyhow::Result;
use fovolnet::core::FrameSize;
use fovolnet::io::image::{self, Alpha};
use fovolnet::render::cpu::march::SampleCount;
use fovolnet::render::cpu::{RenderOptions, Renderer, Simd};
use fovolnet::{Machine, Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};
use serde::Serialize;
use std::path::PathBuf;

/// Marching every pixel: times, samples, samples a second
#[derive(clap::Args)]
pub struct MarchBench {
    /// Volume file, folder of slices, or procedural volume
    #[arg(default_value = "head")]
    volume: String,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    settings: RenderSettings,
    #[command(flatten)]
    speed: SpeedSettings,
    /// Repetitions of every measurement
    #[arg(long, value_name = "N", default_value_t = 7)]
    repeats: usize,
    /// Also write the picture
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Row {
    simd: String,
    skip_empty: bool,
    #[serde(flatten)]
    times: Times,
    primary_samples: u64,
    shadow_samples: u64,
    million_samples_per_s: f64,
}

#[derive(Serialize)]
struct Report {
    volume: String,
    size: FrameSize,
    occupied_cells: f64,
    rows: Vec<Row>,
    machine: Machine,
}

impl MarchBench {
    pub fn run(self) -> Result<()> {
        let opened = open_volume(&self.volume, &self.read)?;
        let mut pipeline = Pipeline::new(&opened, &self.settings, &self.speed)?;
        let machine = pipeline.machine();
        let chosen = pipeline.renderer().options().simd;
        let simds = if self.speed.simd.is_some() { vec![chosen] } else { fast_ones() };
        let camera = pipeline.camera(self.settings.frame_numbers().start);
        let size = pipeline.size();
        let pool = rayon_pool(machine.threads)?;
        if let Some(path) = &self.picture {
            let (frame, _) = pool.install(|| pipeline.renderer().march_full(&camera, size));
            image::write_png(path, &frame, Alpha::Drop)?;
        }
        let mut rows = Vec::new();
        for simd in simds {
            let both = [false, true].map(|skip_empty| RenderOptions { simd, skip_empty });
            let renderer: &mut Renderer = pipeline.renderer_mut();
            let mut counts = [SampleCount::default(); 2];
            let times = alternating(self.repeats, both.len(), |task| {
                renderer.set_options(both[task]);
                counts[task] = pool.install(|| renderer.march_full(&camera, size).1);
            })?;
            for ((options, times), count) in both.into_iter().zip(times).zip(counts) {
                rows.push(Row {
                    simd: simd.to_string(),
                    skip_empty: options.skip_empty,
                    times,
                    primary_samples: count.primary,
                    shadow_samples: count.shadow,
                    million_samples_per_s: (count.primary + count.shadow) as f64 / times.median_ms / 1e3,
                });
            }
        }
        let occupied_cells = pipeline.renderer().macrocells().occupied();
        self.report(&Report { volume: self.volume.clone(), size, occupied_cells, rows, machine })
    }

    fn report(&self, report: &Report) -> Result<()> {
        let m = &report.machine;
        self.json.say(format!(
            "{} at {}, {} ({} threads), {:.1} % of cells occupied",
            report.volume,
            report.size,
            m.cpu,
            m.threads,
            100.0 * report.occupied_cells
        ))?;
        self.json.say("simd      skip   median ms      min ms     primary      shadow  Msamples/s")?;
        for r in &report.rows {
            self.json.say(format!(
                "{:<9} {:<5} {:>10.2} {:>11.2} {:>11} {:>11} {:>11.0}",
                r.simd,
                if r.skip_empty { "on" } else { "off" },
                r.times.median_ms,
                r.times.min_ms,
                r.primary_samples,
                r.shadow_samples,
                r.million_samples_per_s
            ))?;
        }
        self.json.write(report)
    }
}

/// Every instruction set but plain code, which takes minutes.
fn fast_ones() -> Vec<Simd> {
    Simd::available().into_iter().filter(|&s| s != Simd::Scalar).collect()
}

/// Threads of our own, so that `--threads` holds for the bare renderer too.
pub fn rayon_pool(threads: usize) -> Result<rayon::ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
}
