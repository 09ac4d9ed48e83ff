//! Makes the kernels of the layers of a plan.

mod filter;
mod norm;
mod pointwise;
mod reshape;

use super::conv;
use super::fill::{pyramid, spread};
use super::history::{accumulate, points, warp};
use super::kernel::{Context, Kernel};
use crate::Result;
use crate::plan::Layer;

/// Makes the kernels of `layer`, in order; none if its output is never written.
///
/// # Errors
/// Weights that are missing, and layers with more input tensors than shaders can bind.
pub fn kernels(context: &Context<'_>, layer: &Layer) -> Result<Vec<Kernel>> {
    let output = layer.output();
    if context.moved(output).is_some() || Some(output) == context.schedule.known {
        return Ok(Vec::new());
    }
    Ok(match layer {
        Layer::Conv(layer) => vec![conv::kernel(context, layer)?],
        Layer::Norm(layer) => norm::kernels(context, layer)?,
        Layer::Filter(layer) => vec![filter::kernel(context, layer)?],
        Layer::Pool(layer) => vec![reshape::pool(context, layer)],
        Layer::SpaceToDepth(layer) => vec![reshape::space_to_depth(context, layer)],
        Layer::DepthToSpace(layer) => vec![reshape::depth_to_space(context, layer)],
        Layer::Scale(layer) => vec![pointwise::scale(context, layer)],
        Layer::Clamp(layer) => vec![pointwise::clamp(context, layer)],
        Layer::Join(layer) => vec![reshape::join(context, layer)],
        Layer::Spread(layer) => pyramid::spread(context, layer),
        Layer::Smooth(layer) => vec![spread::smooth(context, layer)],
        Layer::Blend(layer) => vec![spread::blend(context, layer)],
        Layer::HistoryConfidence(layer) => pyramid::history_confidence(context, layer),
        Layer::Accumulate(layer) => vec![accumulate::kernel(context, layer)],
        Layer::Part(layer) => vec![reshape::part(context, layer)],
        Layer::Add(layer) => vec![pointwise::add(context, layer)],
        Layer::Bypass(layer) => vec![pointwise::bypass(context, layer)],
        Layer::Reproject(layer) => vec![points::reproject(context, layer)],
        Layer::Splat(layer) => vec![points::splat(context, layer)],
        Layer::Warp(layer) => vec![warp::kernel(context, layer)],
    })
}
