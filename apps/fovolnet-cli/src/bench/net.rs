use crate::console::JsonOutput;
use crate::interrupt;
use crate::thread_pool::thread_pool;
use anyhow::{Result, anyhow};
#[cfg(feature = "gpu")]
use fovolnet::OpenDevice;
use fovolnet::core::{Fovea, FrameSize, Pixel, SparseFrame};
#[cfg(feature = "gpu")]
use fovolnet::gpu::Timing;
use fovolnet::net::Weights;
use fovolnet::net::cpu::{FrameInput, Network, Precision, Simd, calibrate, peak_flops};
#[cfg(feature = "gpu")]
use fovolnet::net::gpu::{self, DeviceInput, State};
use fovolnet::net::plan::{Layer, Plan};
use fovolnet::render::cpu::{compact, mask};
use fovolnet::render::noise::{Noise, NoiseKind};
use fovolnet::{Device, RandomWeights, parse};
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
    #[arg(long, value_name = "FILE", value_parser = parse::file())]
    weights: Option<String>,
    /// Frame size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    size: FrameSize,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Precision: auto, f32, bf16, f16, int8 or mixed; auto, f32 or f16 on a GPU
    #[arg(long, value_name = "P", default_value = "auto")]
    precision: Precision,
    /// Device that computes the frames: auto, cpu, gpu, or gpu:NAME
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    device: Device,
    /// Number of measured frames
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
    /// Instruction set, or name of the GPU.
    on: String,
    threads: usize,
    median_ms: f64,
    min_ms: f64,
    /// Median by the device's clock, which excludes submitting and waiting; `None` without such a clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    device_median_ms: Option<f64>,
    tflops: f64,
    /// Peak performance of this machine in this precision, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_tflops: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_share: Option<f64>,
    peak_memory_mb: Option<f64>,
    layers: Vec<LayerReport>,
}

#[derive(Serialize)]
struct LayerReport {
    name: String,
    median_ms: f64,
    gmacs: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_share: Option<f64>,
}

/// Times of whole frames, and of layers. A layer is a range of steps of the plan.
#[derive(Default)]
struct Measured {
    frames_ms: Vec<f64>,
    device_ms: Vec<f64>,
    layers_ms: BTreeMap<usize, (Range<usize>, Vec<f64>)>,
}

impl Measured {
    fn add_layers(&mut self, layers: Range<usize>, ms: f64) {
        self.layers_ms.entry(layers.start).or_insert((layers, Vec::new())).1.push(ms);
    }
}

impl NetBench {
    pub fn run(self) -> Result<()> {
        let pool = thread_pool(self.threads.unwrap_or(0))?;
        let report = pool.install(|| self.measure())?;
        self.json.say(format!(
            "{} at {}, {} on {}: median {:.1} ms, {:.3} TFLOP/s{}{}",
            report.network,
            report.size,
            report.precision,
            report.on,
            report.median_ms,
            report.tflops,
            report.peak_share.zip(report.peak_tflops).map_or(String::new(), |(share, peak)| {
                format!(", {:.0} % of this machine's {peak:.3}", 100.0 * share)
            }),
            report.peak_memory_mb.map_or(String::new(), |mb| format!(", {mb:.0} MB at most"))
        ))?;
        self.json.say("layer                                     median ms    GMAC  % of peak")?;
        for layer in &report.layers {
            self.json.say(format!(
                "{:<40} {:>10.2} {:>7.2} {:>9}",
                layer.name,
                layer.median_ms,
                layer.gmacs,
                layer.peak_share.map_or("-".into(), |share| format!("{:.0}", 100.0 * share))
            ))?;
        }
        self.json.write(&report)
    }

    fn measure(&self) -> Result<Report> {
        let weights = match &self.weights {
            Some(name) => Weights::named_or_read(name)?,
            None => Weights::random(&self.random_weights.network.config(), self.random_weights.seed)?,
        };
        let plan = weights.config.plan().map_err(|problem| anyhow!(problem))?;
        #[cfg(feature = "gpu")]
        if let OpenDevice::Gpu(device) = self.device.open()? {
            let precision = match self.precision {
                Precision::Auto => gpu::Precision::Auto,
                Precision::F32 => gpu::Precision::F32,
                Precision::F16 => gpu::Precision::F16,
                other => {
                    anyhow::bail!("graphics processors know no {other}; use --precision auto, f32 or f16")
                }
            };
            let network = gpu::Network::new(&device, plan, &weights, precision)?;
            let measured = self.on_gpu(&network)?;
            return Ok(self.report(
                network.plan(),
                measured,
                (network.precision().name(), device.info().name),
                None,
            ));
        }
        #[cfg(not(feature = "gpu"))]
        self.device.open()?;
        self.on_cpu(plan, weights)
    }

    fn on_cpu(&self, plan: Plan, mut weights: Weights) -> Result<Report> {
        if weights.ranges.is_empty() && matches!(self.precision, Precision::Int8 | Precision::Mixed) {
            let sparse = sparse_frame(FrameSize::new(256, 144)?, 0);
            calibrate(&mut weights, &[vec![FrameInput { sparse: &sparse, motion: None }]])?;
        }
        let network = Network::new(plan, &weights, Simd::best(), self.precision)?;
        // Source weights are not needed to run the network.
        drop(weights);
        let mut state = network.state(self.size);
        let peak = peak_flops(network.simd(), network.precision());
        let mut measured = Measured::default();
        for round in 0..self.repeats.max(1) + WARM_UP {
            interrupt::check("nothing was written")?;
            let sparse = sparse_frame(self.size, round as u32);
            let input = FrameInput { sparse: &sparse, motion: None };
            let started = Instant::now();
            let mut part = Vec::new();
            network.observed(&input, &mut state, |layers, _, took| {
                part.push((layers, took.as_secs_f64() * 1e3));
            })?;
            if round >= WARM_UP {
                measured.frames_ms.push(started.elapsed().as_secs_f64() * 1e3);
                part.into_iter().for_each(|(layers, ms)| measured.add_layers(layers, ms));
            }
        }
        let on = format!("{}, {} threads", network.simd(), rayon::current_num_threads());
        Ok(self.report(network.plan(), measured, (network.precision().name(), on), Some(peak)))
    }

    /// Measures frames whose data stay on the device. Layers are timed in extra frames, since separate passes take time
    /// of their own.
    #[cfg(feature = "gpu")]
    fn on_gpu(&self, network: &gpu::Network) -> Result<Measured> {
        let mut state = network.state(self.size)?;
        let sparse = sparse_frame(self.size, 0).to_frame();
        let sparse = network.gpu().upload("sparse frame", bytemuck::cast_slice(sparse.pixels()))?;
        let input = DeviceInput { sparse: &sparse, motion: None };
        let gpu = network.gpu();
        let mut timing = Timing::new(gpu, 1);
        let mut run = |state: &mut State| -> Result<Option<f64>> {
            gpu.submit("reconstructing", |encoder| {
                timing.begin();
                timing.span(encoder, "network", |encoder| network.encode(encoder, input, state))?;
                timing.end(encoder);
                Ok::<_, fovolnet::net::Error>(())
            })?;
            gpu.wait()?;
            Ok(timing.read(gpu)?.and_then(|times| Some(times.first()?.ms)))
        };
        let mut measured = Measured::default();
        for round in 0..self.repeats.max(1) + WARM_UP {
            interrupt::check("nothing was written")?;
            let started = Instant::now();
            let device_ms = run(&mut state)?;
            if round >= WARM_UP {
                measured.frames_ms.push(started.elapsed().as_secs_f64() * 1e3);
                measured.device_ms.extend(device_ms);
            }
        }
        state.set_timed(true);
        for _ in 0..self.repeats.max(1) {
            run(&mut state)?;
            for time in state.read_times()?.into_iter().flatten() {
                if let Some(layer) = time.layer {
                    measured.add_layers(layer..layer + 1, time.ms);
                }
            }
        }
        Ok(measured)
    }

    fn report(
        &self,
        plan: &Plan,
        mut measured: Measured,
        (precision, on): (&'static str, String),
        peak: Option<f64>,
    ) -> Report {
        let pixels = self.size.pixels() as f64;
        let flops = |macs: f64, ms: f64| 2.0 * macs * pixels / (ms / 1e3);
        let share = |macs: f64, ms: f64| peak.map(|peak| flops(macs, ms) / peak);
        let median_ms = median(&mut measured.frames_ms);
        let layers = measured.layers_ms.into_values().map(|(places, mut ms)| {
            let together = &plan.layers()[places];
            let macs = together.iter().map(|layer| layer.macs_per_pixel(plan.tensors())).sum();
            let ms = median(&mut ms);
            let names: Vec<&str> = together.iter().map(Layer::name).collect();
            LayerReport {
                name: names.join(" "),
                median_ms: ms,
                gmacs: macs * pixels / 1e9,
                peak_share: share(macs, ms),
            }
        });
        Report {
            network: self.weights.clone().unwrap_or_else(|| self.random_weights.to_string()),
            size: self.size,
            precision,
            on,
            threads: rayon::current_num_threads(),
            layers: layers.collect(),
            min_ms: measured.frames_ms[0],
            tflops: flops(plan.macs_per_pixel(), median_ms) / 1e12,
            peak_tflops: peak.map(|peak| peak / 1e12),
            peak_share: share(plan.macs_per_pixel(), median_ms),
            median_ms,
            device_median_ms: Some(median(&mut measured.device_ms)).filter(|ms| *ms > 0.0),
            peak_memory_mb: peak_memory_mb(),
        }
    }
}

/// Frames before the measured ones; after two, all memory has been touched once.
const WARM_UP: usize = 2;

/// Sparse frame of the default fovea's density. Speed does not depend on the colours or the kind of noise; uniform
/// noise needs no tables in memory.
fn sparse_frame(size: FrameSize, number: u32) -> SparseFrame {
    let list = compact(&mask(&Fovea::default(), size, &Noise::new(NoiseKind::Uniform, 0), number));
    let colour = |pixel: &Pixel| {
        let [x, y] = [u32::from(pixel.x) + 3 * number, u32::from(pixel.y)].map(|at| at as f32);
        [0.01, 0.02, 0.05].map(|f| 0.5 + 0.5 * (x * f + y * 0.01).sin())
    };
    let colours: Vec<_> = list.pixels().iter().map(colour).collect();
    let depths = vec![1.0; list.len()];
    SparseFrame::new(list, colours, depths)
}

/// Median of `values`; sorts them.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Peak memory of this process in millions of bytes, if the system reports it.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}
