use super::rayon_pool;
use crate::console::JsonOutput;
use crate::interrupt;
use anyhow::{Result, anyhow};
use fovolnet::RandomWeights;
use fovolnet::core::{Fovea, Frame, FrameSize};
use fovolnet::net::Weights;
use fovolnet::net::cpu::{FrameInput, Network, Precision, Simd, calibrate, peak_flops};
use fovolnet::net::plan::Layer;
use fovolnet::render::cpu::mask;
use fovolnet::render::noise::{Noise, NoiseKind};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

/// Reconstruction networks: whole and layer by layer, against the peak of this machine
#[derive(clap::Args)]
pub struct NetBench {
    /// Seeded random weights of a network: wnet-paper, wnet-narrow, wnet-fast, deepfovea-fvn or
    /// deepfovea-orig
    #[arg(long, value_name = "NAME[:SEED]", default_value = "wnet-paper", conflicts_with = "weights")]
    random_weights: RandomWeights,
    /// Weights: a safetensors file, or a state dict of PyTorch (.pt) of a network with a name
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// Frame size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: FrameSize,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Instruction set: portable, avx2, avx512 or amx [default: the best one]
    #[arg(long, value_name = "SET")]
    simd: Option<Simd>,
    /// Precision: auto, f32, bf16, int8 or mixed
    #[arg(long, value_name = "P", default_value = "auto")]
    precision: Precision,
    /// Frames that are measured
    #[arg(long, value_name = "N", default_value_t = 5)]
    repeats: usize,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    network: String,
    size: FrameSize,
    precision: &'static str,
    simd: &'static str,
    threads: usize,
    median_ms: f64,
    min_ms: f64,
    tflops: f64,
    peak_tflops: f64,
    peak_share: f64,
    peak_memory_mb: Option<f64>,
    layers: Vec<LayerReport>,
}

#[derive(Serialize)]
struct LayerReport {
    name: String,
    median_ms: f64,
    gmacs: f64,
    peak_share: f64,
}

impl NetBench {
    pub fn run(self) -> Result<()> {
        let pool = rayon_pool(self.threads.unwrap_or(0))?;
        let report = pool.install(|| self.measure())?;
        self.json.say(format!(
            "{} at {}, {} on {}, {} threads: median {:.1} ms, {:.3} TFLOP/s, {:.0} % of this machine's {:.3}{}",
            report.network,
            report.size,
            report.precision,
            report.simd,
            report.threads,
            report.median_ms,
            report.tflops,
            100.0 * report.peak_share,
            report.peak_tflops,
            report.peak_memory_mb.map_or(String::new(), |mb| format!(", {mb:.0} MB at most"))
        ))?;
        self.json.say("layer                                     median ms    GMAC  % of peak")?;
        for layer in &report.layers {
            self.json.say(format!(
                "{:<40} {:>10.2} {:>7.2} {:>9.0}",
                layer.name,
                layer.median_ms,
                layer.gmacs,
                100.0 * layer.peak_share
            ))?;
        }
        self.json.write(&report)
    }

    fn measure(&self) -> Result<Report> {
        let mut weights = match &self.weights {
            Some(name) => Weights::named_or_read(name)?,
            None => Weights::random(&self.random_weights.network.config(), self.random_weights.seed)?,
        };
        let plan = weights.config.plan().map_err(|problem| anyhow!(problem))?;
        if weights.ranges.is_empty() && matches!(self.precision, Precision::Int8 | Precision::Mixed) {
            let sparse = sparse_frame(FrameSize::new(256, 144)?, 0);
            calibrate(&mut weights, &[vec![FrameInput { sparse: &sparse, motion: None }]])?;
        }
        let network = Network::new(plan, &weights, self.simd.unwrap_or_else(Simd::best), self.precision)?;
        let mut state = network.state(self.size);
        let peak = peak_flops(network.simd(), network.precision());
        let mut times = Vec::new();
        let mut layers: BTreeMap<usize, (Range<usize>, Vec<f64>)> = BTreeMap::new();
        for round in 0..self.repeats.max(1) + WARM_UP {
            interrupt::check("nothing was written")?;
            let sparse = sparse_frame(self.size, round as u32);
            let started = Instant::now();
            let input = FrameInput { sparse: &sparse, motion: None };
            let mut part = Vec::new();
            network.observed(&input, &mut state, |layers, _, took| {
                part.push((layers, took.as_secs_f64() * 1e3));
            })?;
            if round >= WARM_UP {
                times.push(started.elapsed().as_secs_f64() * 1e3);
                for (places, ms) in part {
                    layers.entry(places.start).or_insert((places, Vec::new())).1.push(ms);
                }
            }
        }
        let pixels = self.size.pixels() as f64;
        let plan = network.plan();
        let flops = |macs: f64, ms: f64| 2.0 * macs * pixels / (ms / 1e3);
        let median_ms = median(&mut times);
        let layers = layers.into_values().map(|(places, mut ms)| {
            let together = &plan.layers()[places];
            let macs = together.iter().map(|layer| layer.macs_per_pixel(plan.tensors())).sum();
            let ms = median(&mut ms);
            let names: Vec<&str> = together.iter().map(Layer::name).collect();
            LayerReport {
                name: names.join(" "),
                median_ms: ms,
                gmacs: macs * pixels / 1e9,
                peak_share: flops(macs, ms) / peak,
            }
        });
        Ok(Report {
            network: self.weights.clone().unwrap_or_else(|| self.random_weights.to_string()),
            size: self.size,
            precision: network.precision().name(),
            simd: network.simd().name(),
            threads: rayon::current_num_threads(),
            layers: layers.collect(),
            min_ms: times[0],
            tflops: flops(plan.macs_per_pixel(), median_ms) / 1e12,
            peak_tflops: peak / 1e12,
            peak_share: flops(plan.macs_per_pixel(), median_ms) / peak,
            median_ms,
            peak_memory_mb: peak_memory_mb(),
        })
    }
}

/// Frames before the measured ones: after two, all memory has been used once.
const WARM_UP: usize = 2;

/// A frame whose samples lie as the default fovea has them: speed does not depend on what they show.
fn sparse_frame(size: FrameSize, number: u32) -> Frame {
    let samples = mask(&Fovea::default(), size, &Noise::new(NoiseKind::default(), 0), number);
    let mut frame = Frame::new(size);
    for y in 0..size.height {
        for x in 0..size.width {
            if samples.contains(x, y) {
                let wave = |f: f32| 0.5 + 0.5 * ((x + 3 * number) as f32 * f + y as f32 * 0.01).sin();
                frame.pixels_mut()[(y * size.width + x) as usize] = [wave(0.01), wave(0.02), wave(0.05), 1.0];
            }
        }
    }
    frame
}

/// The median of `values`, which are sorted.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// What this process has used at most, where the system says it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes / 1e3)
}
