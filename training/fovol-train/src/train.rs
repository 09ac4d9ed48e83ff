use crate::fine_tune::FineTuning;
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use fovol_net::plan::Named;
use fovol_train::clips::{ClipSet, Exceptions};
use fovol_train::terminal::say;
use fovol_train::trainer::{Arrangement, Ended, TrainConfig, Trainer};
use fovolnet::{OpenDevice, signals};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tch::Device;

/// Trains a network: makes the clips of a configuration and trains on them, or fine-tunes trained weights on one's
/// own volumes.
#[derive(Args)]
pub struct Train {
    /// TOML file that says what to train, on what and how
    #[arg(value_name = "CONFIG.toml", required_unless_present = "volumes")]
    config: Option<PathBuf>,
    /// Train on this volume, or the volumes in this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["config", "resume", "clips_only", "clips_as_they_are"])]
    volumes: Option<PathBuf>,
    /// The weights to start from on one's own volumes
    #[arg(long, value_name = "NAME|FILE", default_value = "wnet-fast", requires = "volumes")]
    from: String,
    /// Folder for checkpoints, weights, log and pictures
    #[arg(short, long, value_name = "DIR", default_value = "trained")]
    output: PathBuf,
    /// Resume from the checkpoint in the output folder
    #[arg(long)]
    resume: bool,
    /// Stop, ready to be resumed, after this many hours; on one's own volumes finish by then [default there: 1]
    #[arg(long, value_name = "H")]
    hours: Option<f64>,
    /// Finish within --hours, however many steps that is: the learning rate falls with the clock
    #[arg(long, requires = "hours", conflicts_with = "resume")]
    by_the_clock: bool,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Where::Auto)]
    device: Where,
    /// Most CPU threads to use; how they share a step is tried at the beginning, and kept when resumed [default: all]
    #[arg(long, value_name = "N")]
    threads: Option<NonZero<usize>>,
    /// Train on the clips that are there, without making those that are missing
    #[arg(long, conflicts_with = "clips_only")]
    clips_as_they_are: bool,
    /// Where clips are rendered: auto, cpu, gpu, or gpu:NAME
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    clips_on: fovolnet::Device,
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

/// Fraction of the fine-tuning time spent on making clips.
const CLIPS_SHARE: f64 = 0.3;
/// Fewest clips for fine-tuning, even if time runs out.
const FEWEST: usize = 8;
/// Largest batch of fine-tuning; it is otherwise the number of CPU threads.
const MOST_CLIPS: usize = 8;

/// Set by Ctrl-C and its like.
static STOP: AtomicBool = AtomicBool::new(false);

impl Train {
    pub fn run(&self) -> Result<()> {
        signals::listen_patiently(|| STOP.store(true, Ordering::Relaxed));
        match (&self.config, &self.volumes) {
            (_, Some(volumes)) => self.fine_tune(volumes),
            (Some(config), None) => self.follow(config),
            (None, None) => bail!("nothing to train on; give a configuration, or --volumes DIR"),
        }
    }

    /// Trains as a configuration file says.
    fn follow(&self, path: &Path) -> Result<()> {
        let started = Instant::now();
        let mut config = TrainConfig::read(path)?;
        // Paths in the file are relative to it.
        let base = path.parent().unwrap_or(Path::new("."));
        let is_name = |path: &Path| path.to_str().is_some_and(|name| name.parse::<Named>().is_ok());
        config.from = config.from.map(|path| if is_name(&path) { path } else { base.join(path) });
        let sets = config.clips.sets(base)?;
        let device = self.clips_on.open()?;
        let missing = sets.iter().zip(["to learn from", "to judge by"]).rev();
        for (set, what) in missing.filter(|_| !self.clips_as_they_are) {
            make((set, &device), what, None)?;
        }
        if self.clips_only || STOP.load(Ordering::Relaxed) {
            return Ok(());
        }
        let [learned, judged] = config.clips.open(base)?;
        let mut trainer = Trainer::new(config, &self.output, self.device()?, self.resume)?;
        let left = self.hours.map(|h| Duration::from_secs_f64(3600.0 * h).saturating_sub(started.elapsed()));
        match left {
            Some(left) if self.by_the_clock => {
                trainer.pace(left);
                self.train(trainer, [&learned, &judged], None)
            }
            limit => self.train(trainer, [&learned, &judged], limit),
        }
    }

    /// Fine-tunes trained weights within the given time, part of which is spent on clips.
    fn fine_tune(&self, volumes: &Path) -> Result<()> {
        let started = Instant::now();
        let time = Duration::from_secs_f64(3600.0 * self.hours.unwrap_or(1.0));
        let FineTuning { mut config, learned, judged } =
            FineTuning::new(volumes, &self.from, &self.output.join("clips"))?;
        // One clip per thread: they run side by side, and a larger batch gives steadier steps in equal time.
        config.batch = self.processors().min(MOST_CLIPS);
        let device = self.clips_on.open()?;
        make((&judged, &device), "to judge by", None)?;
        make((&learned, &device), "to learn from", Some(started + time.mul_f64(CLIPS_SHARE)))?;
        if STOP.load(Ordering::Relaxed) {
            return Ok(());
        }
        let (learned, judged) = (learned.made(), judged.made());
        let mut trainer = Trainer::new(config, &self.output, self.device()?, false)?;
        trainer.pace(time.saturating_sub(started.elapsed()));
        self.train(trainer, [&learned, &judged], None)
    }

    fn train(
        &self,
        mut trainer: Trainer,
        [learned, judged]: [&ClipSet; 2],
        limit: Option<Duration>,
    ) -> Result<()> {
        say(format_args!(
            "{} clips to learn from, {} to judge by; step {}",
            learned.len(),
            judged.len(),
            trainer.steps_done()
        ));
        if let Some(Arrangement { side_by_side, threads }) = trainer.arrange(learned, self.processors())? {
            say(format_args!(
                "{} processors: parts of a step side by side {side_by_side}, threads of each {threads}",
                self.processors()
            ));
        }
        match trainer.run(learned, judged, limit, &|| STOP.load(Ordering::Relaxed))? {
            Ended::Complete => {
                say(format_args!(
                    "complete; the weights are {}",
                    self.output.join("weights.safetensors").display()
                ));
            }
            Ended::Stopped if self.volumes.is_some() => {
                say(format_args!(
                    "stopped; the weights so far are {}",
                    self.output.join("weights.safetensors").display()
                ));
            }
            Ended::Stopped => {
                say(format_args!("stopped at step {}; go on with --resume", trainer.steps_done()));
            }
        }
        Ok(())
    }

    /// Number of CPU threads that may be used.
    fn processors(&self) -> usize {
        let all = || std::thread::available_parallelism().map_or(1, NonZero::get);
        self.threads.map_or_else(all, NonZero::get)
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

/// Makes the clips of `set`, or as many as there is time for until `end`, but at least [`FEWEST`].
fn make((set, device): (&ClipSet, &OpenDevice), what: &str, end: Option<Instant>) -> Result<()> {
    let count = set.len();
    let mut said = Instant::now();
    let Exceptions { left_out, on_processor } = set.make(device, |made| {
        if said.elapsed().as_secs() > 20 {
            say(format_args!("clip {made} of {count} {what}"));
            said = Instant::now();
        }
        let is_late = made >= FEWEST && end.is_some_and(|end| Instant::now() >= end);
        !is_late && !STOP.load(Ordering::Relaxed)
    })?;
    for volume in left_out {
        eprintln!("warning: nothing can be seen of {volume}; its clips are left out");
    }
    if let Some(why) = on_processor {
        eprintln!("note: some clips were rendered on the processor: {why}");
    }
    Ok(())
}
