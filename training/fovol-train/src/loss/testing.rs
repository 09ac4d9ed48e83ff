//! Helpers shared by the tests of losses.

use fovol_core::{Frame, FrameSize};
use tch::{Device, Kind, Tensor};

/// Double precision, for comparison with finite differences.
pub const EXACT: (Kind, Device) = (Kind::Double, Device::Cpu);

/// Smooth pictures \[N, 3, H, W\] in 0.1…0.9 that move with `t`; all differ.
pub fn pictures([n, height, width]: [i64; 3], t: f64, options: (Kind, Device)) -> Tensor {
    let x = Tensor::arange(width, options).view([1, 1, 1, width]);
    let y = Tensor::arange(height, options).view([1, 1, height, 1]);
    let c = Tensor::arange(3, options).view([1, 3, 1, 1]);
    let n = Tensor::arange(n, options).view([n, 1, 1, 1]);
    let wave = |fx: f64, fy: f64, ft: f64| (&x * fx + &y * fy + &c * 1.7 + &n * 2.3 + ft * t).sin();
    (wave(0.31, 0.17, 0.5) * wave(0.13, -0.41, 0.9) + wave(1.1, 0.7, -0.8) * 0.3) * 0.3 + 0.5
}

/// Pictures with errors, and the pictures. The errors neither vanish nor change sign within a step of
/// [`worst_slope`].
pub fn pair(size: [i64; 3], t: f64) -> (Tensor, Tensor) {
    let reference = pictures(size, t, EXACT);
    let error = pictures(size, 3.0 * t + 1.0, EXACT) - 0.5;
    let away_from_zero = error.sign() * (error.abs() * 0.3 + 0.02);
    (&reference + away_from_zero, reference)
}

/// Largest difference between the gradient of `f` and central differences, relative to the largest gradient. Tests 24
/// values of each of `inputs`.
pub fn worst_slope(inputs: &[Tensor], f: impl Fn(&[Tensor]) -> Tensor) -> f64 {
    let step = 1e-6;
    let leaves: Vec<Tensor> = inputs.iter().map(|input| input.detach().set_requires_grad(true)).collect();
    f(&leaves).mean(None).backward();
    let (mut worst, mut most) = (0.0f64, 0.0f64);
    for (which, leaf) in leaves.iter().enumerate() {
        let gradient = leaf.grad().view([-1]);
        let count = gradient.numel();
        for at in (0..24).map(|k| (k * count / 24 + k * 7) % count) {
            let moved = |by: f64| {
                let shifted: Vec<Tensor> = inputs.iter().map(|input| input.detach().copy()).collect();
                let _ = shifted[which].view([-1]).narrow(0, at as i64, 1).g_add_scalar_(by);
                value(&f(&shifted))
            };
            let difference = (moved(step) - moved(-step)) / (2.0 * step);
            let slope = gradient.double_value(&[at as i64]);
            worst = worst.max((slope - difference).abs());
            most = most.max(slope.abs());
        }
    }
    assert!(most > 0.0, "nothing has a slope");
    worst / most
}

/// Picture `n` of \[N, 3, H, W\] as a frame for the metrics.
pub fn frame(pictures: &Tensor, n: i64) -> Frame {
    let size = pictures.size();
    let pixels = pictures.get(n).permute([1, 2, 0]).contiguous().view([-1]).to_kind(Kind::Float);
    let pixels: Vec<f32> = Vec::try_from(pixels).unwrap();
    let pixels = pixels.chunks_exact(3).map(|p| [p[0], p[1], p[2], 1.0]).collect();
    Frame::from_pixels(FrameSize::new(size[3] as u32, size[2] as u32).unwrap(), pixels).unwrap()
}

/// The value of a scalar, or the mean over clips.
pub fn value(numbers: &Tensor) -> f64 {
    assert!(numbers.dim() < 2);
    numbers.mean(None).double_value(&[])
}
