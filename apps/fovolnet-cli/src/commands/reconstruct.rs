use crate::bench::rayon_pool;
use crate::console::{JsonOutput, Progress};
use crate::interrupt;
use anyhow::{Context as _, Result, bail};
#[cfg(feature = "gpu")]
use fovolnet::DeviceReconstructor;
use fovolnet::core::{Frame, FrameSize, SampleMask};
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::{Error, atomic};
use fovolnet::net::cpu::Precision;
use fovolnet::{Device, OpenDevice, RandomWeights, Reconstruction, Reconstructor, RenderSettings};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Fill sparse frames of any renderer
#[derive(clap::Args)]
pub struct Reconstruct {
    /// Folder of RGBA pictures sparse_0000.png, … (or .exr); alpha marks the sampled pixels
    sparse: PathBuf,
    /// Folder for the full frames
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// How frames are filled: pull-push, linear, wnet or deepfovea
    #[arg(long, value_name = "HOW", default_value = "pull-push")]
    reconstruct: Reconstruction,
    /// Weights of the network: a safetensors file, or a state dict of PyTorch (.pt) of a network with a name
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// Seeded random weights of a network, to measure its speed
    #[arg(long, value_name = "NAME[:SEED]")]
    random_weights: Option<RandomWeights>,
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

/// What fills frames, on either device.
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

    fn reconstruct(&mut self, sparse: &Frame, motion: Option<&[[f32; 2]]>) -> fovolnet::Result<Frame> {
        match self {
            Self::Cpu(made) => made.reconstruct(sparse, motion),
            #[cfg(feature = "gpu")]
            Self::Gpu(made) => made.reconstruct(sparse, motion),
        }
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
        if self.reconstruct == Reconstruction::None {
            bail!("`none` reconstructs nothing; use --reconstruct pull-push, linear, wnet or deepfovea");
        }
        let settings = RenderSettings {
            reconstruct: Some(self.reconstruct),
            weights: self.weights.clone(),
            random_weights: self.random_weights,
            precision: Some(self.precision),
            ..RenderSettings::default()
        };
        let threads = rayon_pool(self.threads.unwrap_or(0))?;
        let device = self.device.open()?;
        let mut filler: Option<Filler> = None;
        let files = frames_named(&self.sparse, "sparse_")?;
        atomic::make_folder(&self.output)?;
        let mut progress = Progress::new("reconstructing", files.len() as u64);
        let mut frames = Vec::new();
        for path in &files {
            interrupt::check(&format!("{} complete frames are in {}", frames.len(), self.output.display()))?;
            let sparse = image::read(path)?;
            let mask = SampleMask::of_sparse_frame(&sparse);
            let filler = match &mut filler {
                Some(started) => started,
                none => none.insert(self.filler(&device, &settings, sparse.size())?),
            };
            let motion = if filler.uses_motion() { motion_beside(path)? } else { None };
            let started = Instant::now();
            let full = threads
                .install(|| filler.reconstruct(&sparse, motion.as_deref()))
                .with_context(|| format!("{} cannot follow the frames before it", path.display()))?;
            let ms = started.elapsed().as_secs_f64() * 1e3;
            frames.push(FrameFigures {
                file: self.write(path, &full)?,
                samples: mask.count(),
                density: mask.density(),
                ms,
            });
            progress.step();
        }
        drop(progress);
        self.json.say(format!("{} frames in {}", frames.len(), self.output.display()))?;
        self.json.write(&Report { reconstruct: self.reconstruct.to_string(), frames })
    }

    /// What fills frames of `size`; on the processor where the device does not do it.
    fn filler(&self, device: &OpenDevice, settings: &RenderSettings, size: FrameSize) -> Result<Filler> {
        #[cfg(feature = "gpu")]
        if let OpenDevice::Gpu(gpu) = device {
            match DeviceReconstructor::new(gpu, settings, size) {
                Ok(Some(made)) => return Ok(Filler::Gpu(made)),
                Ok(None) => eprintln!("note: {} is filled on the processor", self.reconstruct),
                Err(error) if self.device == Device::Auto && error.is_of_gpu() => {
                    eprintln!("note: filling on the processor: {error}");
                }
                Err(error) => return Err(error.into()),
            }
        }
        #[cfg(not(feature = "gpu"))]
        let _ = device;
        Ok(Filler::Cpu(Reconstructor::new(settings, size)?))
    }

    fn write(&self, sparse: &Path, full: &Frame) -> Result<String> {
        let name = sparse.file_name().unwrap_or_default().to_string_lossy().replacen("sparse_", "frame_", 1);
        let path = self.output.join(&name);
        if name.ends_with(".exr") {
            image::write_exr(&path, full)?;
        } else {
            image::write_png(&path, full, Alpha::Drop)?;
        }
        Ok(name)
    }
}

/// The motion in `motion_0000.exr` beside `sparse_0000.png`, if that file is there: red is the way right and green
/// the way down, in pixels, to where each pixel was in the last frame.
fn motion_beside(sparse: &Path) -> Result<Option<Vec<[f32; 2]>>> {
    let name = sparse.file_name().unwrap_or_default().to_string_lossy().replacen("sparse_", "motion_", 1);
    let path = sparse.with_file_name(name).with_extension("exr");
    if !path.exists() {
        return Ok(None);
    }
    let motion = image::read(&path)?;
    Ok(Some(motion.pixels().iter().map(|&[right, down, ..]| [right, down]).collect()))
}

/// Whether the name `path` is that of a picture which can be read.
pub fn is_picture(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    [".png", ".exr", ".jpg", ".jpeg", ".bmp"].iter().any(|ending| name.ends_with(ending))
}

/// The pictures in `folder` whose names begin with `prefix`, sorted by name.
pub fn frames_named(folder: &Path, prefix: &str) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.starts_with(prefix) && is_picture(&path) {
            files.push(path);
        }
    }
    if files.is_empty() {
        bail!("{}: there are no pictures {prefix}0000.png, … in it; check the folder", folder.display());
    }
    files.sort();
    Ok(files)
}
