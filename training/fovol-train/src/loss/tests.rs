//! Tests of whole losses: formula, gradients, and sums over parts of a clip.

use super::testing::{EXACT, pair, pictures, value, worst_slope};
use super::*;

struct Made {
    outputs: Vec<Tensor>,
    references: Vec<Tensor>,
    motion: Vec<Tensor>,
}

fn made(length: usize) -> Made {
    let (outputs, references) = (0..length).map(|t| pair([2, 12, 14], t as f64 * 0.4)).unzip();
    let motion = |t: usize| pictures([2, 12, 14], t as f64 + 9.0, EXACT).narrow(1, 0, 2) * 3.0 - 1.4;
    Made { outputs, references, motion: (0..length).map(motion).collect() }
}

impl Made {
    fn clip<'a>(&'a self, outputs: &'a [Tensor]) -> Clip<'a> {
        Clip { outputs, references: &self.references, motion: Some(&self.motion) }
    }
}

fn losses(config: &LossConfig) -> Losses {
    Losses::new(config, Device::Cpu).unwrap()
}

#[test]
fn the_total_is_the_formula_of_the_paper() {
    let made = made(4);
    let config = LossConfig { flow: FlowSource::Exact, ..LossConfig::default() };
    let found = losses(&config).clip(&made.clip(&made.outputs)).unwrap();
    let measure = L1MsSsim::default();
    let l1 = |a: &Tensor, b: &Tensor| value(&(a - b).abs().mean(None));
    let (y, r) = (&made.outputs, &made.references);
    let (mut spatial, mut differences, mut flow) = (0.0, 0.0, 0.0);
    for i in 0..4 {
        let both = 0.9 * value(&measure.distance(&y[i], &r[i]).unwrap()) + 0.1 * l1(&y[i], &r[i]);
        spatial += (1.0 - (-0.5 * i as f64).exp()) * both;
        for j in 0..i {
            differences += l1(&(&y[i] - &y[j]), &(&r[i] - &r[j]));
        }
        if i > 0 {
            flow += l1(&y[i], &flow::warp(&y[i - 1], &made.motion[i]));
        }
    }
    let expected = 0.8 * spatial / 4.0 + differences / 6.0 + 0.1 * flow;
    assert!((value(&found.total) - expected).abs() < 1e-12);
    let parts = [spatial / 4.0, differences / 6.0, flow];
    for (found, expected) in [&found.spatial, &found.temporal, &found.flow].into_iter().zip(parts) {
        assert!((value(found) - expected).abs() < 1e-12);
    }
    assert_eq!(found.values().map(|(name, _)| name)[0], "total");
}

#[test]
fn logarithms_make_a_hundredth_count_alike_everywhere() {
    let made = made(4);
    let config = LossConfig {
        logarithmic: true,
        l1_weight: 0.3,
        perceptual_weight: 0.0,
        squares_weight: 0.5,
        coarse_weight: 0.25,
        flow_weight: 0.0,
        spatial_weight: 1.0,
        ..LossConfig::default()
    };
    let losses = losses(&config);
    let total = |outputs: &[Tensor]| value(&losses.clip(&made.clip(outputs)).unwrap().total);
    let with_errors = |factor: f64| -> Vec<Tensor> {
        let both = made.outputs.iter().zip(&made.references);
        both.map(|(output, reference)| reference + (output - reference) * factor).collect()
    };
    // All terms but the squares halve.
    let expected = (0.3 + 2.0 * (0.5 + 2.0 * 0.25) + 1.0) * 0.5f64.ln();
    assert!((total(&with_errors(0.5)) - total(&made.outputs) - expected).abs() < 1e-2);
    let part = Clip { outputs: &made.outputs[..2], references: &made.references[..2], motion: None };
    let message = losses.frames(&part, 0..2, 4).unwrap_err().to_string();
    assert!(message.contains("do not add up"), "{message}");
}

#[test]
fn clips_judged_together_are_judged_as_each_alone() {
    let made = made(4);
    let config = LossConfig {
        logarithmic: true,
        squares_weight: 0.5,
        coarse_weight: 0.25,
        flow: FlowSource::Exact,
        ..LossConfig::default()
    };
    let losses = losses(&config);
    let judged = |clips: [i64; 2]| {
        let of = |frames: &[Tensor]| frames.iter().map(|t| t.narrow(0, clips[0], clips[1])).collect();
        let [references, motion]: [Vec<Tensor>; 2] = [of(&made.references), of(&made.motion)];
        let outputs: Vec<Tensor> = of(&made.outputs);
        let outputs: Vec<Tensor> =
            outputs.iter().map(|output| output.copy().set_requires_grad(true)).collect();
        let clip = Clip { outputs: &outputs, references: &references, motion: Some(&motion) };
        let terms = losses.clip(&clip).unwrap();
        terms.total.backward();
        (terms.values(), outputs.iter().map(Tensor::grad).collect::<Vec<_>>())
    };
    let (together, slopes) = judged([0, 2]);
    let (alone, alone_slopes): (Vec<_>, Vec<_>) = [judged([0, 1]), judged([1, 1])].into_iter().unzip();
    assert_ne!(alone[0][0].1, alone[1][0].1);
    for (term, (name, value)) in together.into_iter().enumerate() {
        let mean = 0.5 * (alone[0][term].1 + alone[1][term].1);
        assert!((value - mean).abs() < 1e-12, "{name}: {value}, {mean}");
    }
    for (frame, slope) in slopes.iter().enumerate() {
        let both = Tensor::cat(&[0, 1].map(|clip: usize| &alone_slopes[clip][frame] * 0.5), 0);
        assert!(slope.allclose(&both, 1e-9, 1e-15, false));
    }
}

#[test]
fn gradients_are_differences() {
    let made = made(4);
    for config in [
        LossConfig { flow: FlowSource::Exact, ..LossConfig::default() },
        LossConfig {
            flow: FlowSource::Exact,
            flow_confidence: Some(0.4),
            average_flow: true,
            pairs: Pairs::Adjacent,
            ..LossConfig::default()
        },
        LossConfig {
            logarithmic: true,
            squares_weight: 0.5,
            coarse_weight: 0.3,
            flow_weight: 0.0,
            ..LossConfig::default()
        },
    ] {
        let losses = losses(&config);
        let worst = worst_slope(&made.outputs, |outputs| losses.clip(&made.clip(outputs)).unwrap().total);
        assert!(worst < 1e-6, "{config:?}: {worst:e}");
    }
}

#[test]
fn motion_is_searched_between_the_references() {
    let mut made = made(3);
    for source in [FlowSource::SingleLevel, FlowSource::Hierarchical] {
        let flow = |made: &Made, flow: FlowSource| {
            let config = LossConfig { flow, ..LossConfig::default() };
            value(&losses(&config).clip(&made.clip(&made.outputs)).unwrap().flow)
        };
        let found = flow(&made, source);
        let search = source.search().unwrap();
        for i in 1..3 {
            made.motion[i] = search.motion(&made.references[i], &made.references[i - 1]);
        }
        assert_eq!(found, flow(&made, FlowSource::Exact));
    }
}

#[test]
fn parts_of_a_clip_add_up_with_their_gradients() {
    let made = made(5);
    let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
    let leaves = || made.outputs.iter().map(|y| y.copy().set_requires_grad(true)).collect::<Vec<_>>();
    let (whole, parts) = (leaves(), leaves());
    let total = losses.clip(&made.clip(&whole)).unwrap().total;
    total.backward();
    let mut sum = 0.0;
    for frames in [0..2, 2..4, 4..5] {
        let part = losses.frames(&made.clip(&parts[..frames.end]), frames.clone(), 5);
        // The whole clip has more references than outputs.
        assert!(part.is_err() || frames.end == 5);
        let clip = Clip {
            outputs: &parts[..frames.end],
            references: &made.references[..frames.end],
            motion: Some(&made.motion),
        };
        let part = losses.frames(&clip, frames, 5).unwrap().total;
        part.backward();
        sum += value(&part);
    }
    assert!((sum - value(&total)).abs() < 1e-12);
    for (a, b) in whole.iter().zip(&parts) {
        assert!(a.grad().allclose(&b.grad(), 1e-12, 1e-14, false));
    }
}

#[test]
fn what_is_wrong_is_said_with_how_to_mend_it() {
    let made = made(3);
    let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
    let without = Clip { motion: None, ..made.clip(&made.outputs) };
    let message = losses.clip(&without).unwrap_err().to_string();
    assert!(message.contains("motion of frame 1 is missing; give it"), "{message}");
    let none = Clip { outputs: &[], references: &[], motion: None };
    assert!(losses.clip(&none).is_err());
    let other = [pictures([2, 12, 15], 0.0, EXACT), made.outputs[1].copy(), made.outputs[2].copy()];
    let message = losses.clip(&made.clip(&other)).unwrap_err().to_string();
    assert!(message.contains("cannot be compared"), "{message}");
}

#[test]
fn nothing_is_differentiated_where_nothing_is_asked_for() {
    let made = made(3);
    let losses = losses(&LossConfig { flow: FlowSource::Exact, ..LossConfig::default() });
    let plain = losses.clip(&made.clip(&made.outputs)).unwrap().total;
    assert!(!plain.requires_grad());
    let leaves: Vec<Tensor> = made.outputs.iter().map(|y| y.copy().set_requires_grad(true)).collect();
    let silent = tch::no_grad(|| losses.clip(&made.clip(&leaves)).unwrap().total);
    assert!(!silent.requires_grad());
    assert!((value(&silent) - value(&plain)).abs() < 1e-15);
}

#[test]
fn configurations_survive_files() {
    let config = LossConfig { flow_confidence: Some(0.1), warm_up: WarmUp::None, ..LossConfig::default() };
    let text = toml::to_string(&config).unwrap();
    assert_eq!(toml::from_str::<LossConfig>(&text).unwrap(), config);
    assert_eq!(toml::from_str::<LossConfig>("").unwrap(), LossConfig::default());
    assert!(toml::from_str::<LossConfig>("colour = 3").is_err());
}
