//! What figures compare: two ways to fill frames without a network, and the network.

use super::{DataSet, Evaluation};
use anyhow::Result;
use fovolnet::core::Frame;
use fovolnet::net::Fill;
use fovolnet::{OpenVolume, Pipeline, Reconstruction, RenderSettings, RenderedFrame};

/// What the report calls them.
pub const METHODS: [&str; 3] = ["pull-push", "linear", "wnet-fast"];

/// The frame of each of [`METHODS`], of one that was made with the network.
pub fn frames(rendered: RenderedFrame) -> [Frame; 3] {
    let sparse = &rendered.sparse;
    [Fill::PullPush.reconstruct(sparse), Fill::Linear.reconstruct(sparse), rendered.frame]
}

/// Settings of a fly-through of `data` with the network, sampled with (P_b, σ).
pub fn with_network(evaluation: &Evaluation, data: &DataSet, sampling: [f64; 2]) -> RenderSettings {
    RenderSettings { reconstruct: Some(Reconstruction::WNet), ..evaluation.settings(data, sampling) }
}

/// A pipeline that has made one frame: memory is taken and filled for the first time then.
pub fn warmed(opened: &OpenVolume, settings: &RenderSettings, evaluation: &Evaluation) -> Result<Pipeline> {
    let mut pipeline = Pipeline::new(opened, settings, &evaluation.speed)?;
    pipeline.render(0)?;
    pipeline.reset();
    Ok(pipeline)
}
