use super::march_variant::Variant;
use super::strategy::MarchStrategy;
use fovol_gpu::{Choices, Gpu, Tuner};
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Chooses how threads share the work of marching, for every kind of frame apart: it plays every strategy in the first frames.
#[derive(Debug)]
pub struct MarchTuner {
    /// The device and the program, as in the keys of choices.
    device: String,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    tuners: HashMap<Tuned, Tuner<MarchStrategy>>,
    choices: Choices,
}

/// A kind of frame whose strategy is tuned: what the shader is specialised for, and about how many pixels frames have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Tuned {
    pub(super) variant: Variant,
    /// Logarithm of the number of pixels, base 2.
    pub(super) pixels: u32,
}

/// How a frame was marched, for [`super::Renderer::learn_march_time`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlayedMarch {
    pub(super) tuned: Tuned,
    pub(super) strategy: MarchStrategy,
}

impl MarchTuner {
    /// The tuner of the device of `gpu`, which knows `choices` from before.
    pub fn new(gpu: &Gpu, choices: Choices) -> Self {
        let info = gpu.info();
        let program = env!("CARGO_PKG_VERSION");
        let device = format!("{} {} {:?} {program}", info.name, info.driver_info, info.backend);
        let state = State { tuners: HashMap::new(), choices };
        Self { device: device.replace(['\t', '\n'], " "), state: Mutex::new(state) }
    }

    /// Whether frames of the device of `gpu` are tuned: it is a GPU, and has timestamps.
    pub fn helps(gpu: &Gpu) -> bool {
        !gpu.is_software() && gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// The strategy of the next frame.
    pub fn next(&self, tuned: Tuned) -> MarchStrategy {
        let State { tuners, choices } = &mut *self.state();
        let tuner = tuners.entry(tuned).or_insert_with(|| {
            let tuner = Tuner::new(MarchStrategy::candidates());
            let known = choices.get(&self.key(tuned)).and_then(|(name, ms)| Some((name.parse().ok()?, ms)));
            match known {
                Some((strategy, ms)) => tuner.beginning_with(strategy, ms),
                None => tuner,
            }
        });
        tuner.next()
    }

    /// Learns that a frame was marched in `ms` milliseconds.
    pub fn learn(&self, played: PlayedMarch, ms: f64) {
        let State { tuners, choices } = &mut *self.state();
        let Some(tuner) = tuners.get_mut(&played.tuned) else { return };
        if tuner.learn(played.strategy, ms)
            && let Some((strategy, ms)) = tuner.chosen()
        {
            choices.keep(&self.key(played.tuned), &strategy.to_string(), ms);
        }
    }

    fn key(&self, Tuned { variant, pixels }: Tuned) -> String {
        format!("march {} {variant} 2^{pixels}", self.device)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
