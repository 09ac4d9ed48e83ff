use super::marching::{Marching, Sampled, marching};
use super::repeat::alternating;
use super::subject::Subject;
use crate::console::JsonOutput;
use crate::outputs;
use anyhow::{Result, anyhow};
use fovolnet::core::{Camera, Fovea, FrameSize};
use fovolnet::io::atomic;
use fovolnet::render::noise::Noise;
use fovolnet::{Machine, OpenVolume, RenderSettings, SpeedSettings, WorldBox, camera_path, scene};
use plotters::prelude::*;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Effective compression: time of sparse sampling compared with its share of pixels
#[derive(clap::Args)]
pub struct CompactBench {
    #[command(flatten)]
    subject: Subject,
    /// Repetitions of every measurement
    #[arg(long, value_name = "N", default_value_t = 7)]
    repeats: usize,
    /// Folder for compact.csv and compact.svg
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    json: JsonOutput,
}

/// Figures of sparse sampling at one density.
#[derive(Serialize)]
pub struct Row {
    pub density: f64,
    pub full_ms: f64,
    pub compact_ms: f64,
    pub reject_ms: f64,
    pub direct_ms: f64,
    /// Time(compact) ÷ (density × time(full)); 1 is ideal.
    compact_overhead: f64,
    reject_overhead: f64,
    direct_overhead: f64,
    /// Time(full) ÷ time(compact): the paper's effective compression rate.
    effective_compression: f64,
    /// Fraction of drawn positions that repeat others.
    pub direct_lost: f64,
    /// Clock of the times: the device's, which excludes submitting and waiting, or the host's.
    clock: &'static str,
}

#[derive(Serialize)]
struct Report {
    volume: String,
    size: FrameSize,
    rows: Vec<Row>,
    machine: Machine,
}

/// Files written to the output folder.
const FILES: [&str; 2] = ["compact.csv", "compact.svg"];

/// Densities of the paper's figure, without a fovea.
const DENSITIES: [f64; 11] = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0];

impl CompactBench {
    pub fn run(self) -> Result<()> {
        let opened = self.subject.open()?;
        let settings = self.subject.settings(None)?;
        let files = self.output.as_ref().map(|folder| FILES.map(|name| folder.join(name)));
        outputs::check(files.iter().flatten().map(PathBuf::as_path).chain(self.json.file()))?;
        let (rows, machine) = measured(&opened, &settings, self.subject.speed(), self.repeats)?;
        let report = Report { volume: self.subject.name(), size: settings.size, rows, machine };
        self.describe(&report)?;
        if let (Some(folder), Some([csv, svg])) = (&self.output, &files) {
            atomic::make_folder(folder)?;
            write_csv(csv, &report.rows)?;
            atomic::write_bytes(svg, plotted(&report.rows)?.as_bytes())?;
        }
        self.json.write(&report)
    }

    fn describe(&self, report: &Report) -> Result<()> {
        let m = &report.machine;
        self.json.say(format!(
            "{} at {}, {} ({} threads, {})",
            report.volume,
            report.size,
            m.gpu.as_ref().unwrap_or(&m.cpu),
            m.threads,
            m.simd
        ))?;
        self.json
            .say("density  compression: ideal effective | overhead: compact reject direct | direct loses")?;
        for r in &report.rows {
            self.json.say(format!(
                "{:>7.3} {:>18.1} {:>9.1} | {:>17.3} {:>6.2} {:>6.2} | {:>10.1} %",
                r.density,
                1.0 / r.density,
                r.effective_compression,
                r.compact_overhead,
                r.reject_overhead,
                r.direct_overhead,
                100.0 * r.direct_lost
            ))?;
        }
        Ok(())
    }
}

/// Measures every density, with medians of `repeats` runs. Returns the rows and the machine.
pub fn measured(
    opened: &OpenVolume,
    settings: &RenderSettings,
    speed: &SpeedSettings,
    repeats: usize,
) -> Result<(Vec<Row>, Machine)> {
    let world = WorldBox::new(&opened.volume, settings)?;
    let mut marching = marching(&scene(opened, settings)?, speed, settings.size)?;
    let noise = Noise::new(settings.noise, 0);
    let frame = settings.first_frame;
    let camera = world.camera(&camera_path(settings, &world)?.camera(frame));
    let mut rows = Vec::new();
    for density in DENSITIES {
        let fovea = Fovea { base: density, sigma: 0.0, ..Fovea::default() };
        let sampled = Sampled { fovea: &fovea, noise: &noise, frame };
        rows.push(row(&mut *marching, &camera, &sampled, repeats)?);
    }
    Ok((rows, marching.machine()))
}

fn row(marching: &mut dyn Marching, camera: &Camera, sampled: &Sampled<'_>, repeats: usize) -> Result<Row> {
    let density = sampled.fovea.base;
    let mut direct_lost = 0.0;
    let times = alternating(repeats, 4, |task| match task {
        0 => Ok(marching.full(camera)?.0),
        1 => marching.compact(camera, sampled),
        2 => marching.reject(camera, sampled),
        _ => {
            let (lap, lost) = marching.direct(camera, sampled)?;
            direct_lost = lost;
            Ok(lap)
        }
    })?;
    let [full_ms, compact_ms, reject_ms, direct_ms] = [0, 1, 2, 3].map(|i: usize| times[i].net_ms());
    let ideal = density * full_ms;
    Ok(Row {
        density,
        full_ms,
        compact_ms,
        reject_ms,
        direct_ms,
        compact_overhead: compact_ms / ideal,
        reject_overhead: reject_ms / ideal,
        direct_overhead: direct_ms / ideal,
        effective_compression: full_ms / compact_ms,
        direct_lost,
        clock: if times.iter().all(|times| times.device_median_ms.is_some()) { "device" } else { "host" },
    })
}

fn write_csv(path: &Path, rows: &[Row]) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(
            out,
            "density,full_ms,compact_ms,reject_ms,direct_ms,compact_overhead,reject_overhead,direct_overhead,effective_compression,direct_lost"
        )?;
        for r in rows {
            writeln!(
                out,
                "{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}",
                r.density,
                r.full_ms,
                r.compact_ms,
                r.reject_ms,
                r.direct_ms,
                r.compact_overhead,
                r.reject_overhead,
                r.direct_overhead,
                r.effective_compression,
                r.direct_lost
            )?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Draws the paper's figure as SVG: effective compression over density, both on logarithmic scales.
pub fn plotted(rows: &[Row]) -> Result<String> {
    let mut svg = String::new();
    draw(&mut svg, rows).map_err(|e| anyhow!("the plot cannot be drawn: {e}"))?;
    Ok(svg)
}

fn draw(svg: &mut String, rows: &[Row]) -> std::result::Result<(), String> {
    let area = SVGBackend::with_string(svg, (720, 480)).into_drawing_area();
    area.fill(&WHITE).map_err(|e| e.to_string())?;
    let mut chart = ChartBuilder::on(&area)
        .margin(16)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d((0.01..1.0f64).log_scale(), (0.5..120.0f64).log_scale())
        .map_err(|e| e.to_string())?;
    chart
        .configure_mesh()
        .x_desc("density τ")
        .y_desc("effective compression: time(full) / time(τ)")
        .draw()
        .map_err(|e| e.to_string())?;
    type Curve = (&'static str, RGBColor, fn(&Row) -> f64);
    let curves: [Curve; 4] = [
        ("ideal 1/τ", RGBColor(150, 150, 150), |r| 1.0 / r.density),
        ("compact", RGBColor(200, 60, 40), |r| r.full_ms / r.compact_ms),
        ("reject", RGBColor(40, 90, 180), |r| r.full_ms / r.reject_ms),
        ("direct", RGBColor(40, 150, 80), |r| r.full_ms / r.direct_ms),
    ];
    for (name, colour, of) in curves {
        chart
            .draw_series(
                LineSeries::new(rows.iter().map(|r| (r.density, of(r))), colour.stroke_width(2))
                    .point_size(3),
            )
            .map_err(|e| e.to_string())?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()
        .map_err(|e| e.to_string())?;
    area.present().map_err(|e| e.to_string())?;
    Ok(())
}
