//! Samples of earlier frames as points with subpixel positions.
//!
//! No gradients are kept, since nothing learned precedes these layers.

use super::{FAR, shape};
use fovol_net::plan::POINT;
use tch::Tensor;

/// First channels of the weight and of the subpixel position of a point.
const WEIGHT: i64 = 3;
const PLACE: i64 = 4;

/// Moves the points of `input` along `motion`, in pixels to the previous position. A pixel collects the points in the
/// unit square around its previous position. Several points become their mean, with the largest of their weights.
pub(crate) fn reproject(input: &Tensor, motion: &Tensor) -> Tensor {
    tch::no_grad(|| {
        let [batch, channels, height, width] = shape(input);
        let motion = motion.nan_to_num(FAR, FAR, -FAR).clamp(-FAR, FAR);
        let line =
            |count: i64, shape: [i64; 4]| Tensor::arange(count, (input.kind(), input.device())).view(shape);
        let whole = motion.floor();
        let part = motion - &whole;
        let first = [
            whole.narrow(1, 0, 1) + line(width, [1, 1, 1, width]),
            whole.narrow(1, 1, 1) + line(height, [1, 1, height, 1]),
        ];
        let pixels = input.view([batch, channels, height * width]);
        let mut sum = input.zeros_like();
        let mut largest = input.narrow(1, WEIGHT, 1).zeros_like();
        for (right, below) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let [x, y] = [&first[0] + right, &first[1] + below];
            let inside = x.ge(0.0) * x.lt(width as f64) * y.ge(0.0) * y.lt(height as f64);
            let index = y.clamp(0.0, (height - 1) as f64) * width as f64 + x.clamp(0.0, (width - 1) as f64);
            let index = index.to_kind(tch::Kind::Int64).view([batch, 1, height * width]);
            let found = pixels.gather(2, &index.expand([batch, channels, height * width], false), false);
            let found = found.view([batch, channels, height, width]);
            let place = [(0, right), (1, below)]
                .map(|(axis, step)| found.narrow(1, PLACE + axis, 1) + (step - part.narrow(1, axis, 1)));
            let [across, down] = place.each_ref().map(|place| place.ge(-0.5) * place.lt(0.5));
            let weight = found.narrow(1, WEIGHT, 1) * (inside * across * down).to_kind(input.kind());
            let known = found.narrow(1, 0, PLACE) * weight.gt(0.0).to_kind(input.kind());
            let places = Tensor::cat(&place, 1) * &weight;
            sum += Tensor::cat(&[known, places], 1);
            largest = largest.maximum(&weight);
        }
        let total = sum.narrow(1, WEIGHT, 1);
        let divisor = total.where_self(&total.gt(0.0), &total.ones_like());
        let known = sum.narrow(1, 0, PLACE) * (&largest / &divisor);
        let places = sum.narrow(1, PLACE, POINT as i64 - PLACE) / divisor;
        Tensor::cat(&[known, places], 1)
    })
}

/// Bilinear splat of the points of `input` onto pixel centres. Sums are divided by the sum of the bilinear weights
/// where that exceeds one.
pub(crate) fn splat(input: &Tensor) -> Tensor {
    tch::no_grad(|| {
        let [_, _, height, width] = shape(input);
        let known = input.narrow(1, WEIGHT, 1).gt(0.0).to_kind(input.kind());
        let padded = Tensor::cat(&[input, &known], 1).constant_pad_nd([1; 4]);
        let mut sum = input.narrow(1, 0, PLACE).zeros_like();
        let mut shares = known.zeros_like();
        for (row, column) in (0..9).map(|at| (at / 3, at % 3)) {
            let from = padded.narrow(2, row, height).narrow(3, column, width);
            let near = |axis: i64, step: i64| {
                let apart = from.narrow(1, PLACE + axis, 1) + (step - 1) as f64;
                (-apart.abs() + 1.0).clamp_min(0.0)
            };
            let share = near(0, column) * near(1, row) * from.narrow(1, POINT as i64, 1);
            sum += from.narrow(1, 0, PLACE) * &share;
            shares += share;
        }
        sum / shares.clamp_min(1.0)
    })
}
