//! Fine-tuning of trained weights on a user's own volumes.

use anyhow::{Result, bail};
use fovol_net::Weights;
use fovol_train::clips::{ClipSet, VolumeSource};
use fovol_train::trainer::{ClipsConfig, NetworkChoice, TrainConfig};
use std::path::{Path, PathBuf};

/// Number of training clips; fewer where time runs out.
const CLIPS: usize = 200;
/// Number of validation clips.
const JUDGED: usize = 6;
/// Seed distance between training and validation clips, so that they never coincide.
const JUDGED_SEEDS: u64 = 1 << 32;

/// Fine-tuning run: configuration and clips.
pub struct FineTuning {
    /// Training configuration.
    pub config: TrainConfig,
    /// Training clips.
    pub learned: ClipSet,
    /// Validation clips of the same volumes.
    pub judged: ClipSet,
}

impl FineTuning {
    /// Prepares a run that continues from the weights `from` (a file, or the name of shipped weights). It uses the
    /// volume or folder of volumes `volumes`, and keeps clips in `folder`.
    pub fn new(volumes: &Path, from: &str, folder: &Path) -> Result<Self> {
        let weights = Weights::named_or_read(from)?;
        let sources = sources(volumes)?;
        let set = |name: &str, count, seed| ClipSet::plan(&folder.join(name), &sources, count, seed);
        let clips = ClipsConfig {
            folder: folder.to_owned(),
            volumes: sources.iter().map(ToString::to_string).collect(),
            held_out: Vec::new(),
            count: CLIPS,
            held_out_count: JUDGED,
            fly_through: false,
            seed: 0,
        };
        let mut config: TrainConfig = toml::from_str(RECIPE)?;
        config.network = NetworkChoice::Config(weights.config);
        config.from = Some(from.into());
        config.clips = clips;
        Ok(Self { config, learned: set("learn", CLIPS, 0), judged: set("judge", JUDGED, JUDGED_SEEDS) })
    }
}

/// Default configuration for a short run on a CPU. Its network and clips are examples that [`FineTuning::new`]
/// replaces.
const RECIPE: &str = include_str!("../../configs/fine-tune.toml");

/// The volume at `path`, or all volumes in that folder.
fn sources(path: &Path) -> Result<Vec<VolumeSource>> {
    if !path.is_dir() {
        return Ok(vec![VolumeSource::parse(&path.to_string_lossy())?]);
    }
    let mut found: Vec<PathBuf> =
        std::fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    found.retain(|path| !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.')));
    found.sort();
    let (mut sources, mut skipped) = (Vec::new(), Vec::new());
    for path in found {
        let source = VolumeSource::File(path.clone());
        match source.open() {
            Ok(_) => sources.push(source),
            Err(_) => skipped.push(path),
        }
    }
    if sources.is_empty() {
        bail!(
            "{}: none of its files is a volume that can be read; give a folder of volumes, or one",
            path.display()
        );
    }
    for path in skipped {
        eprintln!("warning: {} is no volume that can be read; it is left out", path.display());
    }
    Ok(sources)
}
