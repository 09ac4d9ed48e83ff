//! Tests of every layer against PyTorch's cases in double precision (`tests/reference/network/make_cases.py`), and of
//! its gradient against finite differences.

use super::*;
use fovol_net::plan::{Read, TensorId};

/// Convolution with arbitrary name and tensors.
fn conv_layer(size: usize, stride: usize, padding: Padding, activation: Activation) -> Conv {
    let input = Read::same(TensorId::UNSET);
    Conv { stride, padding, ..Conv::new("conv", &[input], 3, size, activation) }
}

/// Layer as a function of tensors.
type Function<'a> = Box<dyn Fn(&[Tensor]) -> Tensor + 'a>;

#[path = "../../../../../crates/fovol-net/tests/cases/layers.rs"]
mod layer_cases;

use layer_cases::{Case, each_case};

impl Case<'_> {
    /// Part of the case in f64; images get a batch dimension.
    fn part(&self, part: &str) -> Option<Tensor> {
        let (shape, values) = self.values(part)?;
        let shape: Vec<i64> = shape.iter().map(|&side| side as i64).collect();
        let tensor = Tensor::from_slice(&values).reshape(shape).to_kind(Kind::Double);
        Some(if part.starts_with("in") || part == "out" { tensor.unsqueeze(0) } else { tensor })
    }

    fn inputs(&self) -> Vec<Tensor> {
        (0..).map_while(|i| self.part(&format!("in{i}"))).collect()
    }

    /// The layer as a function of its inputs, followed by weight and bias where it has them.
    fn layer(&self) -> Function<'_> {
        match self.word("kind") {
            "conv" => {
                let padding = if self.word("padding") == "zero" { Padding::Zero } else { Padding::Replicate };
                let (size, stride) = (self.number("size"), self.number("stride"));
                let layer = conv_layer(size, stride, padding, self.activation());
                let resizes = self.resizes();
                Box::new(move |all| {
                    let (inputs, learned) = all.split_at(all.len() - 2);
                    let inputs = inputs.iter().zip(&resizes).map(|(input, &change)| resized(input, change));
                    let input = Tensor::cat(&inputs.collect::<Vec<_>>(), 1);
                    conv(&layer, &input, &learned[0], &learned[1])
                })
            }
            "filter" => Box::new(|all| {
                let (inputs, learned) = all.split_at(all.len() - 2);
                let kernels = inputs[0].conv2d(&learned[0], Some(&learned[1]), [1; 2], [0; 2], [1; 2], 1);
                let images = inputs[1..].iter().zip(self.images());
                let images: Vec<_> =
                    images.map(|(input, (change, taps))| (resized(input, change), taps)).collect();
                filter(&kernels, self.number("expand"), &images, self.normalisation())
            }),
            "norm" => Box::new(|all| norm(&all[0], &all[1], &all[2], self.activation())),
            "pool" => Box::new(|all| pool(&all[0], 2)),
            "space-to-depth" => Box::new(|all| all[0].pixel_unshuffle(2)),
            "depth-to-space" => Box::new(|all| all[0].pixel_shuffle(2)),
            "add" => Box::new(|all| &all[0] + &all[1]),
            "bypass" => Box::new(|all| bypass(&all[0], &all[1], &all[2])),
            "warp" => Box::new(|all| warp(&all[0], &all[1])),
            "reproject" => Box::new(|all| points::reproject(&all[0], &all[1])),
            "splat" => Box::new(|all| points::splat(&all[0])),
            "spread" => Box::new(|all| spread(&all[0], all.get(1), self.number("levels") as u32)),
            "smooth" => Box::new(|all| smooth(&all[0])),
            "blend" => Box::new(|all| blend(&all[0], &all[1])),
            "doubt" => {
                let levels = self.number("levels") as u32;
                Box::new(move |all| history_confidence(&all[0], [&all[1], &all[2]], [levels, levels.min(3)]))
            }
            "accumulate" => {
                let fade = self.facts["fade"].as_f64().unwrap() as f32;
                Box::new(move |all| accumulate(&all[0], &all[1], all.get(2), fade))
            }
            other => panic!("no arm for layers of kind `{other}`"),
        }
    }

    fn tensors(&self) -> Vec<Tensor> {
        let learned = ["weight", "bias"].into_iter().filter_map(|part| self.part(part));
        self.inputs().into_iter().chain(learned).collect()
    }
}

#[test]
fn layers_agree_with_pytorch() {
    each_case(|case| {
        let (found, expected) = (case.layer()(&case.tensors()), case.part("out").unwrap());
        assert_eq!(found.size(), expected.size(), "{}", case.name);
        // The cases are rounded to f32.
        let excess = (found - &expected).abs() - (expected.abs() + 1.0) * 1e-7;
        assert!(excess.max().double_value(&[]) <= 0.0, "{}: {excess}", case.name);
    });
}

#[test]
fn gradients_agree_with_differences() {
    each_case(|case| {
        let tensors = case.tensors();
        for (number, tensor) in tensors.iter().enumerate() {
            // Samples, masks and motion are inputs of the network; no gradients flow to them.
            let is_given = matches!(
                (case.word("kind"), number),
                ("bypass" | "warp", 1)
                    | ("spread" | "blend" | "doubt" | "accumulate", 0)
                    | ("reproject" | "splat", _)
            );
            if !is_given {
                let worst = gradient_error(&case.layer(), &tensors, number, tensor);
                assert!(worst < 1e-6, "{} of tensor {number}: {worst:.1e}", case.name);
            }
        }
    });
}

/// Largest difference between autograd and central differences for a fixed projection of `layer`'s output, with
/// respect to tensor `number`. Relative to the largest gradient; tests up to 40 values.
fn gradient_error(layer: &Function<'_>, tensors: &[Tensor], number: usize, tensor: &Tensor) -> f64 {
    let projected = |tensor: &Tensor| {
        let mut all: Vec<Tensor> = tensors.iter().map(Tensor::shallow_clone).collect();
        all[number] = tensor.shallow_clone();
        let out = layer(&all);
        let wave = Tensor::arange(out.numel() as i64, (Kind::Double, tensor.device()));
        (out.reshape([-1]) * (wave * 1.7).sin()).sum(Kind::Double)
    };
    let leaf = tensor.copy().set_requires_grad(true);
    projected(&leaf).backward();
    let gradient = leaf.grad().reshape([-1]);
    let most = gradient.abs().max().double_value(&[]).max(1e-3);
    let count = tensor.numel() as i64;
    let step = 1e-6;
    let moved = |place: i64, by: f64| {
        let copy = tensor.copy();
        let _ = copy.view([-1]).narrow(0, place, 1).g_add_scalar_(by);
        projected(&copy).double_value(&[])
    };
    let places = (0..count).step_by((count as usize).div_ceil(40));
    places.fold(0.0, |worst: f64, place| {
        let difference = (moved(place, step) - moved(place, -step)) / (2.0 * step);
        worst.max((difference - gradient.double_value(&[place])).abs() / most)
    })
}

#[test]
fn motion_that_is_no_number_leads_outside() {
    let image = Tensor::ones([1, 2, 4, 6], (Kind::Float, Device::Cpu));
    for motion in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let motion = Tensor::full([1, 2, 8, 12], motion, (Kind::Float, Device::Cpu));
        assert_eq!(warp(&image, &motion).abs().sum(Kind::Float).double_value(&[]), 0.0);
        let points = Tensor::ones([1, 6, 8, 12], (Kind::Float, Device::Cpu));
        assert_eq!(points::reproject(&points, &motion).abs().sum(Kind::Float).double_value(&[]), 0.0);
    }
}

#[test]
fn both_ways_to_filter_are_the_same() {
    let options = (Kind::Double, Device::Cpu);
    let weights = Tensor::rand([2, 9, 5, 7], options).set_requires_grad(true);
    let image = Tensor::rand([2, 3, 5, 7], options).set_requires_grad(true);
    let values = |filter: fn(&Tensor, &Tensor) -> Tensor| {
        let out = filter(&weights, &image);
        let energy = (&out * &out).sum(Kind::Double);
        let mut values = Tensor::run_backward(&[energy], &[&weights, &image], false, false);
        values.push(out);
        values
    };
    for (a, b) in values(filtered_by_views).iter().zip(values(filtered_unfolded)) {
        assert!((a - b).abs().max().double_value(&[]) < 1e-13);
    }
}
