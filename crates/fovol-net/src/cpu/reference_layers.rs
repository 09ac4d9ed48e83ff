//! Compares each kind of layer with PyTorch in double precision. `tests/reference/network/make_cases.py` made the
//! cases.

use crate::cpu::conv::patch::Source;
use crate::cpu::conv::{Arithmetic, ConvShape, PreparedConv};
use crate::cpu::fill::pyramid::Pyramid;
use crate::cpu::fill::spread::{blend, smooth, spread};
use crate::cpu::filter::{Out, PreparedFilter};
use crate::cpu::history::accumulate::{Expected, Fading, accumulate, history_confidence};
use crate::cpu::history::points;
use crate::cpu::history::warp::warp;
use crate::cpu::layers::norm::normalise;
use crate::cpu::layers::pointwise::{Change, change};
use crate::cpu::layers::reshape;
use crate::cpu::tensor::samples::KnownPixels;
use crate::cpu::tensor::{AnyTensor, Tensor};
use crate::plan::POINT;
use crate::plan::{Activation, Filter, Normalisation, Padding, Read, Resize, Taps, TensorId};
use fovol_simd::Simd;

#[path = "../../tests/cases/layers.rs"]
mod layer_cases;

use layer_cases::{Case, each_case};

impl Case<'_> {
    /// Reads an image of the case, stored as \[channel\]\[row\]\[column\].
    fn map(&self, part: &str) -> Option<Tensor> {
        let (shape, planes) = self.values(part)?;
        let [channels, height, width] = shape[..] else { panic!("{} {part}: {shape:?}", self.name) };
        let mut map = Tensor::zeros(height, width, channels);
        for (at, v) in map.data.iter_mut().enumerate() {
            *v = planes[at % channels * height * width + at / channels];
        }
        Some(map)
    }

    fn inputs(&self) -> Vec<Tensor> {
        (0..).map_while(|i| self.map(&format!("in{i}"))).collect()
    }

    fn weights(&self) -> (Vec<f32>, Vec<f32>) {
        (self.values("weight").unwrap().1, self.values("bias").unwrap().1)
    }

    fn run(&self, simd: Simd) -> Tensor {
        let inputs = self.inputs();
        let mut out = Tensor::default();
        match self.word("kind") {
            "conv" => return self.conv(inputs, simd),
            "filter" => return self.filter(inputs, simd),
            "norm" => {
                let (weight, bias) = self.weights();
                out = inputs[0].clone();
                normalise(&mut out, &weight, &bias, self.activation());
            }
            "pool" => reshape::pool(&inputs[0], &mut out),
            "space-to-depth" => reshape::space_to_depth(&inputs[0], &mut out),
            "depth-to-space" => reshape::depth_to_space(&inputs[0], &mut out),
            "add" => {
                out = inputs[0].clone();
                change(&[Change::Add(&inputs[1])], &mut out);
            }
            "bypass" => {
                out = inputs[2].clone();
                change(&[Change::Bypass { colour: &inputs[0], mask: &inputs[1] }], &mut out);
            }
            "warp" => warp(&inputs[0], &inputs[1], &mut out),
            "reproject" => {
                points::reproject(&points::of_pixels(&inputs[0]), &inputs[1], None, &mut out);
                out = points::pixels(&out);
            }
            "splat" => points::splat(&points::of_pixels(&inputs[0]), &mut out),
            "spread" => {
                let levels = self.number("levels") as u32;
                spread(
                    KnownPixels::All(&inputs[0]),
                    inputs.get(1),
                    levels,
                    &mut Pyramid::default(),
                    &mut out,
                );
            }
            "smooth" => smooth(&inputs[0], &mut out),
            "blend" => blend(KnownPixels::All(&inputs[0]), &inputs[1], &mut out),
            "doubt" => {
                let levels = self.number("levels") as u32;
                let expected = Expected { prior: &inputs[1], fresh: &inputs[2] };
                history_confidence(
                    KnownPixels::All(&inputs[0]),
                    &expected,
                    [levels, levels.min(3)],
                    &mut Pyramid::default(),
                    &mut out,
                );
            }
            "accumulate" => {
                let fade = self.facts["fade"].as_f64().unwrap() as f32;
                let are_points = inputs[1].channels == POINT;
                out = if are_points { points::of_pixels(&inputs[1]) } else { inputs[1].clone() };
                let (known, share) = (KnownPixels::All(&inputs[0]), inputs.get(2));
                accumulate(Fading { known, share, fade }, &mut out);
                if are_points {
                    out = points::pixels(&out);
                }
            }
            other => panic!("no arm for layers of kind `{other}`"),
        }
        out
    }

    fn conv(&self, inputs: Vec<Tensor>, simd: Simd) -> Tensor {
        let (weights, bias) = self.weights();
        let shape = ConvShape {
            inputs: inputs.iter().map(|map| map.channels).sum(),
            outputs: bias.len(),
            size: self.number("size"),
            stride: self.number("stride"),
            padding: if self.word("padding") == "zero" { Padding::Zero } else { Padding::Replicate },
            activation: self.activation(),
        };
        let stored: Vec<(AnyTensor, Resize)> =
            inputs.into_iter().map(AnyTensor::F32).zip(self.resizes()).collect();
        let sources: Vec<Source<'_>> = stored.iter().map(|(map, resize)| Source::new(map, *resize)).collect();
        let mut out = Tensor::default();
        PreparedConv::new(&shape, &weights, &bias, simd, Arithmetic::F32).run(&sources, &mut out);
        out
    }

    fn filter(&self, mut inputs: Vec<Tensor>, simd: Simd) -> Tensor {
        let (weights, bias) = self.weights();
        let features = inputs.remove(0);
        let images = self.images();
        let layer = Filter {
            name: self.name.into(),
            features: TensorId(0),
            expand: self.number("expand"),
            images: images
                .iter()
                .map(|&(resize, taps)| (Read { tensor: TensorId(0), resize }, taps))
                .collect(),
            output: TensorId(0),
            normalisation: self.normalisation(),
        };
        let prepared = PreparedFilter::new(&layer, (&weights, &bias), None, simd);
        let stored: Vec<AnyTensor> = inputs.into_iter().map(AnyTensor::F32).collect();
        let sources = stored.iter().zip(&images).map(|(map, &(resize, _))| Source::new(map, resize));
        let mut out = Tensor::default();
        prepared.run(
            &AnyTensor::F32(features),
            &sources.collect::<Vec<_>>(),
            &[],
            Out { picture: Some(&mut out), frame: None },
        );
        out
    }
}

#[test]
fn layers_agree_with_pytorch() {
    each_case(|case| {
        let expected = case.map("out").unwrap();
        for simd in Simd::available() {
            let found = case.run(simd);
            let size = |map: &Tensor| [map.height, map.width, map.channels];
            assert_eq!(size(&found), size(&expected), "{}", case.name);
            for (a, b) in found.data.iter().zip(&expected.data) {
                assert!((a - b).abs() <= 1e-5 * (1.0 + b.abs()), "{} {simd}: {a} and {b}", case.name);
            }
        }
    });
}
