use crate::{console, outputs};
use anyhow::{Result, anyhow};
use fovolnet::io::atomic;
use fovolnet::net::{Weights, onnx};
use fovolnet::{RandomWeights, parse};
use std::path::PathBuf;

/// Write a network for other programs
#[derive(clap::Args)]
pub struct Export {
    /// File to write: ONNX, opset 17, any height and width; see `fovol_net::onnx` for its inputs and outputs
    #[arg(long, value_name = "OUT.onnx")]
    onnx: PathBuf,
    /// Weights of the network: wnet-fast, a safetensors file, or a state dict of PyTorch (.pt) of a network with a name
    #[arg(long, value_name = "NAME|FILE", value_parser = parse::file(), conflicts_with = "random_weights")]
    weights: Option<String>,
    /// Seeded random weights of a network
    #[arg(long, value_name = "NAME[:SEED]")]
    random_weights: Option<RandomWeights>,
}

impl Export {
    pub fn run(self) -> Result<()> {
        let weights = match (&self.weights, self.random_weights) {
            (Some(name), _) => Weights::named_or_read(name)?,
            (None, Some(random)) => Weights::random(&random.network.config(), random.seed)?,
            (None, None) => return Err(anyhow!("nothing to export; give --weights or --random-weights")),
        };
        outputs::check([&*self.onnx])?;
        let plan = weights.config.plan().map_err(|problem| anyhow!(problem))?;
        let facts: Vec<(&str, String)> =
            weights.facts.iter().map(|(key, value)| (key.as_str(), value.clone())).collect();
        let bytes = onnx::export(&plan, &weights, &facts)?;
        atomic::write_bytes(&self.onnx, &bytes)?;
        console::say(format!(
            "{}: {} layers, {:.1} MB; height and width are multiples of {}",
            self.onnx.display(),
            plan.layers().len(),
            bytes.len() as f64 / 1e6,
            plan.multiple()
        ))
    }
}
