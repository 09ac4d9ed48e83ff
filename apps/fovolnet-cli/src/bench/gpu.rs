//! A GPU in a few minutes: its constants, every way to march, and whole frames, with predictions beside them.

use super::pipeline;
use super::record::{Record, Row};
use crate::interrupt;
use crate::outputs;
use anyhow::{Result, bail};
use fovolnet::core::{CameraPath, Frame, FrameSize, Integration, SampleList};
use fovolnet::gpu::{Constant, Gpu};
use fovolnet::render::cpu;
use fovolnet::render::gpu::{FrameBuffers, MarchStrategy, MaskSource, Renderer, Sampling as GpuSampling};
use fovolnet::render::model::{GpuModel, Order, Replay, Work, cost};
use fovolnet::render::noise::Noise;
use fovolnet::{
    Device, OpenDevice, Pipeline, RenderSettings, Sampling, SpeedSettings, Viewpoint, VolumeSettings,
    WeightsChoice, open_volume, parse, scene,
};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A GPU in a few minutes: its constants, every way to march, then whole frames
#[derive(clap::Args)]
pub struct GpuBench {
    /// Results; written anew after every row
    #[arg(short, long, value_name = "FILE.json", value_parser = parse::file())]
    output: String,
    /// Minutes that it may take; rows for which there is no time are left out
    #[arg(long, value_name = "M", default_value_t = 10.0)]
    minutes: f64,
    /// Small volumes and frames: that everything runs and agrees, on any adapter
    #[arg(long)]
    quick: bool,
    /// Keep the rows that FILE has, and add those that it lacks
    #[arg(long)]
    resume: bool,
    /// GPU to measure: gpu, or gpu:NAME
    #[arg(long, value_name = "DEVICE", default_value = "gpu")]
    device: Device,
}

/// Frames of a median; the first one, which compiles and makes room, is not among them.
const FRAMES: u32 = 12;
/// A strategy is dropped after a frame that takes so many times the best median.
const HOPELESS: f64 = 2.0;
/// Sampling densities P_b with widths σ of the fovea; every pixel is marched where P_b is 1.
const SAMPLINGS: [[f64; 2]; 3] = [[0.03, 0.02], [0.07, 0.06], [1.0, 0.0]];

/// A scene of procedural voxels.
struct Subject {
    volume: &'static str,
    side: usize,
    size: FrameSize,
}

impl GpuBench {
    pub fn run(self) -> Result<()> {
        if !(self.minutes > 0.0 && self.minutes.is_finite()) {
            bail!("--minutes {} is no time; give a number above 0", self.minutes);
        }
        let output = PathBuf::from(&self.output);
        outputs::check([output.as_path()])?;
        outputs::have_folders([output.as_path()])?;
        let speed = SpeedSettings { device: Some(self.device.clone()), ..SpeedSettings::default() };
        let OpenDevice::Gpu(gpu) = speed.device().open()? else {
            bail!("bench gpu measures a GPU; give --device gpu or gpu:NAME");
        };
        let mut record = Record::new(output, gpu.info().name, self.resume)?;
        let until = Instant::now() + Duration::from_secs_f64(60.0 * self.minutes);
        let mut run = Run { gpu: &gpu, speed: &speed, record: &mut record, until };
        run.constants(self.quick)?;
        run.host()?;
        let subjects = subjects(self.quick)?;
        for subject in &subjects {
            run.march(subject)?;
        }
        for subject in &subjects {
            run.frames(subject)?;
        }
        record.conclude()
    }
}

/// Scenes to measure, the most important one first.
fn subjects(quick: bool) -> Result<Vec<Subject>> {
    let subject = |volume, side, [width, height]: [u32; 2]| -> Result<Subject> {
        Ok(Subject { volume, side, size: FrameSize::new(width, height)? })
    };
    if quick {
        return Ok(vec![subject("head", 32, [64, 48])?]);
    }
    let (small, large) = ([1280, 720], [3840, 2160]);
    [
        ("head", 256, small),
        ("engine", 256, small),
        ("supernova", 256, small),
        ("engine", 256, large),
        ("supernova", 512, large),
    ]
    .into_iter()
    .map(|(volume, side, size)| subject(volume, side, size))
    .collect()
}

impl Subject {
    fn settings(&self, [pb, sigma]: [f64; 2]) -> RenderSettings {
        RenderSettings {
            size: self.size,
            camera: CameraPath::Flythrough.into(),
            sampling: if pb < 1.0 { Sampling::Compact } else { Sampling::Full },
            pb: pb.min(0.99),
            sigma,
            integration: Integration::Plain,
            ..RenderSettings::default()
        }
    }

    fn open(&self) -> Result<fovolnet::OpenVolume> {
        let read = VolumeSettings { dims: Some([self.side; 3]), ..VolumeSettings::default() };
        Ok(open_volume(self.volume, &read)?)
    }

    fn named(&self, [pb, sigma]: [f64; 2]) -> String {
        let pixels = if pb < 1.0 { format!("({pb}, {sigma})") } else { "every pixel".to_owned() };
        format!("{} {}³, {}, {pixels}", self.volume, self.side, self.size)
    }
}

/// One run on one device.
struct Run<'a> {
    gpu: &'a Gpu,
    speed: &'a SpeedSettings,
    record: &'a mut Record,
    until: Instant,
}

/// A renderer with room for its frames.
struct Marcher {
    renderer: Renderer,
    buffers: FrameBuffers,
}

impl Run<'_> {
    fn has_time(&self) -> Result<bool> {
        interrupt::check("rows so far are kept; --resume adds the others")?;
        Ok(Instant::now() < self.until)
    }

    /// Constants of the device.
    fn constants(&mut self, quick: bool) -> Result<()> {
        for constant in Constant::all(quick) {
            let what = constant.to_string();
            if self.record.has(&what) || !self.has_time()? {
                continue;
            }
            let measured = constant.measure(self.gpu)?;
            self.record.add(Row { what, predicted: None, measured, unit: "µs".into(), equal: None })?;
        }
        Ok(())
    }

    /// Time of the host for a frame that is too small to keep the device busy, and the commands of this frame.
    fn host(&mut self) -> Result<()> {
        let tiny = Subject { volume: "head", side: 16, size: FrameSize::new(16, 16)? };
        let settings = tiny.settings(SAMPLINGS[0]);
        let what = "host, a sparse frame of 16x16, wnet-fast";
        if self.record.has(what) || !self.has_time()? {
            return Ok(());
        }
        let device = OpenDevice::Gpu(self.gpu.clone());
        let mut pipeline = Pipeline::on(device, &tiny.open()?, &settings, self.speed)?;
        let mut all = Vec::new();
        let mut before = self.gpu.commands();
        for i in 0..=4 * FRAMES {
            let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
            before = self.gpu.commands();
            let started = Instant::now();
            pipeline.display_from(i, &viewpoint)?;
            all.push(started.elapsed().as_secs_f64() * 1e3);
            pipeline.finish_display()?;
        }
        let commands = self.gpu.commands().since(before);
        all.sort_by(f64::total_cmp);
        let counted = [("dispatches", commands.dispatches + commands.indirect), ("passes", commands.passes)];
        for (name, count) in counted {
            let (what, unit) = (format!("{name}, a sparse frame, wnet-fast"), name.into());
            self.record.add(Row { what, predicted: None, measured: count as f64, unit, equal: None })?;
        }
        let measured = all[all.len() / 2];
        self.record.add(Row { what: what.into(), predicted: None, measured, unit: "ms".into(), equal: None })
    }

    /// Marches by every strategy, and compares the pictures with those of one thread a ray.
    fn march(&mut self, subject: &Subject) -> Result<()> {
        let names: Vec<String> = MarchStrategy::candidates().map(|strategy| strategy.to_string()).collect();
        let what = |sampling, name: &str| format!("march, {}, {name}", subject.named(sampling));
        let is_known = |record: &Record| {
            SAMPLINGS.into_iter().all(|sampling| names.iter().all(|name| record.has(&what(sampling, name))))
        };
        if is_known(self.record) || !self.has_time()? {
            return Ok(());
        }
        let opened = subject.open()?;
        let scene = scene(&opened, &subject.settings(SAMPLINGS[0]))?;
        let renderer = Renderer::new(self.gpu, &scene)?;
        let buffers = renderer.frame_buffers(subject.size)?;
        let mut marcher = Marcher { renderer, buffers };
        let model =
            model_of(&self.gpu.info().name).map(|gpu| Replay::new(&scene).map(|replay| (replay, gpu)));
        let model = model.transpose()?;
        for sampling in SAMPLINGS {
            let mut best = f64::INFINITY;
            let mut expected: Option<Frame> = None;
            for strategy in MarchStrategy::candidates() {
                let what = what(sampling, &strategy.to_string());
                if !self.has_time()? {
                    return Ok(());
                }
                marcher.renderer.set_march_strategy(strategy);
                let (ms, frame) = marcher.measure(&subject.settings(sampling), sampling, best)?;
                best = best.min(ms);
                let equal = *expected.get_or_insert_with(|| frame.clone()) == frame;
                let predicted = model.as_ref().map(|model| predicted(model, subject, sampling, strategy));
                self.record.add(Row {
                    what,
                    predicted,
                    measured: ms,
                    unit: "ms".into(),
                    equal: Some(equal),
                })?;
            }
        }
        Ok(())
    }

    /// Whole frames by networks, sparse, and every pixel without one.
    fn frames(&mut self, subject: &Subject) -> Result<()> {
        let sparse = SAMPLINGS[0];
        let full = SAMPLINGS[2];
        let runs = [(sparse, Some("wnet-fast")), (sparse, Some("wnet-paper")), (full, None)];
        for (sampling, network) in runs {
            let how = network.unwrap_or("no network");
            let what = format!("frame, {}, {how}", subject.named(sampling));
            if self.record.has(&what) || !self.has_time()? {
                continue;
            }
            let mut settings = subject.settings(sampling);
            if let Some(name) = network {
                settings.weights = WeightsChoice::Named(name.into());
            }
            let mut pipeline = Pipeline::new(&subject.open()?, &settings, self.speed)?;
            let Some(ms) = pipeline::displayed_median_ms(&mut pipeline, FRAMES + 1)? else { continue };
            self.record.add(Row { what, predicted: None, measured: ms, unit: "ms".into(), equal: None })?;
        }
        Ok(())
    }
}

impl Marcher {
    /// Median of the device's time of marching, or of the host's where the device has no clock, and the picture of frame 0. Ends
    /// early where it is far from `best`.
    fn measure(&mut self, settings: &RenderSettings, [pb, _]: [f64; 2], best: f64) -> Result<(f64, Frame)> {
        let is_sparse = pb < 1.0;
        self.march(settings, is_sparse, 0)?;
        let picture = self.buffers.read_frame()?;
        let mut all = Vec::new();
        for frame in 1..=FRAMES {
            let ms = self.march(settings, is_sparse, frame)?;
            all.push(ms);
            if ms > HOPELESS * best {
                break;
            }
        }
        all.sort_by(f64::total_cmp);
        Ok((all[all.len() / 2], picture))
    }

    /// Marches frame number `frame`, and returns its milliseconds.
    fn march(&mut self, settings: &RenderSettings, is_sparse: bool, frame: u32) -> Result<f64> {
        interrupt::check("rows so far are kept; --resume adds the others")?;
        let noise = Noise::new(settings.noise, settings.seed);
        let fovea = settings.fovea(frame)?;
        let source = MaskSource { fovea: &fovea, noise: &noise, frame };
        let sampling = if is_sparse { GpuSampling::Compact(source) } else { GpuSampling::Full };
        let started = Instant::now();
        self.renderer.render(&mut self.buffers, &CameraPath::Flythrough.camera(frame), sampling)?;
        self.renderer.gpu().wait()?;
        let host_ms = started.elapsed().as_secs_f64() * 1e3;
        let times = self.buffers.read_times()?;
        Ok(times.map_or(host_ms, |times| times.iter().map(|time| time.ms).sum()))
    }
}

/// The model's GPU for an adapter of this name.
fn model_of(adapter: &str) -> Option<GpuModel> {
    let adapter = adapter.to_lowercase().replace(' ', "-");
    GpuModel::ALL.into_iter().find(|gpu| adapter.contains(gpu.name))
}

/// Milliseconds of frame 0 by the model.
fn predicted(
    (replay, gpu): &(Replay, GpuModel),
    subject: &Subject,
    sampling: [f64; 2],
    strategy: MarchStrategy,
) -> f64 {
    let settings = subject.settings(sampling);
    let (list, order) = if sampling[0] < 1.0 {
        let noise = Noise::new(settings.noise, settings.seed);
        let fovea = settings.fovea(0).unwrap_or_default();
        (cpu::compact(&cpu::mask(&fovea, subject.size, &noise, 0)), Order::Tiles)
    } else {
        (all_pixels(subject.size), Order::Squares)
    };
    let work = match strategy {
        MarchStrategy::Rays => Work::Rays,
        MarchStrategy::Pool(pool) => {
            let [rays, threads, queue] = [pool.rays(), pool.threads(), pool.queue()].map(|n| n as usize);
            Work::Pool { rays, threads, queue }
        }
    };
    let camera = CameraPath::Flythrough.camera(0);
    cost((replay, gpu), (&camera, subject.size), (list.pixels(), order), (work, true)).ms
}

fn all_pixels(size: FrameSize) -> SampleList {
    cpu::compact(&fovolnet::core::SampleMask::full(size))
}
