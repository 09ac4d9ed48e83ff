//! Tests of optimiser, schedule and clipping against PyTorch. `tests/reference/training/make_ranger.py` made the
//! values and describes them.

use fovol_train::optimise::{Average, Cosine, Ranger, RangerConfig, clip_gradients, gradient_norm};
use tch::{Device, Kind, Tensor};

const SHAPES: [(&str, &[i64]); 5] = [
    ("wide.weight", &[3, 2, 3, 3]),
    ("wide.bias", &[3]),
    ("point.weight", &[5, 4, 1, 1]),
    ("matrix", &[4, 3]),
    ("one", &[1]),
];
const SCHEDULE: Cosine = Cosine { first: 0.05, last: 1e-8, epochs: 8 };

fn expected(name: &str) -> Tensor {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/optimise.safetensors");
    let tensors = Tensor::read_safetensors(path).unwrap();
    let (_, tensor) = tensors.into_iter().find(|(found, _)| found == name).unwrap();
    tensor.to_kind(Kind::Double)
}

/// Index of each element.
fn places(shape: &[i64]) -> Tensor {
    Tensor::arange(shape.iter().product::<i64>(), (Kind::Double, Device::Cpu)).view(shape)
}

fn initial(kind: Kind) -> Vec<(String, Tensor)> {
    let value = |n: usize, shape: &[i64]| (places(shape) * 1.3 + n as f64).sin() * 0.5;
    let leaf = |(n, (name, shape)): (usize, &(&str, &[i64]))| {
        (name.to_string(), value(n, shape).to_kind(kind).set_requires_grad(true))
    };
    SHAPES.iter().enumerate().map(leaf).collect()
}

/// Gives each parameter the gradient of step `t`.
fn set_gradients(parameters: &[(String, Tensor)], t: u32) {
    for (n, (_, parameter)) in parameters.iter().enumerate() {
        let t = f64::from(t);
        let wave = (places(&parameter.size()) * 0.7 + 1.9 * t + n as f64).sin();
        let gradient = parameter.detach() * 0.4 + wave * (1.0 + 0.5 * t.cos()) + 0.2;
        let mut parameter = parameter.shallow_clone();
        parameter.zero_grad();
        // The gradient of a product with respect to one factor is the other factor.
        (parameter * gradient).sum(Kind::Double).backward();
    }
}

fn rate(t: u32) -> f64 {
    SCHEDULE.rate((t - 1) / 3)
}

fn difference(a: &Tensor, b: &Tensor) -> f64 {
    (a.detach().to_kind(Kind::Double) - b.detach().to_kind(Kind::Double)).abs().max().double_value(&[])
}

#[test]
fn ranger_is_the_original_step_by_step() {
    for (case, centralise, orthogonal) in
        [("with_gc", true, 0.0), ("without_gc", false, 0.0), ("orthogonal", false, 2.0)]
    {
        // The values are rounded to f32. In f32, every step is rounded too.
        for (kind, tolerance) in [(Kind::Double, 6e-8), (Kind::Float, 2e-6)] {
            let parameters = initial(kind);
            let config = RangerConfig { centralise, orthogonal, ..RangerConfig::default() };
            let mut ranger = Ranger::new(&parameters, config);
            for t in 1..=30 {
                set_gradients(&parameters, t);
                ranger.step(rate(t));
                for (name, parameter) in &parameters {
                    let expected = expected(&format!("{case}.{name}")).get(i64::from(t) - 1);
                    let off = difference(parameter, &expected);
                    assert!(off <= tolerance, "{case} {kind:?} {name} step {t}: {off:.1e}");
                }
            }
        }
    }
}

#[test]
fn ranger_goes_on_exactly_where_it_was_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.safetensors");
    let whole = initial(Kind::Float);
    let mut ranger = Ranger::new(&whole, RangerConfig::default());
    for t in 1..=20 {
        set_gradients(&whole, t);
        ranger.step(rate(t));
    }
    let first = initial(Kind::Float);
    let mut ranger = Ranger::new(&first, RangerConfig::default());
    for t in 1..=9 {
        set_gradients(&first, t);
        ranger.step(rate(t));
    }
    Tensor::write_safetensors(&ranger.state(), &path).unwrap();
    let second: Vec<(String, Tensor)> =
        first.iter().map(|(name, p)| (name.clone(), p.detach().copy().set_requires_grad(true))).collect();
    let mut resumed = Ranger::new(&second, RangerConfig::default());
    resumed.restore(&Tensor::read_safetensors(&path).unwrap()).unwrap();
    for t in 10..=20 {
        set_gradients(&second, t);
        resumed.step(rate(t));
    }
    for ((name, a), (_, b)) in whole.iter().zip(&second) {
        assert_eq!(difference(a, b), 0.0, "{name}");
    }
}

#[test]
fn states_of_others_are_refused() {
    let parameters = initial(Kind::Float);
    let mut ranger = Ranger::new(&parameters, RangerConfig::default());
    let mut state = ranger.state();
    state.retain(|(name, _)| name != "matrix.slow");
    let error = ranger.restore(&state).unwrap_err().to_string();
    assert!(error.contains("`matrix.slow` is missing"), "{error}");
    state.push(("matrix.slow".into(), Tensor::zeros([3, 4], (Kind::Float, Device::Cpu))));
    let error = ranger.restore(&state).unwrap_err().to_string();
    assert!(error.contains("[3, 4], not [4, 3]") && !error.contains('\n'), "{error}");
    let mut average = Average::new(&parameters, 0.9);
    assert!(average.restore(&state).unwrap_err().to_string().contains("`wide.weight` is missing"));
}

#[test]
fn parameters_without_gradients_stay() {
    let parameters = initial(Kind::Float);
    let before: Vec<Tensor> = parameters.iter().map(|(_, p)| p.detach().copy()).collect();
    let mut ranger = Ranger::new(&parameters, RangerConfig::default());
    set_gradients(&parameters[..1], 1);
    ranger.step(0.1);
    assert!(difference(&parameters[0].1, &before[0]) > 0.0);
    assert!((1..5).all(|i| difference(&parameters[i].1, &before[i]) == 0.0));
    ranger.zero_gradients();
    assert_eq!(gradient_norm(&parameters), 0.0);
}

#[test]
fn the_schedule_is_that_of_pytorch() {
    let expected = expected("cosine");
    let schedule = Cosine { first: 1.25e-3, last: 1e-8, epochs: 120 };
    for epoch in 0..=120 {
        let expected = expected.double_value(&[i64::from(epoch)]);
        let found = schedule.rate(epoch);
        // PyTorch's recursive schedule accumulates rounding errors.
        assert!(
            (found - expected).abs() <= 1e-12 * 1.25e-3 + 1e-10 * expected,
            "{epoch}: {found} {expected}"
        );
    }
    assert_eq!((schedule.rate(0), schedule.rate(120), schedule.rate(500)), (1.25e-3, 1e-8, 1e-8));
    assert_eq!(Cosine { epochs: 0, ..schedule }.rate(0), 1e-8);
}

#[test]
fn clipping_is_that_of_pytorch() {
    let parameters = initial(Kind::Double);
    set_gradients(&parameters, 1);
    let norm = expected("clip.norm").double_value(&[0]);
    assert!((gradient_norm(&parameters) - norm).abs() < 1e-12 * norm);
    assert!((clip_gradients(&parameters, 2.5) - norm).abs() < 1e-12 * norm);
    for (name, parameter) in &parameters {
        assert!(difference(&parameter.grad(), &expected(&format!("clip.{name}"))) < 1e-12, "{name}");
    }
    let clipped: Vec<Tensor> = parameters.iter().map(|(_, p)| p.grad().copy()).collect();
    clip_gradients(&parameters, 2.6);
    assert!(parameters.iter().zip(&clipped).all(|((_, p), g)| difference(&p.grad(), g) == 0.0));
    let _ = parameters[0].1.grad().fill_(f64::NAN);
    assert!(clip_gradients(&parameters, 1.0).is_nan());
    assert_eq!(difference(&parameters[1].1.grad(), &clipped[1]), 0.0);
}

#[test]
fn averages_follow_and_change_places() {
    let parameters = initial(Kind::Double);
    let mut average = Average::new(&parameters, 0.9);
    let mut expected = parameters[0].1.detach().copy();
    for n in 1..=100 {
        tch::no_grad(|| {
            let _ = parameters[0].1.shallow_clone().g_add_scalar_(0.01 * f64::from(n));
        });
        let decay = (f64::from(1 + n) / f64::from(10 + n)).min(0.9);
        expected = expected * decay + parameters[0].1.detach() * (1.0 - decay);
        average.update();
    }
    let now = parameters[0].1.detach().copy();
    average.swap();
    assert!(difference(&parameters[0].1, &expected) < 1e-12);
    average.swap();
    assert_eq!(difference(&parameters[0].1, &now), 0.0);
    let mut other = Average::new(&initial(Kind::Double), 0.9);
    other.restore(&average.state()).unwrap();
    other.update();
    average.update();
    let means = |average: &Average| average.state().into_iter().map(|(_, mean)| mean).collect::<Vec<_>>();
    let other_parameters_differ = difference(&means(&average)[0], &means(&other)[0]);
    assert!(other_parameters_differ > 0.0);
    assert_eq!(difference(&means(&average)[1], &means(&other)[1]), 0.0);
}
