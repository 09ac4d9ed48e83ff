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

/// Makes the kernels of layer `number` of the plan, and of the layers after it that they compute too. Returns the number of layers.
///
/// # Errors
/// Weights that are missing, and layers with more input tensors than shaders can bind.
pub fn kernels(context: &Context<'_>, number: usize) -> Result<(Vec<Kernel>, usize)> {
    let layers = context.plan.layers();
    if let Some((kernel, count)) = pointwise::changes(context, number) {
        return Ok((vec![kernel], count));
    }
    if let (true, [Layer::Reproject(moved), Layer::Accumulate(layer), ..]) =
        (context.schedule.fades[number], &layers[number..])
    {
        return Ok((vec![accumulate::moved(context, moved, layer)], 2));
    }
    Ok((of_layer(context, &layers[number])?, 1))
}

/// Makes the kernels of `layer` alone, in order; none if its output is never written.
fn of_layer(context: &Context<'_>, layer: &Layer) -> Result<Vec<Kernel>> {
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
        Layer::Join(layer) => vec![reshape::join(context, layer)],
        Layer::Spread(layer) => pyramid::spread(context, layer),
        Layer::Smooth(layer) => vec![spread::smooth(context, layer)],
        Layer::Blend(layer) => vec![spread::blend(context, layer)],
        Layer::HistoryConfidence(layer) => pyramid::history_confidence(context, layer),
        Layer::Accumulate(layer) => vec![accumulate::kernel(context, layer)],
        Layer::Part(layer) => vec![reshape::part(context, layer)],
        Layer::Reproject(layer) => vec![points::reproject(context, layer)],
        Layer::Splat(layer) => vec![points::splat(context, layer)],
        Layer::Warp(layer) => vec![warp::kernel(context, layer)],
        Layer::Clamp(_) | Layer::Add(_) | Layer::Bypass(_) => unreachable!("`pointwise::changes` makes them"),
    })
}
