use super::orthogonal::orthogonal;
use super::saved::Saved;
use crate::Result;
use serde::{Deserialize, Serialize};
use tch::Tensor;

/// The settings of [`Ranger`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct RangerConfig {
    /// How much of the running mean of gradients is kept in a step, β₁.
    pub beta1: f64,
    /// How much of the running mean of their squares is kept, β₂.
    pub beta2: f64,
    /// What is added to the root of squares before dividing.
    pub epsilon: f64,
    /// By how much of the learning rate weights shrink in a step, apart from gradients.
    pub weight_decay: f64,
    /// Every how many steps slow weights follow, and fast ones go back to them.
    pub slow_steps: u32,
    /// How far slow weights follow: 1 is all the way.
    pub slow_share: f64,
    /// Steps are adaptive where the approximated length of the simple moving average is above this.
    pub rectify_above: f64,
    /// Whether gradients of weights are centred: what each output channel has in the mean is taken off.
    pub centralise: bool,
    /// How much longer than others the steps of convolutions of several pixels are, which are then equally long in all
    /// directions of their weights instead of adaptive; 0 for steps like the others.
    pub orthogonal: f64,
}

impl Default for RangerConfig {
    /// Those of version 20.4.11, with the weight decay of FoVolNet.
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

/// Ranger 20.4.11 (L. Wright 2020): RAdam (Liu et al. 2020) with decoupled weight decay, Lookahead (Zhang et al. 2019)
/// and gradient centralisation (Yong et al. 2020); ALGORITHMS §7. With `orthogonal`, Muon (Jordan et al. 2024) takes RAdam's
/// place for convolutions of several pixels.
#[derive(Debug)]
pub struct Ranger {
    config: RangerConfig,
    followers: Vec<Follower>,
}

/// A parameter, and what is kept of its past.
#[derive(Debug)]
struct Follower {
    name: String,
    parameter: Tensor,
    /// The running mean of gradients.
    mean: Tensor,
    /// The running mean of their squares.
    square: Tensor,
    /// The slow weights.
    slow: Tensor,
    /// Steps with a gradient so far.
    steps: i64,
}

impl Ranger {
    /// An optimiser of `parameters` as they are now.
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

    /// Its settings.
    pub fn config(&self) -> &RangerConfig {
        &self.config
    }

    /// Slow weights are what the parameters are now, which something else has changed.
    pub fn set_out(&mut self) {
        for follower in &mut self.followers {
            follower.slow.copy_(&follower.parameter.detach());
        }
    }

    /// Forgets the gradients of the last step.
    pub fn zero_gradients(&mut self) {
        self.followers.iter_mut().for_each(|follower| follower.parameter.zero_grad());
    }

    /// Follows the gradients by one step of the learning rate `rate`; parameters without a gradient stay.
    pub fn step(&mut self, rate: f64) {
        let config = &self.config;
        tch::no_grad(|| self.followers.iter_mut().for_each(|follower| follower.step(rate, config)));
    }

    /// What [`Self::restore`] needs to go on from here, with the parameters as they are now: copies named
    /// `PARAMETER.mean`, `.square`, `.slow` and `.steps`.
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

    /// Goes on from `state`; the parameters have to be those that it was taken with.
    ///
    /// # Errors
    /// A state of other parameters. Nothing has changed then.
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

    /// The step at a learning rate of 1, against the gradients.
    fn direction(&self, gradient: &Tensor, config: &RangerConfig) -> Tensor {
        let is_of_several_pixels = self.parameter.size().get(2).is_some_and(|&rows| rows > 1);
        if config.orthogonal > 0.0 && is_of_several_pixels {
            // Nesterov's: where the mean will be.
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

/// `gradient` less what it has in the mean over all but its first dimension; biases stay.
fn centralised(gradient: &Tensor) -> Tensor {
    let rest: Vec<i64> = (1..gradient.dim() as i64).collect();
    if rest.is_empty() {
        return gradient.shallow_clone();
    }
    gradient - gradient.mean_dim(rest, true, None)
}

/// By what the mean of gradients is multiplied in step number `step`, 1 being the first, and whether it is divided by
/// the root of their squares as well.
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
