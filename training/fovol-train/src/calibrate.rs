use anyhow::Result;
use clap::Args;
use fovol_net::Weights;
use fovol_net::weights::Storage;
use fovol_train::terminal::say;
use fovol_train::trainer::{TrainConfig, note_ranges};
use fovolnet::io::atomic;
use std::path::{Path, PathBuf};

/// Records the ranges of a network's activations on the clips of a configuration.
#[derive(Args)]
pub struct Calibrate {
    /// The configuration whose clips are used; they must have been made
    #[arg(value_name = "CONFIG.toml")]
    config: PathBuf,
    /// The weights: .safetensors, or .pt of a named network
    weights: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE.safetensors")]
    output: PathBuf,
    /// Store two bytes a number (f16) instead of four
    #[arg(long)]
    half: bool,
}

impl Calibrate {
    pub fn run(&self) -> Result<()> {
        let config = TrainConfig::read(&self.config)?;
        let base = self.config.parent().unwrap_or(Path::new("."));
        let [learned, _] = config.clips.open(base)?;
        let mut weights = Weights::read(&self.weights)?;
        atomic::refuse_input(&self.output)?;
        note_ranges(&mut weights, &learned, &config)?;
        let bytes = weights.to_bytes(if self.half { Storage::F16 } else { Storage::F32 })?;
        atomic::write_bytes(&self.output, &bytes)?;
        say(format_args!("{} ranges in {}", weights.ranges.len(), self.output.display()));
        Ok(())
    }
}
