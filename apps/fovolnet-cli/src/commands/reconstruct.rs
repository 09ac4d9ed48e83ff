use crate::console::{JsonOutput, Progress};
use crate::frame_sequence::file_name;
use crate::sparse_sequence::SparseSequence;
use crate::thread_pool::thread_pool;
use crate::{interrupt, outputs};
use anyhow::{Context as _, Result};
#[cfg(feature = "gpu")]
use fovolnet::DeviceReconstructor;
use fovolnet::core::memory::Estimate;
use fovolnet::core::{Frame, FrameSize, SparseFrame};
use fovolnet::guide::{UpsampledGuide, compose, light_ratios};
use fovolnet::io::atomic;
use fovolnet::io::image::{self, Alpha};
use fovolnet::net::cpu::Precision;
use fovolnet::{
    Device, Error, OpenDevice, RandomWeights, Reconstruction, Reconstructor, RenderOverrides, RenderSettings,
    parse,
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Format of frames from other renderers, for `--help`.
const CONTRACT: &str = "\
Frames are SPARSE/sparse_NUMBER.png or .exr, in the order of their numbers, all of one size, with alpha: 1 where the \
pixel is sampled, 0 elsewhere. Colours are display values (sRGB), 0 to 1, not premultiplied, in EXR files too. Where \
SPARSE/motion_NUMBER.exr is, its channels X and Y (or U and V, or R and G) lead from each pixel to where it was in the \
frame before: previous position = current position + motion, in pixels, x to the right, y down. Where \
SPARSE/guide_NUMBER.exr is, for every frame, it is the guide of the light ratio: red, green, blue without shadows, times \
opacity, and opacity as alpha. Full frames are frame_NUMBER of the same format. docs/reconstruct.md says more.";

/// Fill sparse frames of any renderer
#[derive(clap::Args)]
#[command(after_long_help = CONTRACT)]
pub struct Reconstruct {
    /// Folder of RGBA pictures sparse_0000.png, … (or .exr), alpha 1 at sampled pixels; and of motion_0000.exr, … and
    /// guide_0000.exr, …
    sparse: PathBuf,
    /// Folder for the full frames
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// How frames are filled: pull-push, linear, wnet or deepfovea [default: the network of the weights that are given,
    /// else wnet]
    #[arg(long, value_name = "HOW")]
    reconstruct: Option<Reconstruction>,
    /// Weights of the network: a name, a safetensors file, or a state dict of PyTorch (.pt) of a network with a name
    /// [default: wnet-fast for wnet]
    #[arg(long, value_name = "NAME|FILE", value_parser = parse::file())]
    weights: Option<String>,
    /// Seeded random weights of a network, to measure its speed
    #[arg(long, value_name = "NAME[:SEED]")]
    random_weights: Option<RandomWeights>,
    /// Background of the frames, with a guide: 0 to 1 each
    #[arg(long, value_name = "R,G,B", value_parser = parse::colour, default_value = "0,0,0", allow_hyphen_values = true)]
    background: [f64; 3],
    /// Precision of the network: auto, f32, bf16, int8 or mixed
    #[arg(long, value_name = "P", default_value = "auto")]
    precision: Precision,
    /// Where it is done: auto, cpu, gpu or gpu:NAME
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: Device,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    json: JsonOutput,
}

/// Reconstructor on the CPU or the GPU.
enum Filler {
    Cpu(Reconstructor),
    #[cfg(feature = "gpu")]
    Gpu(DeviceReconstructor),
}

impl Filler {
    fn uses_motion(&self) -> bool {
        match self {
            Self::Cpu(made) => made.uses_motion(),
            #[cfg(feature = "gpu")]
            Self::Gpu(made) => made.uses_motion(),
        }
    }

    fn reconstruct(&mut self, sparse: &SparseFrame, motion: Option<&[[f32; 2]]>) -> fovolnet::Result<Frame> {
        match self {
            Self::Cpu(made) => made.reconstruct(sparse, motion),
            #[cfg(feature = "gpu")]
            Self::Gpu(made) => made.reconstruct(sparse, motion),
        }
    }
}

/// Frame of another renderer.
struct Given<'a> {
    sparse: &'a SparseFrame,
    motion: Option<&'a [[f32; 2]]>,
    guide: Option<&'a UpsampledGuide>,
}

impl Filler {
    /// Full frame of `given`, of its colours or of its light ratio over `background`.
    fn fill(&mut self, given: &Given<'_>, background: [f64; 3]) -> fovolnet::Result<Frame> {
        let Given { sparse, motion, guide } = *given;
        let Some(guide) = guide else { return self.reconstruct(sparse, motion) };
        let background = background.map(|value| value as f32);
        let mut frame = self.reconstruct(&light_ratios(sparse, guide, background), motion)?;
        compose(&mut frame, guide, sparse, background);
        Ok(frame)
    }
}

#[derive(Serialize)]
struct FrameFigures {
    file: String,
    samples: usize,
    density: f64,
    ms: f64,
}

#[derive(Serialize)]
struct Report {
    reconstruct: String,
    frames: Vec<FrameFigures>,
}

impl Reconstruct {
    pub fn run(self) -> Result<()> {
        let settings = self.settings()?;
        let how = settings.reconstruction;
        let mut sequence = SparseSequence::open(&self.sparse)?;
        let size = sequence.size();
        // Sparse and full frame, and the guide. Networks check their own memory once they know the part of a frame they work on.
        let frames = if sequence.has_guide() { 3 } else { 2 };
        Estimate::new(format!("filling frames of {size}"))
            .with("frames", (frames * size.pixels() * size_of::<[f32; 4]>()) as u64)
            .check("sparse frames of a smaller size need less")?;
        let threads = thread_pool(self.threads.unwrap_or(0))?;
        let device = self.device.open()?;
        let mut filler = self.filler(&device, &settings, sequence.size())?;
        if !filler.uses_motion() {
            sequence.leave_motion_out(&self.weights.clone().unwrap_or_else(|| how.to_string()));
        }
        let written: Vec<PathBuf> = (0..sequence.len()).map(|i| self.path_of(sequence.path(i))).collect();
        outputs::check(written.iter().map(PathBuf::as_path).chain(self.json.file()))?;
        atomic::make_folder(&self.output)?;
        outputs::have_folders(self.json.file())?;
        let mut progress = Progress::new("reconstructing", sequence.len() as u64);
        let mut frames = Vec::new();
        for i in 0..sequence.len() {
            let made = interrupt::unless_asked(|| {
                let sparse = sequence.frame(i)?;
                let motion = if filler.uses_motion() { sequence.motion(i)? } else { None };
                let guide = sequence.guide(i)?;
                let given = Given { sparse: &sparse, motion: motion.as_deref(), guide: guide.as_ref() };
                let started = Instant::now();
                let full = threads.install(|| filler.fill(&given, self.background)).with_context(|| {
                    format!("{} cannot follow the frames before it", sequence.path(i).display())
                })?;
                Ok((sparse.len(), full, started.elapsed().as_secs_f64() * 1e3))
            })?;
            let (samples, full, ms) = made.ok_or_else(|| self.interrupted(frames.len()))?;
            frames.push(FrameFigures {
                file: self.write(sequence.path(i), &full)?,
                samples,
                density: samples as f64 / size.pixels() as f64,
                ms,
            });
            progress.step();
        }
        drop(progress);
        self.json.say(format!("{} frames by {how} in {}", frames.len(), self.output.display()))?;
        self.json.write(&Report { reconstruct: how.to_string(), frames })
    }

    /// Error of an interruption after `complete` frames.
    fn interrupted(&self, complete: usize) -> anyhow::Error {
        interrupt::error(&format!("{complete} complete frames are in {}", self.output.display()))
    }

    /// Checked settings of the command line.
    fn settings(&self) -> Result<RenderSettings> {
        let given = RenderOverrides {
            reconstruct: self.reconstruct,
            weights: self.weights.clone(),
            random_weights: self.random_weights,
            precision: Some(self.precision),
            ..RenderOverrides::default()
        };
        given.check_flags()?;
        let settings = given.resolve()?;
        if settings.reconstruction == Reconstruction::None {
            let problem =
                "`none` reconstructs nothing; use --reconstruct pull-push, linear, wnet or deepfovea";
            return Err(Error::Contradiction(problem.into()).into());
        }
        Ok(settings)
    }

    /// Reconstructor for frames of `size`; on the CPU if the device does not support the method.
    fn filler(&self, device: &OpenDevice, settings: &RenderSettings, size: FrameSize) -> Result<Filler> {
        #[cfg(feature = "gpu")]
        if let OpenDevice::Gpu(gpu) = device {
            match DeviceReconstructor::new(gpu, settings, size) {
                Ok(Some(made)) => return Ok(Filler::Gpu(made)),
                Ok(None) => {
                    crate::console::note(format!("{} is filled on the processor", settings.reconstruction));
                }
                Err(error) if self.device == Device::Auto && error.is_of_gpu() => {
                    crate::console::note(format!("filling on the processor: {error}"));
                }
                Err(error) => return Err(error.into()),
            }
        }
        #[cfg(not(feature = "gpu"))]
        let _ = device;
        Ok(Filler::Cpu(Reconstructor::new(settings, size)?))
    }

    /// Path of the full frame for the file `sparse`.
    fn path_of(&self, sparse: &Path) -> PathBuf {
        let name = file_name(sparse).replacen("sparse_", "frame_", 1);
        self.output.join(name).with_extension(if is_exr(sparse) { "exr" } else { "png" })
    }

    fn write(&self, sparse: &Path, full: &Frame) -> Result<String> {
        let path = self.path_of(sparse);
        if is_exr(sparse) {
            image::write_exr(&path, full)?;
        } else {
            image::write_png(&path, full, Alpha::Drop)?;
        }
        Ok(file_name(&path))
    }
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}
