//! Writes a network with random weights of a seed as an ONNX file: `export_onnx NETWORK SEED OUT.onnx`.
//!
//! NETWORK is a name, such as `wnet-fast`, or a configuration in JSON.

use fovol_net::plan::{Named, NetworkConfig};
use fovol_net::{Weights, onnx};
use std::error::Error;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [network, seed, out] = arguments.as_slice() else {
        return Err("usage: export_onnx NETWORK SEED OUT.onnx".into());
    };
    let config: NetworkConfig = if network.starts_with('{') {
        serde_json::from_str(network)?
    } else {
        network.parse::<Named>()?.config()
    };
    let weights = Weights::random(&config, seed.parse()?)?;
    let facts: Vec<(&str, String)> =
        weights.facts.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    fs::write(out, onnx::export(&config.plan()?, &weights, &facts)?)?;
    Ok(())
}
