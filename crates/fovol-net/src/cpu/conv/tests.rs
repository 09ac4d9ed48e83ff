use super::*;
use crate::cpu::conv::patch::Access;
use crate::cpu::plain;
use crate::cpu::tensor::AnyTensor;
use crate::plan::{Activation, Padding, Resize};
use proptest::prelude::*;

fn random(seed: u64, count: usize) -> Vec<f32> {
    let parameter = crate::plan::Parameter { name: "x".into(), shape: vec![count, 5] };
    let mut values = crate::weights::random::values(&parameter, seed);
    values.truncate(count);
    values
}

fn shapes() -> impl Strategy<Value = (ConvShape, Vec<(usize, Resize)>, [usize; 2], u64)> {
    let sources = prop::collection::vec(
        (1usize..20, prop::sample::select(vec![Resize::Same, Resize::Bilinear, Resize::Nearest])),
        1..4,
    );
    let padding = prop::sample::select(vec![Padding::Zero, Padding::Replicate]);
    let activation = prop::sample::select(vec![Activation::None, Activation::Relu, Activation::Elu]);
    let sides = prop::array::uniform2(1usize..20);
    (sources, 1usize..70, prop::bool::ANY, 1usize..3, padding, activation, sides, any::<u64>()).prop_map(
        |(sources, outputs, is_wide, stride, padding, activation, sides, seed)| {
            let inputs = sources.iter().map(|(channels, _)| channels).sum();
            let (size, stride) = if is_wide { (3, stride) } else { (1, 1) };
            let shape = ConvShape { inputs, outputs, size, stride, padding, activation };
            (shape, sources, sides.map(|side| 2 * side), seed)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn kernels_agree_with_plain_loops((shape, sources, [height, width], seed) in shapes()) {
        let maps: Vec<(Tensor, Resize)> = sources.iter().enumerate().map(|(i, &(channels, resize))| {
            let factor = if resize == Resize::Same { 1 } else { 2 };
            let mut map = Tensor::zeros(height / factor, width / factor, channels);
            map.data = random(seed.wrapping_add(i as u64), map.data.len()).into();
            (map, resize)
        }).collect();
        let weights = random(seed ^ 77, shape.outputs * shape.inputs * shape.size * shape.size);
        let bias = random(seed ^ 78, shape.outputs);
        let resized: Vec<Tensor> = maps.iter().map(|(map, resize)| plain::resized(map, *resize)).collect();
        let input = plain::concatenated(&resized);
        let expected = plain::conv(&shape, &weights, &bias, &input);
        // Rounding errors scale with the sum of the absolute values of all products.
        let magnitudes = |values: &[f32]| values.iter().map(|v| v.abs()).collect::<Vec<f32>>();
        let unsigned = Tensor { data: magnitudes(&input.data).into(), ..input };
        let plain_shape = ConvShape { activation: Activation::None, ..shape };
        let most = plain::conv(&plain_shape, &magnitudes(&weights), &magnitudes(&bias), &unsigned);
        let largest: Vec<f32> = (0..shape.outputs)
            .map(|output| most.data.iter().skip(output).step_by(shape.outputs).copied().fold(0.0, f32::max))
            .collect();
        let stored: Vec<(AnyTensor, Resize)> = maps.into_iter().map(|(map, resize)| (AnyTensor::F32(map), resize)).collect();
        let sources: Vec<Source<'_>> = stored.iter().map(|(map, resize)| Source::new(map, *resize)).collect();
        for simd in Simd::available() {
            for arithmetic in [Arithmetic::F32, Arithmetic::Bf16] {
                // bf16 has 8 significant bits, so each factor of a product has a relative error of 2^-8 at most.
                let tolerance = match arithmetic {
                    Arithmetic::F32 => 2e-6,
                    // The inverse transform amplifies the rounding errors of transformed values.
                    _ if Winograd::suits(&shape, simd, &arithmetic) => 1.0 / 40.0,
                    _ => 1.0 / 126.0,
                };
                let mut out = Tensor::<f32>::default();
                PreparedConv::new(&shape, &weights, &bias, simd, arithmetic.clone()).run(&sources, &mut out);
                prop_assert_eq!((out.height, out.width, out.channels), (expected.height, expected.width, expected.channels));
                // Tiles of Winograd's transforms mix neighbours: at a border of zeros the errors are those of the inside.
                let is_mixed = Winograd::suits(&shape, simd, &arithmetic);
                for (i, ((a, b), most)) in out.data.iter().zip(&expected.data).zip(&most.data).enumerate() {
                    let most = if is_mixed { largest[i % shape.outputs] } else { *most };
                    prop_assert!((a - b).abs() <= tolerance * most + 1e-6, "{simd} {arithmetic:?}: {a} and {b}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn folding_may_wait_until_reading(
        channels in prop::array::uniform2(1usize..7),
        outputs in 1usize..40,
        is_wide in prop::bool::ANY,
        [height, width] in prop::array::uniform2(1usize..20),
        seed in 0u64..1000,
    ) {
        let size = if is_wide { 3 } else { 1 };
        let inputs = channels.iter().map(|c| 4 * c).sum();
        let shape = ConvShape {
            inputs, outputs, size, stride: 1, padding: Padding::Zero, activation: Activation::None,
        };
        let maps = channels.map(|c| {
            let mut map = Tensor::zeros(2 * height, 2 * width, c);
            map.data = random(seed + c as u64, map.data.len()).into();
            map
        });
        let folded = maps.each_ref().map(|map| {
            let (mut out, mut ordered) = (Tensor::default(), Tensor::default());
            crate::cpu::layers::reshape::space_to_depth(map, &mut out);
            ordered.resize([height, width, out.channels]);
            let pixels = ordered.data.chunks_exact_mut(out.channels).zip(out.data.chunks_exact(out.channels));
            for (to, from) in pixels {
                to.iter_mut().zip(patch::unfolded(map.channels)).for_each(|(to, at)| *to = from[at]);
            }
            AnyTensor::F32(ordered)
        });
        let maps = maps.map(AnyTensor::F32);
        let conv = |simd, arithmetic| {
            PreparedConv::new(&shape, &random(seed, outputs * inputs * size * size), &random(seed, outputs), simd, arithmetic)
        };
        for simd in Simd::available() {
            for arithmetic in [Arithmetic::F32, Arithmetic::Bf16] {
                let conv = conv(simd, arithmetic);
                let [mut expected, mut out] = [Tensor::<f32>::default(), Tensor::default()];
                conv.run(&folded.each_ref().map(|map| Source::new(map, Resize::Same)), &mut expected);
                conv.run(&maps.each_ref().map(|map| Source::read(map, Access::Folded)), &mut out);
                prop_assert!(out == expected);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn two_halves_of_weights_are_as_good_as_f32(
        [inputs, outputs, height, width] in prop::array::uniform4(1usize..40),
        is_wide in prop::bool::ANY,
        seed in any::<u64>(),
    ) {
        let size = if is_wide { 3 } else { 1 };
        let shape = ConvShape {
            inputs, outputs, size, stride: 1, padding: Padding::Zero, activation: Activation::None,
        };
        let mut map = Tensor::<Bf16>::zeros(height, width, inputs);
        let values = random(seed, map.data.len());
        map.data.iter_mut().zip(values).for_each(|(to, v)| *to = Bf16::from_f32(v));
        let map = AnyTensor::Bf16(map);
        let weights = random(seed ^ 77, outputs * inputs * size * size);
        let bias = random(seed ^ 78, outputs);
        let expected = plain::conv(&shape, &weights, &bias, &map.to_f32());
        for simd in Simd::available() {
            let mut out = Tensor::<f32>::default();
            let conv = PreparedConv::new(&shape, &weights, &bias, simd, Arithmetic::SplitBf16);
            conv.run(&[Source::read(&map, Access::SAME)], &mut out);
            for (a, b) in out.data.iter().zip(&expected.data) {
                // Weights have 16 significant bits; values and weights are 1 at most.
                prop_assert!((a - b).abs() <= (inputs * size * size) as f32 / 65536.0, "{simd}: {a} and {b}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn bytes_of_transformed_inputs_are_close(
        (inputs, outputs) in (20usize..70, 52usize..70),
        [height, width] in prop::array::uniform2(8usize..40),
        is_zero in prop::bool::ANY,
        seed in 0u64..1000,
    ) {
        let padding = if is_zero { Padding::Zero } else { Padding::Replicate };
        let shape = ConvShape { inputs, outputs, size: 3, stride: 1, padding, activation: Activation::None };
        let mut map = Tensor::<Bf16>::zeros(height, width, inputs);
        let values = random(seed, map.data.len());
        map.data.iter_mut().zip(values).for_each(|(to, v)| *to = Bf16::from_f32(v.abs()));
        let map = AnyTensor::Bf16(map);
        let sources = [Source::read(&map, Access::SAME)];
        let weights = random(seed ^ 77, outputs * inputs * 9);
        let bias = random(seed ^ 78, outputs);
        let expected = plain::conv(&shape, &weights, &bias, &map.to_f32());
        let mut distances = Distances::default();
        note_transformed(&sources, padding, &mut distances);
        let arithmetic =
            Arithmetic::Int8 { steps: vec![1.0 / 255.0; inputs], reach: Some(distances.reach(inputs)) };
        let squares = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>();
        for simd in Simd::available() {
            if !Winograd::suits(&shape, simd, &arithmetic) {
                continue;
            }
            let mut out = Tensor::<f32>::default();
            PreparedConv::new(&shape, &weights, &bias, simd, arithmetic.clone()).run(&sources, &mut out);
            let wrong = squares(&mut out.data.iter().zip(&expected.data).map(|(a, b)| a - b));
            let all = squares(&mut expected.data.iter().copied());
            prop_assert!(wrong < 0.04f64.powi(2) * all, "{simd}: {}", (wrong / all).sqrt());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn bytes_are_within_their_steps_and_alike_everywhere((shape, sources, [height, width], seed) in shapes()) {
        let shape = ConvShape { activation: Activation::None, ..shape };
        let stored: Vec<(AnyTensor, Resize)> = sources.iter().enumerate().map(|(i, &(channels, resize))| {
            let factor = if resize == Resize::Same { 1 } else { 2 };
            let mut map = Tensor::zeros(height / factor, width / factor, channels);
            map.data = random(seed.wrapping_add(i as u64), map.data.len()).into();
            map.data.iter_mut().for_each(|v| *v = v.abs());
            (AnyTensor::F32(map), resize)
        }).collect();
        let weights = random(seed ^ 77, shape.outputs * shape.inputs * shape.size * shape.size);
        let bias = random(seed ^ 78, shape.outputs);
        let resized: Vec<Tensor> = stored.iter().map(|(map, resize)| plain::resized(map.picture(), *resize)).collect();
        let expected = plain::conv(&shape, &weights, &bias, &plain::concatenated(&resized));
        let sources: Vec<Source<'_>> = stored.iter().map(|(map, resize)| Source::new(map, *resize)).collect();
        let mut all = Vec::new();
        for simd in Simd::available() {
            let mut out = Tensor::<f32>::default();
            let arithmetic = Arithmetic::Int8 { steps: vec![1.0 / 255.0; shape.inputs], reach: None };
            PreparedConv::new(&shape, &weights, &bias, simd, arithmetic).run(&sources, &mut out);
            // Half a step of each input and of each weight; values and weights are 1 at most.
            let terms = (shape.inputs * shape.size * shape.size) as f32;
            let tolerance = terms * (0.5 / 255.0 + 0.5 / 127.0) + 1e-3;
            for (a, b) in out.data.iter().zip(&expected.data) {
                prop_assert!((a - b).abs() <= tolerance, "{simd}: {a} and {b}");
            }
            all.push(out);
        }
        prop_assert!(all.iter().all(|out| *out == all[0]));
    }
}
