use super::*;
use crate::cpu::plain;
use crate::plan::Resize;
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
        let maps: Vec<(Map, Resize)> = sources.iter().enumerate().map(|(i, &(channels, resize))| {
            let factor = if resize == Resize::Same { 1 } else { 2 };
            let mut map = Map::zeros(height / factor, width / factor, channels);
            map.data = random(seed.wrapping_add(i as u64), map.data.len());
            (map, resize)
        }).collect();
        let weights = random(seed ^ 77, shape.outputs * shape.inputs * shape.size * shape.size);
        let bias = random(seed ^ 78, shape.outputs);
        let resized: Vec<Map> = maps.iter().map(|(map, resize)| plain::resized(map, *resize)).collect();
        let expected = plain::conv(&shape, &weights, &bias, &plain::concatenated(&resized));
        let sources: Vec<Source<'_>> = maps.iter().map(|(map, resize)| Source { map, resize: *resize }).collect();
        for simd in Simd::available() {
            let mut out = Map::default();
            PreparedConv::new(&shape, &weights, &bias, simd).run(&sources, &mut out);
            prop_assert_eq!((out.height, out.width, out.channels), (expected.height, expected.width, expected.channels));
            for (a, b) in out.data.iter().zip(&expected.data) {
                prop_assert!((a - b).abs() <= 2e-5 * (1.0 + b.abs()), "{simd}: {a} and {b}");
            }
        }
    }
}
