use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use fovol_train::clips::ClipSet;
use fovol_train::trainer::{Ended, TrainConfig, Trainer};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tch::Device;

/// Makes the clips that a configuration asks for and trains its network on them.
#[derive(Args)]
pub struct Train {
    /// What to train, on what and how: a TOML file
    #[arg(value_name = "CONFIG.toml")]
    config: PathBuf,
    /// Folder for checkpoints, weights, log and pictures
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Go on from the checkpoint there
    #[arg(long)]
    resume: bool,
    /// Stop, ready to be resumed, after this many hours
    #[arg(long, value_name = "H")]
    hours: Option<f64>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Where::Auto)]
    device: Where,
    /// Number of threads
    #[arg(long, value_name = "N")]
    threads: Option<u16>,
    /// Train on the clips that are there, without making those that are missing
    #[arg(long, conflicts_with = "clips_only")]
    clips_as_they_are: bool,
    /// Only make the clips
    #[arg(long)]
    clips_only: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Where {
    Auto,
    Cpu,
    Cuda,
}

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

impl Train {
    pub fn run(&self) -> Result<()> {
        if let Some(threads) = self.threads {
            tch::set_num_threads(threads.into());
        }
        ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed)).context("cannot listen to Ctrl-C")?;
        let started = Instant::now();
        let mut config = TrainConfig::read(&self.config)?;
        // Paths in the file are relative to it.
        let base = self.config.parent().unwrap_or(Path::new("."));
        config.from = config.from.map(|path| base.join(path));
        let sets = config.clips.sets(base)?;
        let missing = sets.iter().zip(["to learn from", "to judge by"]).rev();
        for (set, what) in missing.filter(|_| !self.clips_as_they_are) {
            self.make(set, what)?;
        }
        if self.clips_only || STOP.load(Ordering::Relaxed) {
            return Ok(());
        }
        let [learned, judged] = config.clips.open(base)?;
        let mut trainer = Trainer::new(config, &self.output, self.device()?, self.resume)?;
        println!(
            "{} clips to learn from, {} to judge by; step {}",
            learned.len(),
            judged.len(),
            trainer.steps_done()
        );
        let limit = self.hours.map(|h| Duration::from_secs_f64(3600.0 * h).saturating_sub(started.elapsed()));
        let ended = trainer.run(&learned, &judged, limit, &|| STOP.load(Ordering::Relaxed))?;
        match ended {
            Ended::Complete => {
                println!("complete; the weights are {}", self.output.join("weights.safetensors").display());
            }
            Ended::Stopped => println!("stopped at step {}; go on with --resume", trainer.steps_done()),
        }
        Ok(())
    }

    fn make(&self, set: &ClipSet, what: &str) -> Result<()> {
        let count = set.len();
        let mut said = Instant::now();
        let left_out = set.make(|made| {
            if said.elapsed().as_secs() > 20 {
                println!("clip {made} of {count} {what}");
                said = Instant::now();
            }
            !STOP.load(Ordering::Relaxed)
        })?;
        for volume in left_out {
            eprintln!("warning: nothing can be seen of {volume}; its clips are left out");
        }
        Ok(())
    }

    fn device(&self) -> Result<Device> {
        Ok(match self.device {
            Where::Cpu => Device::Cpu,
            Where::Auto => Device::cuda_if_available(),
            Where::Cuda if tch::Cuda::is_available() => Device::Cuda(0),
            Where::Cuda => bail!(
                "no CUDA device is to be seen; preload libtorch_cuda.so (see training/README.md) or use --device cpu"
            ),
        })
    }
}
