//! Tests of a small training run: the loss falls, and a resumed run equals an uninterrupted one.

use fovol_net::Weights;
use fovol_net::weights::Storage;
use fovol_train::clips::ClipSet;
use fovol_train::network::{Spread, initial_weights};
use fovol_train::trainer::{Arrangement, Ended, TrainConfig, Trainer};
use fovolnet::OpenDevice;
use std::cell::Cell;
use std::path::Path;
use tch::Device;

const CONFIG: &str = r#"
seed = 3
steps = 60
batch = 1
frames = 4
side = 64
truncate = 2
rate = 1e-2
last-rate = 1e-5
clip-gradients = 10.0
average = 0.5
revive-every = 20
validate-every = 30

# One that has everything to learn: a filled picture to begin with leaves little in so few steps.
[network]
kind = "wnet"
encoder = [8, 12]
decoder = [8]
feedback = "output"
kernels = true
normalisation = "squared"
fold = true
mask = true
prefill = true
bypass = true
history = "centre"
reproject = true
flat = "around"
accumulate = 0.85

[clips]
folder = "clips"
volumes = ["head:32:1"]
held-out = ["head:32:9"]
count = 1
held-out-count = 1

[lesson]
base = [0.05, 0.05]
without-fovea = 1.0

[lesson.augment]
colours = 0.0
grey = 0.0
still = 0.0
padding = 0.0

[loss]
flow = "exact"

# For a run as short as this.
[optimiser]
beta1 = 0.8
beta2 = 0.9
epsilon = 1e-8
"#;

fn config(folder: &Path) -> TrainConfig {
    let path = folder.join("config.toml");
    std::fs::write(&path, CONFIG).unwrap();
    TrainConfig::read(&path).unwrap()
}

fn clips(folder: &Path, config: &TrainConfig) -> [ClipSet; 2] {
    for set in config.clips.sets(folder).unwrap() {
        assert!(set.make(&OpenDevice::Cpu, |_| true).unwrap().left_out.is_empty());
    }
    config.clips.open(folder).unwrap()
}

/// Losses of a run, from its log.
fn losses(run: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(run.join("log.jsonl")).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    lines.filter_map(|line| line["loss"]["total"].as_f64()).collect()
}

#[test]
fn the_loss_falls_and_an_interrupted_run_is_the_same_run() {
    tch::set_num_threads(1);
    let folder = tempfile::tempdir().unwrap();
    let config = config(folder.path());
    let [learned, judged] = clips(folder.path(), &config);
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));

    let mut trainer = Trainer::new(config.clone(), &whole, Device::Cpu, false).unwrap();
    let alone = Arrangement { side_by_side: 1, threads: 1 };
    // Timing steps must not change the weights.
    assert!(trainer.arrange(&learned, 2).unwrap().is_some());
    trainer.take(alone).unwrap();
    assert_eq!(trainer.run(&learned, &judged, None, &|| false).unwrap(), Ended::Complete);

    // Stopped after 15 steps and resumed by another trainer.
    let mut trainer = Trainer::new(config.clone(), &parts, Device::Cpu, false).unwrap();
    assert_eq!(trainer.arrange(&learned, 1).unwrap(), Some(alone));
    let asked = Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        asked.get() == 15
    };
    assert_eq!(trainer.run(&learned, &judged, None, &stop).unwrap(), Ended::Stopped);
    let mut trainer = Trainer::new(config, &parts, Device::Cpu, true).unwrap();
    assert_eq!(trainer.steps_done(), 15);
    assert_eq!(trainer.arrange(&learned, 2).unwrap(), Some(alone), "as before");
    trainer.run(&learned, &judged, None, &|| false).unwrap();

    let [one, two] = [&whole, &parts].map(|run| losses(run));
    assert_eq!(one.len(), 60);
    assert_eq!(one, two);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    assert!(mean(&one[40..]) < 0.8 * mean(&one[..10]), "{one:?}");

    let weights = [&whole, &parts].map(|run| Weights::read(&run.join("weights.safetensors")).unwrap());
    assert_eq!(weights[0].arrays(), weights[1].arrays());
    assert_eq!(weights[0].facts["steps"], "60");
    for name in ["loss.svg", "preview.png"] {
        assert!(std::fs::metadata(whole.join(name)).unwrap().len() > 1000, "{name}");
    }
}

#[test]
fn a_layer_that_died_learns_again() {
    tch::set_num_threads(1);
    let folder = tempfile::tempdir().unwrap();
    let mut config = config(folder.path());
    let [learned, judged] = clips(folder.path(), &config);
    let weights = initial_weights(&config.network.config(), Spread::He, 1).unwrap();
    let mut arrays = weights.arrays().clone();
    let bias = "decoder.0.conv1.bias";
    arrays.get_mut(bias).unwrap().values.fill(-100.0);
    let dead = folder.path().join("dead.safetensors");
    let bytes = Weights::new(weights.config, arrays).to_bytes(Storage::F32).unwrap();
    std::fs::write(&dead, bytes).unwrap();
    // Long enough for one Lookahead synchronisation, which must not restore the dead channels.
    assert!(config.optimiser.slow_steps < 8);
    (config.from, config.steps, config.average) = (Some(dead), 8, 0.0);
    let run = folder.path().join("run");
    let mut trainer = Trainer::new(config, &run, Device::Cpu, false).unwrap();
    trainer.run(&learned, &judged, None, &|| false).unwrap();
    let log = std::fs::read_to_string(run.join("log.jsonl")).unwrap();
    let first: serde_json::Value = serde_json::from_str(log.lines().next().unwrap()).unwrap();
    assert!(first["revived"].as_u64().unwrap() >= 8, "{first}");
    let after = Weights::read(&run.join("weights.safetensors")).unwrap();
    assert!(after.ranges["decoder.0.conv1"].iter().any(|&reach| reach > 0.1));
}

#[test]
fn memory_and_time_can_be_saved_without_another_result() {
    tch::set_num_threads(1);
    let folder = tempfile::tempdir().unwrap();
    let mut config = config(folder.path());
    (config.steps, config.batch, config.truncate) = (6, 3, 3);
    let [learned, judged] = clips(folder.path(), &config);
    let trained = |name: &str, config: TrainConfig, side_by_side: usize| {
        let run = folder.path().join(name);
        let mut trainer = Trainer::new(config, &run, Device::Cpu, false).unwrap();
        trainer.take(Arrangement { side_by_side, threads: 1 }).unwrap();
        trainer.run(&learned, &judged, None, &|| false).unwrap();
        (losses(&run), Weights::read(&run.join("weights.safetensors")).unwrap())
    };
    let (whole, weights) = trained("whole", config.clone(), 1);
    let parts = TrainConfig { at_once: Some(2), ..config.clone() };
    let again = TrainConfig { recompute: true, ..config.clone() };
    let both = TrainConfig { at_once: Some(1), recompute: true, ..config.clone() };
    let ways = [
        ("parts", parts.clone(), 1),
        ("again", again, 1),
        ("both", both, 1),
        ("two side by side", config.clone(), 2),
        ("three side by side", config.clone(), 3),
        ("more than there are", config, 4),
        ("two in parts", parts, 2),
    ];
    for (name, config, side_by_side) in ways {
        let (losses, other) = trained(name, config, side_by_side);
        assert!(whole.iter().zip(&losses).all(|(a, b)| (a - b).abs() < 1e-5), "{name}: {whole:?} {losses:?}");
        for (array, one) in weights.arrays() {
            let pairs = one.values.iter().zip(&other.arrays()[array].values);
            let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(most < 1e-4, "{name} {array}: {most}");
        }
    }
}

#[test]
fn every_configuration_that_comes_with_it_can_be_run() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs");
    let paths: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(paths.len() >= 5);
    for path in paths {
        let config = TrainConfig::read(&path).unwrap();
        let [learned, judged] = config.clips.sets(&folder).unwrap();
        assert_eq!([learned.len(), judged.len()], [config.clips.count, config.clips.held_out_count]);
        config.network.config().plan().unwrap();
    }
}

#[test]
fn what_is_wrong_with_a_configuration_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.toml");
    let wrong = [
        (CONFIG.replace("steps = 60", "steps = 0"), "`steps` is 0"),
        (CONFIG.replace("seed = 3", "sead = 3"), "sead"),
        (CONFIG.replace("base = [0.05, 0.05]", "base = [0.0, 0.1]"), "lesson.base"),
    ];
    for (text, expected) in wrong {
        std::fs::write(&path, text).unwrap();
        let error = TrainConfig::read(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let both = CONFIG.replace("held-out = [\"head:32:9\"]", "held-out = [\"head:32:1\"]");
    std::fs::write(&path, both).unwrap();
    let error = TrainConfig::read(&path).unwrap().clips.sets(folder.path()).unwrap_err();
    assert!(error.to_string().contains("leave it in one of them"));
}
