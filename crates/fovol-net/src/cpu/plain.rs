//! Convolutions and predicted kernels as plain loops: the specification with which tests compare the fast code.

use crate::cpu::conv::{ConvShape, elu};
use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::tensor_buf::TensorBuf;
use crate::plan::{Activation, Normalisation, Padding, Resize, SQUARED_EPSILON, Taps};

/// Returns `map` at the resolution of `resize`.
pub fn resized(map: &Tensor, resize: Resize) -> Tensor {
    let factor = if resize == Resize::Same { 1 } else { 2 };
    let mut out = Tensor::zeros(map.height * factor, map.width * factor, map.channels);
    for y in 0..out.height {
        for x in 0..out.width {
            for c in 0..map.channels {
                out.data[(y * out.width + x) * map.channels + c] = match resize {
                    Resize::Same => map.pixel(y, x)[c],
                    Resize::Nearest => map.pixel(y / 2, x / 2)[c],
                    Resize::Bilinear => bilinear(map, (y as f32 - 0.5) / 2.0, (x as f32 - 0.5) / 2.0, c),
                };
            }
        }
    }
    out
}

/// Interpolates bilinearly at (`y`, `x`) between pixel centres, replicated beyond the border.
fn bilinear(map: &Tensor, y: f32, x: f32, c: usize) -> f32 {
    let (y, x) = (y.clamp(0.0, map.height as f32 - 1.0), x.clamp(0.0, map.width as f32 - 1.0));
    let (top, left) = (y as usize, x as usize);
    let (bottom, right) = ((top + 1).min(map.height - 1), (left + 1).min(map.width - 1));
    let (fy, fx) = (y - top as f32, x - left as f32);
    let above = map.pixel(top, left)[c] * (1.0 - fx) + map.pixel(top, right)[c] * fx;
    let below = map.pixel(bottom, left)[c] * (1.0 - fx) + map.pixel(bottom, right)[c] * fx;
    above * (1.0 - fy) + below * fy
}

/// Concatenates `maps` along the channels.
pub fn concatenated(maps: &[Tensor]) -> Tensor {
    let channels = maps.iter().map(|map| map.channels).sum();
    let mut out =
        Tensor { data: TensorBuf::default(), height: maps[0].height, width: maps[0].width, channels };
    for y in 0..out.height {
        for x in 0..out.width {
            maps.iter().for_each(|map| out.data.extend_from_slice(map.pixel(y, x)));
        }
    }
    out
}

/// Convolution of `input` with `weights` \[out, in, size, size\] and `bias`, in double precision.
pub fn conv(shape: &ConvShape, weights: &[f32], bias: &[f32], input: &Tensor) -> Tensor {
    let [height, width] = [input.height, input.width].map(|side| side.div_ceil(shape.stride));
    let mut out = Tensor::zeros(height, width, shape.outputs);
    let reach = (shape.size / 2) as isize;
    let value = |y: isize, x: isize, c: usize| match shape.padding {
        Padding::Zero => input.or_zero(y, x, c),
        Padding::Replicate => {
            let inside = |i: isize, count: usize| i.clamp(0, count as isize - 1) as usize;
            input.pixel(inside(y, input.height), inside(x, input.width))[c]
        }
    };
    for (at, sum) in out.data.iter_mut().enumerate() {
        let (o, x, y) = (at % shape.outputs, at / shape.outputs % width, at / (shape.outputs * width));
        let mut total = f64::from(bias[o]);
        for c in 0..shape.inputs {
            for ky in 0..shape.size {
                for kx in 0..shape.size {
                    let w = weights[((o * shape.inputs + c) * shape.size + ky) * shape.size + kx];
                    let y = (y * shape.stride + ky) as isize - reach;
                    let x = (x * shape.stride + kx) as isize - reach;
                    total += f64::from(w) * f64::from(value(y, x, c));
                }
            }
        }
        *sum = match shape.activation {
            Activation::None => total as f32,
            Activation::Relu => total.max(0.0) as f32,
            Activation::Elu => elu(total as f32),
        };
    }
    out
}

/// Normalises the weights of a kernel to a sum of 1.
pub fn normalised(weights: &mut [f32], normalisation: Normalisation) {
    match normalisation {
        Normalisation::Squared => weights.iter_mut().for_each(|w| *w = *w * *w + SQUARED_EPSILON),
        Normalisation::Softmax => {
            let most = weights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            weights.iter_mut().for_each(|w| *w = (*w - most).exp());
        }
    }
    let sum: f32 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
}

/// Filters `images` by `kernels`, whose channels are the unnormalised weights. With kernels of half the resolution,
/// channel 4k + 2y + x is weight k of pixel (x, y) of the four.
pub fn filter(kernels: &Tensor, images: &[(Tensor, Taps)], normalisation: Normalisation) -> Tensor {
    let first = &images[0].0;
    let mut out = Tensor::zeros(first.height, first.width, first.channels);
    let expand = first.height / kernels.height;
    let taps: usize = images.iter().map(|(_, taps)| taps.count()).sum();
    for y in 0..out.height {
        for x in 0..out.width {
            let all = kernels.pixel(y / expand, x / expand);
            let part = (y % expand) * expand + x % expand;
            let mut weights: Vec<f32> = (0..taps).map(|k| all[k * expand * expand + part]).collect();
            normalised(&mut weights, normalisation);
            for c in 0..out.channels {
                let mut weights = weights.iter();
                let mut sum = 0.0;
                for (image, taps) in images {
                    let reach = if *taps == Taps::Around { 1 } else { 0 };
                    for dy in -reach..=reach {
                        for dx in -reach..=reach {
                            let w = weights.next().copied().unwrap_or(0.0);
                            sum += w * image.or_zero(y as isize + dy, x as isize + dx, c);
                        }
                    }
                }
                out.data[(y * out.width + x) * out.channels + c] = sum;
            }
        }
    }
    out
}
