//! Rounding to int8 values with straight-through gradients (Jacob et al. 2018).

use tch::{Kind, Tensor};

/// Largest byte of an input, which is not negative.
const INPUT_STEPS: f64 = 255.0;
/// Largest magnitude of a weight's byte.
const WEIGHT_STEPS: f64 = 127.0;
/// Lower bound of ranges, to avoid division by zero.
const SMALLEST: f64 = 1e-6;

/// Rounds `inputs` and the `weight` \[out, in, rows, columns\] of a convolution like the int8 engine. Each input has
/// steps of 1/255 of its range. Each output's weights, times the steps of their inputs, have steps of 1/127 of their
/// range.
///
/// Ranges are those of this frame; the engine's are calibrated over many. If any input is negative, nothing is
/// rounded, because the engine computes such layers in bf16.
pub(super) fn as_bytes(inputs: &[Tensor], weight: &Tensor) -> (Vec<Tensor>, Tensor) {
    if inputs.iter().any(|input| input.detach().min().double_value(&[]) < 0.0) {
        return (inputs.iter().map(Tensor::shallow_clone).collect(), weight.shallow_clone());
    }
    let steps: Vec<f64> = inputs
        .iter()
        .map(|input| input.detach().max().double_value(&[]).max(SMALLEST) / INPUT_STEPS)
        .collect();
    let rounded =
        inputs.iter().zip(&steps).map(|(input, &step)| rounded(input, &(input.detach() / step), step));
    (rounded.collect(), rounded_weight(inputs, weight, &steps))
}

/// Rounds `weight`. Each output's weights, times the `steps` of their inputs, become integer multiples of 1/127 of
/// the largest.
fn rounded_weight(inputs: &[Tensor], weight: &Tensor, steps: &[f64]) -> Tensor {
    let widths = inputs.iter().map(|input| input.size()[1]);
    let each: Vec<f64> = widths.zip(steps).flat_map(|(width, &step)| vec![step; width as usize]).collect();
    let step = Tensor::from_slice(&each).to_device(weight.device()).to_kind(Kind::Float).view([1, -1, 1, 1]);
    let scaled = weight.detach().to_kind(Kind::Float) * &step;
    let one = scaled.abs().amax([1i64, 2, 3].as_slice(), true).clamp_min(f64::MIN_POSITIVE) / WEIGHT_STEPS;
    let bytes = (scaled / &one).round();
    let as_read = (bytes * one / step).to_kind(weight.kind());
    weight + (as_read - weight.detach())
}

/// Rounds `value` to multiples of `step`; `multiple` is `value / step`.
fn rounded(value: &Tensor, multiple: &Tensor, step: f64) -> Tensor {
    let bytes = multiple.to_kind(Kind::Float).round();
    value + ((bytes * step).to_kind(value.kind()) - value.detach())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tch::Device;

    #[test]
    fn numbers_become_bytes_and_gradients_pass() {
        tch::manual_seed(5);
        let inputs = [2, 3].map(|c| Tensor::rand([1, c, 6, 5], (Kind::Float, Device::Cpu)) * c as f64);
        let weight = Tensor::randn([4, 5, 3, 3], (Kind::Float, Device::Cpu)).set_requires_grad(true);
        let (bytes, rounded) = as_bytes(&inputs, &weight);
        for (input, bytes) in inputs.iter().zip(&bytes) {
            let step = input.max().double_value(&[]) / 255.0;
            let off = (bytes / step - (bytes / step).round()).abs().max().double_value(&[]);
            assert!(off < 1e-3, "{off}");
            let error = (bytes - input).abs().max().double_value(&[]);
            assert!(error > 0.0 && error <= 0.51 * step, "{error} of {step}");
        }
        let error = (&rounded - &weight).abs().max().double_value(&[]);
        assert!(error > 0.0 && error < 4.0 / 127.0, "{error}");
        let picture = Tensor::cat(&bytes, 1).conv2d(&rounded, None::<Tensor>, [1; 2], [1; 2], [1; 2], 1);
        picture.sum(Kind::Float).backward();
        assert!(weight.grad().abs().min().double_value(&[]) > 0.0);
    }

    #[test]
    fn negative_inputs_stay_as_they_are() {
        let input = Tensor::from_slice(&[-1.0f32, 0.123_456]).view([1, 1, 1, 2]);
        let weight = Tensor::from_slice(&[0.333f32]).view([1, 1, 1, 1]);
        let (inputs, same) = as_bytes(&[input.shallow_clone()], &weight);
        assert!(inputs[0] == input && same == weight);
    }
}
