//! Cost of marching a frame on a GPU, by the model.

use crate::console::JsonOutput;
use anyhow::{Result, bail};
use fovolnet::core::{Camera, Pixel, Scene};
use fovolnet::render::cpu;
use fovolnet::render::model::{GpuModel, MarchCost, Order, Replay, Work, cost};
use fovolnet::render::noise::Noise;
use fovolnet::{RenderSettings, core::did_you_mean};
use serde::Serialize;

/// Strategies of the model.
const WORK: [(&str, Work); 4] = [
    ("rays", Work::Rays),
    ("pool:1,32", Work::Pool { rays: 1, threads: 32, queue: 128 }),
    ("pool:4,128", Work::Pool { rays: 4, threads: 128, queue: 128 }),
    ("pool:16,128", Work::Pool { rays: 16, threads: 128, queue: 32 }),
];

#[derive(Serialize)]
struct Report {
    gpu: &'static str,
    /// Every pixel of the frame.
    strategies: Vec<Row>,
    sparse: Sparse,
}

/// The sampled pixels of the frame.
#[derive(Serialize)]
struct Sparse {
    pb: f64,
    sigma: f64,
    pixels: usize,
    strategies: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    name: String,
    longest_chain: u64,
    warp_steps: u64,
    busy_lanes: f64,
    loads_per_shadow_step: f64,
    ms: f64,
}

impl Row {
    fn new(name: String, cost: MarchCost) -> Self {
        let MarchCost { longest_chain, warp_steps, busy_lanes, loads_per_shadow_step, ms } = cost;
        Self { name, longest_chain, warp_steps, busy_lanes, loads_per_shadow_step, ms }
    }
}

/// The GPU called `name`.
pub fn gpu(name: &str) -> Result<GpuModel> {
    let names = GpuModel::ALL.map(|gpu| gpu.name);
    match GpuModel::named(name) {
        Some(gpu) => Ok(gpu),
        None => bail!(
            "the model does not know the GPU `{name}`; use {}{}",
            names.join(", "),
            did_you_mean(name, &names)
        ),
    }
}

/// Says what frame 0 of `settings` costs on `gpu`: every pixel, and the sampled ones.
pub fn report(
    scene: &Scene,
    camera: &Camera,
    settings: &RenderSettings,
    gpu: &GpuModel,
    json: &JsonOutput,
) -> Result<()> {
    let replay = Replay::new(scene)?;
    let size = settings.size;
    let rows = |pixels: &[Pixel], orders: &[(&str, Order)]| {
        let mut rows = Vec::new();
        for (name, work) in WORK {
            for (suffix, order) in orders {
                for (with, columns) in [("", false), (" columns", true)] {
                    let cost = cost((&replay, gpu), (camera, size), (pixels, *order), (work, columns));
                    rows.push(Row::new(format!("{name}{suffix}{with}"), cost));
                }
            }
        }
        rows
    };
    let all: Vec<Pixel> = cpu::compact(&fovolnet::core::SampleMask::full(size)).pixels().to_vec();
    let noise = Noise::new(settings.noise, settings.seed);
    let fovea = settings.fovea(settings.first_frame)?;
    let list = cpu::compact(&cpu::mask(&fovea, size, &noise, settings.first_frame));
    let report = Report {
        gpu: gpu.name,
        strategies: rows(&all, &[("", Order::Squares)]),
        sparse: Sparse {
            pb: settings.pb,
            sigma: settings.sigma,
            pixels: list.len(),
            strategies: rows(list.pixels(), &[(" raster", Order::Raster), ("", Order::Tiles)]),
        },
    };
    for (what, rows) in [("every pixel", &report.strategies), ("sampled pixels", &report.sparse.strategies)] {
        json.say(format!("{what} on {}, by the model:", gpu.name))?;
        json.say("strategy                      chain  warp steps  busy lanes  loads a step       ms")?;
        for row in rows {
            json.say(format!(
                "{:<24} {:>10} {:>11} {:>10.0}% {:>13.2} {:>8.3}",
                row.name,
                row.longest_chain,
                row.warp_steps,
                100.0 * row.busy_lanes,
                row.loads_per_shadow_step,
                row.ms
            ))?;
        }
    }
    json.write(&report)
}
