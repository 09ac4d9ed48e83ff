use crate::clips::{ClipSet, VolumeSource};
use crate::lesson::LessonConfig;
use crate::loss::LossConfig;
use crate::network::Spread;
use crate::optimise::RangerConfig;
use crate::{Error, Result};
use fovol_net::plan::{Named, NetworkConfig};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// Network to train: a name or a configuration.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum NetworkChoice {
    /// Name of a [`Named`] network.
    Name(String),
    /// Any configuration.
    Config(NetworkConfig),
}

impl NetworkChoice {
    /// Configuration of the network. Names have been checked when the file was read.
    pub fn config(&self) -> NetworkConfig {
        match self {
            Self::Name(name) => name.parse().unwrap_or(Named::WNetFast).config(),
            Self::Config(config) => config.clone(),
        }
    }
}

/// Not derived, so that the error for a configuration says what is wrong with it.
impl<'de> Deserialize<'de> for NetworkChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(ChoiceVisitor)
    }
}

/// Reads a text as a name, and a table as a configuration.
struct ChoiceVisitor;

impl<'de> Visitor<'de> for ChoiceVisitor {
    type Value = NetworkChoice;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a network, or its configuration")
    }

    fn visit_str<E>(self, name: &str) -> std::result::Result<NetworkChoice, E> {
        Ok(NetworkChoice::Name(name.to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<NetworkChoice, A::Error> {
        NetworkConfig::deserialize(MapAccessDeserializer::new(map)).map(NetworkChoice::Config)
    }
}

/// Training and validation clips of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ClipsConfig {
    /// Folder of the clips.
    pub folder: PathBuf,
    /// Volumes of the training clips: `NAME:SIDE:SEED` for procedural volumes, else paths.
    pub volumes: Vec<String>,
    /// Volumes of the validation clips, which are never trained on.
    pub held_out: Vec<String>,
    /// Number of training clips.
    pub count: usize,
    /// Number of validation clips.
    pub held_out_count: usize,
    /// Whether clips are full frames of 800² pixels along fly-throughs, as in the paper, instead of random crops of
    /// various frame sizes.
    #[serde(default)]
    pub fly_through: bool,
    /// First seed.
    #[serde(default)]
    pub seed: u64,
}

/// Seed distance between validation and training clips.
const HELD_OUT_SEEDS: u64 = 1 << 32;

impl ClipsConfig {
    /// Opens the training and validation clips that have been made.
    ///
    /// # Errors
    /// Folders without clips.
    pub fn open(&self, base: &Path) -> Result<[ClipSet; 2]> {
        let folder = base.join(&self.folder);
        Ok([ClipSet::open(&folder.join("learn"))?, ClipSet::open(&folder.join("judge"))?])
    }

    /// Plans the training and validation clips. Paths are relative to `base`.
    ///
    /// # Errors
    /// Names that are no volumes, or volumes in both sets.
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

/// Configuration of a training run. Missing fields take the paper's values where the paper gives them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TrainConfig {
    /// Network to train.
    pub network: NetworkChoice,
    /// Initial weights; random if not given.
    #[serde(default)]
    pub from: Option<PathBuf>,
    /// Initial range of random weights.
    #[serde(default)]
    pub spread: Spread,
    /// Seed of all random choices.
    #[serde(default)]
    pub seed: u64,
    /// Training and validation clips.
    pub clips: ClipsConfig,
    /// Steps of the optimiser.
    pub steps: u64,
    /// Clips in a step.
    #[serde(default = "one")]
    pub batch: usize,
    /// Clips computed at once; the step accumulates gradients over its clips. All of a step if not given.
    #[serde(default)]
    pub at_once: Option<usize>,
    /// Frames of a clip.
    #[serde(default = "sixteen")]
    pub frames: usize,
    /// Side of the square crop of a clip to train on, in pixels; drawn anew each time if smaller than the clip.
    #[serde(default = "side")]
    pub side: usize,
    /// Frames over which gradients are backpropagated.
    #[serde(default = "sixteen")]
    pub truncate: usize,
    /// Whether the backward pass recomputes every frame (checkpointing) instead of keeping activations: a third more
    /// time for a fraction of the memory.
    #[serde(default)]
    pub recompute: bool,
    /// Learning rate of the first step.
    #[serde(default = "rate")]
    pub rate: f64,
    /// Learning rate of the last step.
    #[serde(default = "last_rate")]
    pub last_rate: f64,
    /// Steps between changes of the learning rate.
    #[serde(default = "one_step")]
    pub steps_per_epoch: u64,
    /// Largest norm of the gradients; longer ones are scaled down.
    #[serde(default = "unclipped")]
    pub clip_gradients: f64,
    /// Decay of the moving average of weights; 0 for no average.
    #[serde(default)]
    pub average: f64,
    /// Whether 3×3 convolutions compute in bf16.
    #[serde(default)]
    pub bf16: bool,
    /// Whether convolutions use channels-last memory layout.
    #[serde(default)]
    pub channels_last: bool,
    /// Whether 3×3 convolutions round to int8 values in training, so that weights tolerate int8 inference.
    #[serde(default)]
    pub fake_quantised: bool,
    /// Whether networks with a motion input receive the renderer's motion.
    #[serde(default = "yes")]
    pub use_motion: bool,
    /// Steps between resets of dead channels, in the first half of all steps; 0 for never.
    #[serde(default)]
    pub revive_every: u64,
    /// Steps between validations.
    #[serde(default = "thousand")]
    pub validate_every: u64,
    /// Minutes between checkpoints.
    #[serde(default = "five")]
    pub checkpoint_minutes: f64,
    /// Augmentation and sampling of clips.
    #[serde(default)]
    pub lesson: LessonConfig,
    /// Loss to minimise.
    #[serde(default)]
    pub loss: LossConfig,
    /// Settings of the optimiser.
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
    /// Reads and checks a TOML file.
    ///
    /// # Errors
    /// The file cannot be read or has invalid content. The message says where and how to mend it.
    pub fn read(path: &Path) -> Result<Self> {
        let text = fovol_core::input::read_to_string(path).map_err(|e| Error::file("read", path, &e))?;
        let config: Self =
            toml::from_str(&text).map_err(|e| Error::Config(format!("{}: {e}", path.display())))?;
        config.check()?;
        Ok(config)
    }

    /// Checks that the configuration can be run.
    ///
    /// # Errors
    /// One line that says what is wrong.
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

    /// Number of epochs of the learning rate.
    pub fn epochs(&self) -> u32 {
        u32::try_from(self.steps.div_ceil(self.steps_per_epoch)).unwrap_or(u32::MAX)
    }
}
