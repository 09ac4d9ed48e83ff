//! The layers of a [`fovol_net::plan::Plan`] as differentiable functions of tensors.
//!
//! Each function computes in the kind of its inputs.

use fovol_net::plan::{
    Activation, CONFIDENCE_ALLOWED, CONFIDENCE_EPSILON, CONFIDENCE_SHARE, Conv, Normalisation, Padding,
    Resize, SQUARED_EPSILON, Taps,
};
use tch::kind::Element;
use tch::{Device, Kind, Tensor};

/// Lower bound of the weights that [`pull_push`] divides by.
const SMALLEST: f64 = 1e-8;
/// Keeps the variance of [`norm`] above zero.
const NORM_EPSILON: f64 = 1e-5;
/// Motion in pixels that points outside any frame.
const FAR: f64 = 1e9;

/// Size of `tensor`: batch, channels, rows, columns.
pub(super) fn shape(tensor: &Tensor) -> [i64; 4] {
    let size = tensor.size();
    std::array::from_fn(|i| size[i])
}

/// Converts `tensor` to channels-last memory layout.
pub(super) fn channels_last(tensor: &Tensor) -> Tensor {
    tensor.permute([0, 2, 3, 1]).contiguous().permute([0, 3, 1, 2])
}

/// Upsamples `tensor` as `change` says.
pub(super) fn resized(tensor: &Tensor, change: Resize) -> Tensor {
    let [_, _, height, width] = shape(tensor);
    let doubled = [2 * height, 2 * width];
    match change {
        Resize::Same => tensor.shallow_clone(),
        Resize::Bilinear => tensor.upsample_bilinear2d(doubled, false, 2.0, 2.0),
        Resize::Nearest => tensor.upsample_nearest2d(doubled, 2.0, 2.0),
    }
}

/// Applies `activation` to `tensor`.
fn activated(tensor: &Tensor, activation: Activation) -> Tensor {
    match activation {
        Activation::None => tensor.shallow_clone(),
        Activation::Relu => tensor.relu(),
        Activation::Elu => tensor.elu(),
    }
}

/// Applies the convolution `layer`, with its activation, to its concatenated `input`.
pub(super) fn conv(layer: &Conv, input: &Tensor, weight: &Tensor, bias: &Tensor) -> Tensor {
    let reach = (layer.size / 2) as i64;
    let stride = layer.stride as i64;
    let convolved = match layer.padding {
        Padding::Replicate if reach > 0 => {
            let input = input.replication_pad2d([reach; 4]);
            input.conv2d(weight, Some(bias), [stride; 2], [0; 2], [1; 2], 1)
        }
        _ => input.conv2d(weight, Some(bias), [stride; 2], [reach; 2], [1; 2], 1),
    };
    activated(&convolved, layer.activation)
}

/// Normalises over all values of each frame, then applies a per-channel affine map and `activation`.
pub(super) fn norm(input: &Tensor, weight: &Tensor, bias: &Tensor, activation: Activation) -> Tensor {
    activated(&input.group_norm(1, Some(weight), Some(bias), NORM_EPSILON, true), activation)
}

/// Filters `images` with unnormalised `kernels` \[batch, expand²·taps, rows, columns\].
pub(super) fn filter(
    kernels: &Tensor,
    expand: usize,
    images: &[(Tensor, Taps)],
    normalisation: Normalisation,
) -> Tensor {
    let weights = if expand == 1 { kernels.shallow_clone() } else { kernels.pixel_shuffle(expand as i64) };
    match normalisation {
        // Dividing the sum instead of each weight divides three channels instead of nine or more taps.
        Normalisation::Squared => {
            let weights = weights.square() + f64::from(SQUARED_EPSILON);
            weighted_sum(&weights, images) / weights.sum_dim_intlist([1i64].as_slice(), true, None)
        }
        Normalisation::Softmax => weighted_sum(&weights.softmax(1, None), images),
    }
}

/// Sum over all taps of `images`, weighted by `weights` \[batch, taps, rows, columns\] that all channels share.
fn weighted_sum(weights: &Tensor, images: &[(Tensor, Taps)]) -> Tensor {
    let counts: Vec<i64> = images.iter().map(|(_, taps)| taps.count() as i64).collect();
    let weights = weights.split_with_sizes(counts, 1);
    let parts = images.iter().zip(&weights).map(|((image, taps), weights)| match (taps, image.device()) {
        (Taps::Centre, _) => weights * image,
        (Taps::Around, Device::Cpu) => filtered_by_views(weights, image),
        (Taps::Around, _) => filtered_unfolded(weights, image),
    });
    parts.reduce(|sum, part| sum + part).unwrap_or_default()
}

/// Filters `image` with 3×3 kernels `weights` (row by row, zero padding) as a sum of shifted views. On CPUs this is
/// the faster way, and autograd keeps nine images less.
fn filtered_by_views(weights: &Tensor, image: &Tensor) -> Tensor {
    let [_, _, height, width] = shape(image);
    let padded = image.constant_pad_nd([1; 4]);
    let rows = [0, 1, 2].map(|y| padded.narrow(2, y, height));
    let views = rows.iter().flat_map(|row| [0, 1, 2].map(|x| row.narrow(3, x, width)));
    let products = weights.split(1, 1).into_iter().zip(views).map(|(weight, view)| weight * view);
    let sum = |mut sum: Tensor, product| {
        sum += product;
        sum
    };
    products.reduce(sum).unwrap_or_default()
}

/// Filters `image` with 3×3 kernels `weights` (row by row, zero padding) as one product and one sum. This needs a
/// tenth of the calls, whose overhead dominates on GPUs.
fn filtered_unfolded(weights: &Tensor, image: &Tensor) -> Tensor {
    let [batch, channels, height, width] = shape(image);
    let around = image.im2col([3; 2], [1; 2], [1; 2], [1; 2]).view([batch, channels, 9, height, width]);
    (weights.unsqueeze(1) * around).sum_dim_intlist([2i64].as_slice(), false, None)
}

/// Averages blocks of `factor` × `factor` pixels.
pub(super) fn pool(input: &Tensor, factor: i64) -> Tensor {
    input.avg_pool2d([factor; 2], [factor; 2], [0; 2], false, true, None)
}

/// mask · colour + (1 − mask) · input.
pub(super) fn bypass(colour: &Tensor, mask: &Tensor, input: &Tensor) -> Tensor {
    mask * colour + (1.0 - mask) * input
}

/// Samples `input` at the previous position of each pixel: bilinear, zero outside the frame and where the motion is
/// NaN.
///
/// `motion` is in pixels of the full frame. For an `input` at 1/f of that resolution it is averaged over f × f pixels
/// and divided by f.
pub(crate) fn warp(input: &Tensor, motion: &Tensor) -> Tensor {
    let [_, _, height, width] = shape(input);
    let factor = shape(motion)[3] / width;
    let motion = motion.nan_to_num(FAR, FAR, -FAR);
    let motion = if factor > 1 { pool(&motion, factor) / factor as f64 } else { motion };
    // `grid_sampler` counts from −1 at the left edge of the first pixel to 1 at the right edge of the last.
    let along = |axis: i64, count: i64, shape: [i64; 3]| {
        let centres = Tensor::arange(count, (motion.kind(), motion.device())).view(shape);
        ((motion.select(1, axis) + centres) * 2.0 + 1.0) / count as f64 - 1.0
    };
    let grid = Tensor::stack(&[along(0, width, [1, 1, width]), along(1, height, [1, height, 1])], 3);
    let (bilinear, zeros) = (0, 0);
    input.grid_sampler(&grid, bilinear, zeros, false)
}

// Layers that fill frames. Their formulas are those of `tests/reference/network/networks.py`.

/// Splits `known` into colour times weight (three channels) and the weight.
fn parts(known: &Tensor) -> [Tensor; 2] {
    [known.narrow(1, 0, 3), known.narrow(1, 3, 1)]
}

/// Weighted difference between `known` and `picture`.
fn difference(known: &Tensor, picture: &Tensor) -> Tensor {
    let [colour, weight] = parts(known);
    colour - weight * picture
}

/// Spreads `known` over the frame at half the resolution by pull-push. With `base`, spreads the residuals to it and
/// adds them.
pub(super) fn spread(known: &Tensor, base: Option<&Tensor>, levels: u32) -> Tensor {
    match base {
        None => pull_push(known, levels, 1),
        Some(base) => {
            let beside =
                Tensor::cat(&[difference(known, &resized(base, Resize::Bilinear)), known.narrow(1, 3, 1)], 1);
            base + pull_push(&beside, levels, 1)
        }
    }
}

/// Fills pixels of `known` with the upsampled `base` where their weight is below 1: c + (1 − w)·b.
pub(super) fn blend(known: &Tensor, base: &Tensor) -> Tensor {
    let [colour, weight] = parts(known);
    colour + (1.0 - weight) * resized(base, Resize::Bilinear)
}

/// History confidence v / (v + share · max(e − allowed · v, 0)). Here e and v are mean squared differences between
/// samples and `prior` or upsampled `fresh`; ε is added to v.
pub(super) fn history_confidence(
    known: &Tensor,
    [prior, fresh]: [&Tensor; 2],
    [levels, lowest]: [u32; 2],
) -> Tensor {
    let mask = known.narrow(1, 3, 1);
    let [error, own] = [prior, &resized(fresh, Resize::Bilinear)]
        .map(|expected| difference(known, expected).square().mean_dim([1i64].as_slice(), true, None::<Kind>));
    let squares = Tensor::cat(&[error, own, mask.zeros_like(), mask], 1);
    let squares = pull_push(&squares, levels, lowest);
    let own = squares.narrow(1, 1, 1) + f64::from(CONFIDENCE_EPSILON);
    let more = (squares.narrow(1, 0, 1) - &own * f64::from(CONFIDENCE_ALLOWED)).relu();
    &own / (&own + more * f64::from(CONFIDENCE_SHARE))
}

/// Adds `before`, times `fade` and `share`, to `known` where its weight is below 1. Channels beyond the fourth, the
/// places of points, are not scaled by `fade` and `share`.
pub(super) fn accumulate(known: &Tensor, before: &Tensor, share: Option<&Tensor>, fade: f32) -> Tensor {
    let open: Tensor = 1.0 - known.narrow(1, 3, 1);
    let [_, _, height, width] = shape(known);
    let share = match share {
        None => open.ones_like(),
        Some(share) => {
            let scale = (height / shape(share)[2]) as f64;
            share.upsample_bilinear2d([height, width], false, scale, scale)
        }
    };
    let accumulated = known + before.narrow(1, 0, 4) * (&open * share * f64::from(fade));
    let rest = shape(before)[1] - 4;
    if rest == 0 {
        return accumulated;
    }
    Tensor::cat(&[accumulated, before.narrow(1, 4, rest) * open], 1)
}

/// Pull-push: `known` at 1/2^`lowest` of the resolution, with holes filled from resolutions up to 2^`levels` times
/// lower. Returns normalised colours.
fn pull_push(known: &Tensor, levels: u32, lowest: u32) -> Tensor {
    let filled = pushed(known, levels, lowest);
    filled.narrow(1, 0, 3) / filled.narrow(1, 3, 1).clamp_min(SMALLEST)
}

/// Recursive step of [`pull_push`] on four channels: colour times weight, and weight.
fn pushed(known: &Tensor, levels: u32, lowest: u32) -> Tensor {
    if levels == 0 {
        return known.shallow_clone();
    }
    let mean = means(known, &[0.125, 0.375, 0.375, 0.125], 2);
    let mean_weight = mean.narrow(1, 3, 1);
    let weight = (&mean_weight * 8.0).clamp_max(1.0);
    let colour = mean.narrow(1, 0, 3) * &weight / mean_weight.clamp_min(SMALLEST);
    let pulled = Tensor::cat(&[colour, weight], 1);
    if lowest > 0 {
        return pushed(&pulled, levels - 1, lowest - 1);
    }
    let coarser = pushed(&pulled, levels - 1, 0);
    known + (1.0 - known.narrow(1, 3, 1)) * resized(&coarser, Resize::Bilinear)
}

/// Binomial 3×3 filter, (1, 2, 1)/4 along both axes, with replicated borders.
pub(super) fn smooth(input: &Tensor) -> Tensor {
    means(input, &[0.25, 0.5, 0.25], 1)
}

/// Separable filter with `weights` at every `stride`-th pixel, with a border of one replicated pixel.
fn means(input: &Tensor, weights: &[f32], stride: i64) -> Tensor {
    let count = weights.len() as i64;
    let weights = constant(weights, input);
    let plane = weights.view([1, 1, count, 1]) * weights.view([1, 1, 1, count]);
    let channels = shape(input)[1];
    let kernel = plane.expand([channels, 1, count, count], false).contiguous();
    input.replication_pad2d([1; 4]).conv2d(&kernel, None::<Tensor>, [stride; 2], [0; 2], [1; 2], channels)
}

/// Tensor of `values` in the kind and on the device of `like`. The copy is asynchronous; a plain copy would wait for
/// the GPU.
pub(crate) fn constant<T: Element>(values: &[T], like: &Tensor) -> Tensor {
    Tensor::from_slice(values).to_kind(like.kind()).to_device_(like.device(), like.kind(), true, false)
}

/// Converts `tensor` to `kind`, without a copy if it has that kind.
pub(super) fn cast(tensor: &Tensor, kind: Kind) -> Tensor {
    if tensor.kind() == kind { tensor.shallow_clone() } else { tensor.to_kind(kind) }
}

pub(super) mod points;
#[cfg(test)]
mod tests;
