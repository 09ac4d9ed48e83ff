use crate::clips::{ClipSet, VolumeSource};
use crate::lesson::LessonConfig;
use crate::loss::LossConfig;
use crate::network::Spread;
use crate::optimise::RangerConfig;
use crate::{Error, Result};
use fovol_net::plan::{Named, NetworkConfig};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A network by name, or by its widths and parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum NetworkChoice {
    /// One of [`Named`].
    Name(String),
    /// Any.
    Config(NetworkConfig),
}

impl NetworkChoice {
    /// Its configuration; names have been checked.
    pub fn config(&self) -> NetworkConfig {
        match self {
            Self::Name(name) => name.parse().unwrap_or(Named::WNetFast).config(),
            Self::Config(config) => config.clone(),
        }
    }
}

/// The clips of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ClipsConfig {
    /// Where they are kept.
    pub folder: PathBuf,
    /// What they show: `NAME:SIDE:SEED` of procedural volumes, and files.
    pub volumes: Vec<String>,
    /// What those show that the network is judged by and never learns from.
    pub held_out: Vec<String>,
    /// How many to learn from.
    pub count: usize,
    /// How many to judge by.
    pub held_out_count: usize,
    /// Whether they are whole frames of 800² along fly-throughs, as in the paper, instead of parts of all manner of frames.
    #[serde(default)]
    pub fly_through: bool,
    /// What the seeds of both start at.
    #[serde(default)]
    pub seed: u64,
}

/// Seeds of clips to judge by are this far from those to learn from.
const HELD_OUT_SEEDS: u64 = 1 << 32;

impl ClipsConfig {
    /// The same as far as they have been made.
    ///
    /// # Errors
    /// Folders without clips.
    pub fn open(&self, base: &Path) -> Result<[ClipSet; 2]> {
        let folder = base.join(&self.folder);
        Ok([ClipSet::open(&folder.join("learn"))?, ClipSet::open(&folder.join("judge"))?])
    }

    /// The clips to learn from and to judge by. Paths are relative to `base`.
    ///
    /// # Errors
    /// Names that are no volumes, volumes that are in both.
    pub fn sets(&self, base: &Path) -> Result<[ClipSet; 2]> {
        let sources = |names: &[String]| -> Result<Vec<VolumeSource>> {
            let source = |name: &String| match VolumeSource::parse(name)? {
                VolumeSource::File(path) => Ok(VolumeSource::File(base.join(path))),
                other => Ok(other),
            };
            names.iter().map(source).collect()
        };
        let (learned, judged) = (sources(&self.volumes)?, sources(&self.held_out)?);
        if let Some(both) = learned.iter().find(|source| judged.contains(source)) {
            return Err(Error::Config(format!(
                "{both} is in `volumes` and in `held-out`; leave it in one of them"
            )));
        }
        let folder = base.join(&self.folder);
        let set = |name: &str, sources: &[VolumeSource], count, seed| {
            let folder = folder.join(name);
            match self.fly_through {
                true => ClipSet::fly_throughs(&folder, sources, count, seed),
                false => ClipSet::plan(&folder, sources, count, seed),
            }
        };
        Ok([
            set("learn", &learned, self.count, self.seed),
            set("judge", &judged, self.held_out_count, self.seed + HELD_OUT_SEEDS),
        ])
    }
}

/// A run of training; what is not given is as in the paper where the paper says it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TrainConfig {
    /// Which network.
    pub network: NetworkChoice,
    /// Weights to begin with; random ones if none are given.
    #[serde(default)]
    pub from: Option<PathBuf>,
    /// How far random weights may be from zero.
    #[serde(default)]
    pub spread: Spread,
    /// What everything random is drawn from.
    #[serde(default)]
    pub seed: u64,
    /// The clips.
    pub clips: ClipsConfig,
    /// Steps of the optimiser.
    pub steps: u64,
    /// Clips in a step.
    #[serde(default = "one")]
    pub batch: usize,
    /// Clips that are computed at once; gradients of the others are added to theirs. All of a step if not given.
    #[serde(default)]
    pub at_once: Option<usize>,
    /// Frames of a clip.
    #[serde(default = "sixteen")]
    pub frames: usize,
    /// Rows and columns of the part of a clip that is learned from; drawn anew each time where it is smaller than the clip.
    #[serde(default = "side")]
    pub side: usize,
    /// Gradients go back over this many frames.
    #[serde(default = "sixteen")]
    pub truncate: usize,
    /// Whether every frame is computed once more on the way back, instead of all that was computed kept: a third more
    /// time for a fraction of the memory.
    #[serde(default)]
    pub recompute: bool,
    /// The learning rate of the first step.
    #[serde(default = "rate")]
    pub rate: f64,
    /// That of the last step.
    #[serde(default = "last_rate")]
    pub last_rate: f64,
    /// The learning rate stays for so many steps.
    #[serde(default = "one_step")]
    pub steps_per_epoch: u64,
    /// Gradients are shortened to this length.
    #[serde(default = "unclipped")]
    pub clip_gradients: f64,
    /// How much of the average of weights stays in a step; 0 for no average.
    #[serde(default)]
    pub average: f64,
    /// Whether convolutions compute in bf16.
    #[serde(default)]
    pub bf16: bool,
    /// Whether tensors have their channels together in memory.
    #[serde(default)]
    pub channels_last: bool,
    /// Whether 3×3 convolutions round to bytes as int8 does, so that weights are learned that stand it.
    #[serde(default)]
    pub fake_quantised: bool,
    /// Whether the network is given the renderer's motion, if it uses any.
    #[serde(default = "yes")]
    pub use_motion: bool,
    /// Steps after which channels that have died are drawn anew, in the first half of all steps; 0 for never.
    #[serde(default)]
    pub revive_every: u64,
    /// Steps between judgements.
    #[serde(default = "thousand")]
    pub validate_every: u64,
    /// Minutes between checkpoints.
    #[serde(default = "five")]
    pub checkpoint_minutes: f64,
    /// How clips are varied and sampled.
    #[serde(default)]
    pub lesson: LessonConfig,
    /// What is minimised.
    #[serde(default)]
    pub loss: LossConfig,
    /// How.
    #[serde(default)]
    pub optimiser: RangerConfig,
}

fn one() -> usize {
    1
}
fn one_step() -> u64 {
    1
}
fn sixteen() -> usize {
    crate::clips::LENGTH
}
fn side() -> usize {
    crate::clips::SIDE
}
fn rate() -> f64 {
    1.25e-3
}
fn last_rate() -> f64 {
    1e-8
}
fn unclipped() -> f64 {
    f64::INFINITY
}
fn yes() -> bool {
    true
}
fn thousand() -> u64 {
    1000
}
fn five() -> f64 {
    5.0
}

impl TrainConfig {
    /// Reads a TOML file.
    ///
    /// # Errors
    /// A file that cannot be read or says what it should not; where, and how to mend it.
    pub fn read(path: &Path) -> Result<Self> {
        let text = fovol_core::input::read_to_string(path).map_err(|e| Error::file("read", path, &e))?;
        let config: Self =
            toml::from_str(&text).map_err(|e| Error::Config(format!("{}: {e}", path.display())))?;
        config.check()?;
        Ok(config)
    }

    /// Whether it can be run.
    ///
    /// # Errors
    /// What is wrong, in one line.
    pub fn check(&self) -> Result<()> {
        if let NetworkChoice::Name(name) = &self.network {
            name.parse::<Named>().map_err(Error::Config)?;
        }
        let positive = [
            ("steps", self.steps),
            ("batch", self.batch as u64),
            ("frames", self.frames as u64),
            ("side", self.side as u64),
            ("truncate", self.truncate as u64),
            ("steps-per-epoch", self.steps_per_epoch),
            ("validate-every", self.validate_every),
            ("at-once", self.at_once.map_or(1, |count| count as u64)),
        ];
        if let Some((name, _)) = positive.into_iter().find(|(_, value)| *value == 0) {
            return Err(Error::Config(format!("`{name}` is 0; give at least 1")));
        }
        let [low, high] = self.lesson.base;
        if !(low > 0.0 && low <= high && high <= 1.0) {
            return Err(Error::Config(format!(
                "`lesson.base` is {low} to {high}; give densities above 0 and up to 1"
            )));
        }
        Ok(())
    }

    /// Epochs of the learning rate.
    pub fn epochs(&self) -> u32 {
        u32::try_from(self.steps.div_ceil(self.steps_per_epoch)).unwrap_or(u32::MAX)
    }
}
