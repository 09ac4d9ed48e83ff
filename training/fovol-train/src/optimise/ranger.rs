use super::orthogonal::orthogonal;
use super::saved::Saved;
use crate::Result;
use serde::{Deserialize, Serialize};
use tch::Tensor;

/// Settings of [`Ranger`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct RangerConfig {
    /// Decay β₁ of the moving average of gradients.
    pub beta1: f64,
    /// Decay β₂ of the moving average of squared gradients.
    pub beta2: f64,
    /// Added to the root of the squares before division.
    pub epsilon: f64,
    /// Decoupled weight decay per step, as a multiple of the learning rate.
    pub weight_decay: f64,
    /// Steps between Lookahead synchronisations.
    pub slow_steps: u32,
    /// Fraction by which slow weights follow at a synchronisation; 1 is all the way.
    pub slow_share: f64,
    /// Steps are adaptive if the length of the approximated simple moving average exceeds this.
    pub rectify_above: f64,
    /// Whether gradients of weights are centralised: each output channel's mean is subtracted.
    pub centralise: bool,
    /// Factor of orthogonalised steps for convolutions of several pixels; 0 gives them adaptive steps like other
    /// parameters.
    pub orthogonal: f64,
}

impl Default for RangerConfig {
    /// Settings of version 20.4.11, with FoVolNet's weight decay.
    fn default() -> Self {
        Self {
            beta1: 0.95,
            beta2: 0.999,
            epsilon: 1e-5,
            weight_decay: 1e-2,
            slow_steps: 6,
            slow_share: 0.5,
            rectify_above: 5.0,
            centralise: true,
            orthogonal: 0.0,
        }
    }
}

/// Optimiser Ranger 20.4.11 (L. Wright 2020).
///
/// It combines RAdam (Liu et al. 2020) with decoupled weight decay, Lookahead (Zhang et al. 2019) and gradient
/// centralisation (Yong et al. 2020); see docs/guide/src/internals/algorithm.md, section 7.2. With `orthogonal`, Muon
/// (Jordan et al. 2024) replaces RAdam for convolutions of several pixels.
#[derive(Debug)]
pub struct Ranger {
    config: RangerConfig,
    followers: Vec<Follower>,
}

/// Parameter with its optimiser state.
#[derive(Debug)]
struct Follower {
    name: String,
    parameter: Tensor,
    /// Moving average of gradients.
    mean: Tensor,
    /// Moving average of squared gradients.
    square: Tensor,
    /// Slow weights of Lookahead.
    slow: Tensor,
    /// Number of steps with a gradient.
    steps: i64,
}

impl Ranger {
    /// Creates an optimiser of `parameters` at their current values.
    pub fn new(parameters: &[(String, Tensor)], config: RangerConfig) -> Self {
        let followers = parameters.iter().map(|(name, parameter)| Follower {
            name: name.clone(),
            parameter: parameter.shallow_clone(),
            mean: parameter.detach().zeros_like(),
            square: parameter.detach().zeros_like(),
            slow: parameter.detach().copy(),
            steps: 0,
        });
        Self { config, followers: followers.collect() }
    }

    /// The settings.
    pub fn config(&self) -> &RangerConfig {
        &self.config
    }

    /// Resets the slow weights to the current parameters, after something else has changed these.
    pub fn set_out(&mut self) {
        for follower in &mut self.followers {
            follower.slow.copy_(&follower.parameter.detach());
        }
    }

    /// Sets all gradients to zero.
    pub fn zero_gradients(&mut self) {
        self.followers.iter_mut().for_each(|follower| follower.parameter.zero_grad());
    }

    /// Takes one step with the learning rate `rate`. Parameters without a gradient stay unchanged.
    pub fn step(&mut self, rate: f64) {
        let config = &self.config;
        tch::no_grad(|| self.followers.iter_mut().for_each(|follower| follower.step(rate, config)));
    }

    /// Copies of the state for [`Self::restore`], named `PARAMETER.mean`, `.square`, `.slow` and `.steps`. The
    /// parameters are saved separately.
    pub fn state(&self) -> Vec<(String, Tensor)> {
        let of = |follower: &Follower| {
            let Follower { name, mean, square, slow, steps, .. } = follower;
            let arrays = [("mean", mean), ("square", square), ("slow", slow)];
            let arrays = arrays.map(|(part, tensor)| (format!("{name}.{part}"), tensor.copy()));
            let steps = (format!("{name}.steps"), Tensor::from_slice(&[*steps]));
            arrays.into_iter().chain([steps]).collect::<Vec<_>>()
        };
        self.followers.iter().flat_map(of).collect()
    }

    /// Restores `state`. The parameters must have the values they had when it was saved.
    ///
    /// # Errors
    /// A state of other parameters; nothing changes then.
    pub fn restore(&mut self, state: &[(String, Tensor)]) -> Result<()> {
        let saved = Saved::new(state);
        let restored = self.followers.iter().map(|follower| follower.restored(&saved));
        self.followers = restored.collect::<Result<_>>()?;
        Ok(())
    }
}

impl Follower {
    fn step(&mut self, rate: f64, config: &RangerConfig) {
        let gradient = self.parameter.grad();
        if !gradient.defined() {
            return;
        }
        let gradient = if config.centralise { centralised(&gradient) } else { gradient };
        self.steps += 1;
        self.square *= config.beta2;
        self.square += &gradient * &gradient * (1.0 - config.beta2);
        self.mean *= config.beta1;
        self.mean += &gradient * (1.0 - config.beta1);
        if config.weight_decay != 0.0 {
            self.parameter *= 1.0 - config.weight_decay * rate;
        }
        self.parameter -= self.direction(&gradient, config) * rate;
        if self.steps % i64::from(config.slow_steps.max(1)) == 0 {
            self.slow += (self.parameter.detach() - &self.slow) * config.slow_share;
            self.parameter.copy_(&self.slow);
        }
    }

    /// Update direction at a learning rate of 1; it is subtracted from the parameter.
    fn direction(&self, gradient: &Tensor, config: &RangerConfig) -> Tensor {
        let is_of_several_pixels = self.parameter.size().get(2).is_some_and(|&rows| rows > 1);
        if config.orthogonal > 0.0 && is_of_several_pixels {
            // Nesterov momentum: the average after the next step.
            let ahead = gradient * (1.0 - config.beta1) + &self.mean * config.beta1;
            return orthogonal(&ahead) * config.orthogonal;
        }
        match step_length(self.steps, config) {
            (length, true) => &self.mean / (self.square.sqrt() + config.epsilon) * length,
            (length, false) => &self.mean * length,
        }
    }

    fn restored(&self, saved: &Saved<'_>) -> Result<Self> {
        let like = self.parameter.detach();
        let tensor = |part: &str| {
            let found = saved.tensor(&format!("{}.{part}", self.name), &like.size())?;
            Ok::<_, crate::Error>(found.detach().to_device(like.device()).to_kind(like.kind()).copy())
        };
        Ok(Self {
            name: self.name.clone(),
            parameter: self.parameter.shallow_clone(),
            mean: tensor("mean")?,
            square: tensor("square")?,
            slow: tensor("slow")?,
            steps: saved.number(&format!("{}.steps", self.name))?,
        })
    }
}

/// Subtracts from `gradient` its mean over all but the first dimension. Biases stay unchanged.
fn centralised(gradient: &Tensor) -> Tensor {
    let rest: Vec<i64> = (1..gradient.dim() as i64).collect();
    if rest.is_empty() {
        return gradient.shallow_clone();
    }
    gradient - gradient.mean_dim(rest, true, None)
}

/// Factor of the averaged gradient in step `step`, counted from 1. The boolean tells whether the gradient is also
/// divided by the root of the squares.
fn step_length(step: i64, config: &RangerConfig) -> (f64, bool) {
    let RangerConfig { beta1, beta2, rectify_above, .. } = *config;
    let step = step as f64;
    let kept = beta2.powf(step);
    let limit = 2.0 / (1.0 - beta2) - 1.0;
    let length = limit - 2.0 * step * kept / (1.0 - kept);
    let unbiased = 1.0 / (1.0 - beta1.powf(step));
    if length <= rectify_above {
        return (unbiased, false);
    }
    let rectified = (length - 4.0) / (limit - 4.0) * (length - 2.0) / length * limit / (limit - 2.0);
    (((1.0 - kept) * rectified).sqrt() * unbiased, true)
}
