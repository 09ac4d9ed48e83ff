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
        Layer::Filter(layer) => vec![filter::kernel(context, layer)?],
        Layer::Norm(layer) => norm::kernels(context, layer)?,
        Layer::Pool { .. }
        | Layer::SpaceToDepth { .. }
        | Layer::DepthToSpace { .. }
        | Layer::Join { .. }
        | Layer::Part { .. } => reshape::kernel(context, layer).into_iter().collect(),
        Layer::Scale { .. } | Layer::Clamp { .. } | Layer::Add { .. } | Layer::Bypass { .. } => {
            pointwise::kernel(context, layer).into_iter().collect()
        }
        Layer::Spread { known, base, levels, .. } => pyramid::spread(context, *known, *base, *levels, output),
        Layer::Doubt { known, prior, fresh, levels, .. } => {
            pyramid::doubt(context, *known, [*prior, *fresh], *levels, output)
        }
        Layer::Smooth { input, .. } => vec![spread::smooth(context, *input, output)],
        Layer::Blend { known, base, .. } => vec![spread::blend(context, *known, *base, output)],
        Layer::Accumulate { known, before, share, fade, .. } => {
            vec![accumulate::kernel(context, *known, (*before, *share), *fade, output)]
        }
        Layer::Reproject { input, motion, .. } => vec![points::reproject(context, *input, *motion, output)],
        Layer::Splat { input, .. } => vec![points::splat(context, *input, output)],
        Layer::Warp { input, motion, .. } => vec![warp::kernel(context, *input, *motion, output)],
    })
}
