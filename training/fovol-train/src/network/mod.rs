//! Networks under autograd: a [`Plan`] evaluated with libtorch.
//!
//! Parameter names, weight files and arithmetic are those of [`fovol_net::cpu`]; tests compare the two.
//!
//! ```
//! use fovol_net::plan::Named;
//! use fovol_train::network::{Inputs, Network, Options, Spread, initial_weights};
//! use tch::{Device, Kind, Tensor};
//!
//! let weights = initial_weights(&Named::DeepFoveaFvn.config(), Spread::Pytorch, 1)?;
//! let network = Network::new(&weights, Options::default(), Device::Cpu)?;
//! let sparse = Tensor::rand([1, 3, 20, 30], (Kind::Float, Device::Cpu));
//! let inputs = Inputs { colour: &sparse, mask: None, motion: None };
//! let state = network.initial_state([1, 20, 30]);
//! let (picture, _next) = network.forward(&inputs, state)?;
//! picture.mean(Kind::Float).backward();
//! assert!(network.parameters()[0].1.grad().defined());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod frame;
mod initialise;
pub(crate) mod layers;
mod quantise;

pub use initialise::{Spread, initial_weights};

use crate::{Error, Result};
use fovol_net::Weights;
use fovol_net::plan::{NetworkConfig, Plan};
use fovol_net::weights::Array;
use frame::Frame;
use std::collections::BTreeMap;
use tch::{Device, Kind, Tensor};

/// Computation options of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Whether 3×3 convolutions read, multiply and write bf16. Parameters, predicted kernels, pictures, states and
    /// sums over images stay f32.
    pub bf16: bool,
    /// Whether convolutions use channels-last memory layout.
    pub channels_last: bool,
    /// Fake quantisation (Jacob et al. 2018): 3×3 convolutions round inputs and weights to int8 values in the forward
    /// pass, and gradients pass unchanged.
    pub fake_quantised: bool,
}

/// Inputs of a network for one frame of a batch of clips.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// RGB in 0…1, 0 where unsampled: \[batch, 3, rows, columns\].
    pub colour: &'a Tensor,
    /// Sampling mask, 1 where sampled, else 0: \[batch, 1, rows, columns\]. Networks without a mask input ignore it.
    pub mask: Option<&'a Tensor>,
    /// Motion from each pixel to its position in the last frame, in pixels, x right, then y down: \[batch, 2, rows,
    /// columns\]. Networks without a motion input ignore it; for others `None` means no motion.
    pub motion: Option<&'a Tensor>,
}

/// Network with trainable weights: f32 leaves of autograd, with the names of the plan.
#[derive(Debug)]
pub struct Network {
    plan: Plan,
    config: NetworkConfig,
    facts: BTreeMap<String, String>,
    parameters: BTreeMap<String, Tensor>,
    options: Options,
    device: Device,
}

impl Network {
    /// Builds the network of `weights` on `device`.
    ///
    /// # Errors
    /// Weights that do not fit the configuration they come with.
    pub fn new(weights: &Weights, options: Options, device: Device) -> Result<Self> {
        let plan = weights.config.plan().map_err(fovol_net::Error::Config)?;
        weights.check(&plan)?;
        let leaf = |array: &Array| tensor(array).to_device(device).set_requires_grad(true);
        let parameters = weights.arrays().iter().map(|(name, array)| (name.clone(), leaf(array)));
        Ok(Self {
            parameters: parameters.collect(),
            config: weights.config.clone(),
            facts: weights.facts.clone(),
            plan,
            options,
            device,
        })
    }

    /// Converts all parameters to f64, for tests.
    #[must_use]
    pub fn into_double(mut self) -> Self {
        for parameter in self.parameters.values_mut() {
            *parameter = parameter.detach().to_kind(Kind::Double).set_requires_grad(true);
        }
        self
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The configuration.
    pub fn config(&self) -> &NetworkConfig {
        &self.config
    }

    /// The computation options.
    pub fn options(&self) -> Options {
        self.options
    }

    /// The device.
    pub fn device(&self) -> Device {
        self.device
    }

    /// Trainable parameters in the order of the plan: handles that share memory with the network.
    pub fn parameters(&self) -> Vec<(String, Tensor)> {
        let handle = |name: String| {
            let tensor = self.parameters[&name].shallow_clone();
            (name, tensor)
        };
        self.plan.parameters().into_iter().map(|parameter| handle(parameter.name)).collect()
    }

    /// Copy for another thread that shares the parameters' memory but has its own gradients.
    #[must_use]
    pub fn replica(&self) -> Self {
        let alike = self.parameters.iter().map(|(name, tensor)| {
            let own = tensor.detach().set_requires_grad(true);
            (name.clone(), own)
        });
        Self {
            parameters: alike.collect(),
            config: self.config.clone(),
            facts: self.facts.clone(),
            plan: self.plan.clone(),
            options: self.options,
            device: self.device,
        }
    }

    /// Sets all gradients to zero.
    pub fn zero_gradients(&mut self) {
        self.parameters.values_mut().for_each(Tensor::zero_grad);
    }

    /// Copies the current weights, for example to write them to a file.
    pub fn weights(&self) -> Weights {
        let arrays = self.parameters.iter().map(|(name, tensor)| (name.clone(), array(tensor)));
        let mut weights = Weights::new(self.config.clone(), arrays.collect());
        weights.facts.clone_from(&self.facts);
        weights
    }

    /// Copies `weights` into the parameters; existing handles stay valid.
    ///
    /// # Errors
    /// Weights of another network.
    pub fn load(&mut self, weights: &Weights) -> Result<()> {
        weights.check(&self.plan)?;
        self.facts.clone_from(&weights.facts);
        tch::no_grad(|| {
            for (name, parameter) in &mut self.parameters {
                parameter.copy_(&tensor(&weights.arrays()[name]));
            }
        });
        Ok(())
    }

    /// Initial state for clips of frames of \[batch, rows, columns\]: zeros, in the order of the plan's states. Each
    /// is \[batch, channels, rows, columns\] of the padded frame at its level.
    pub fn initial_state(&self, [batch, height, width]: [i64; 3]) -> Vec<Tensor> {
        let shapes = self.state_shapes([batch, height, width]);
        shapes.iter().map(|shape| Tensor::zeros(shape, (self.kind(), self.device))).collect()
    }

    /// Reconstructs the frame of `inputs`: the picture \[batch, 3, rows, columns\], and the state for the next frame.
    ///
    /// Pictures are cropped to the frame but not clamped to 0…1, so that gradients pass. The caller owns the state
    /// and detaches it where gradients should end.
    ///
    /// # Errors
    /// Inputs or a state of other shapes, or a missing mask.
    pub fn forward(&self, inputs: &Inputs<'_>, state: Vec<Tensor>) -> Result<(Tensor, Vec<Tensor>)> {
        let size = self.check(inputs, &state)?;
        let mut frame = Frame::new(self, inputs, state);
        for layer in self.plan.layers() {
            frame.run(layer);
        }
        let [_, height, width] = size;
        let picture = frame.exact(self.plan.output()).narrow(2, 0, height).narrow(3, 0, width);
        let next = self.plan.states().iter().map(|kept| frame.exact(kept.next));
        Ok((picture, next.collect()))
    }

    /// Kind of parameters, pictures and states.
    fn kind(&self) -> Kind {
        self.parameters.values().next().map_or(Kind::Float, Tensor::kind)
    }

    /// Rows and columns of the padded frame.
    fn padded(&self, sides: [i64; 2]) -> [i64; 2] {
        let multiple = self.plan.multiple() as i64;
        sides.map(|side| (side + multiple - 1) / multiple * multiple)
    }

    fn state_shapes(&self, [batch, height, width]: [i64; 3]) -> Vec<[i64; 4]> {
        let [height, width] = self.padded([height, width]);
        let tensors = self.plan.states().iter().map(|state| self.plan.tensor(state.previous));
        tensors.map(|t| [batch, t.channels as i64, height >> t.level, width >> t.level]).collect()
    }

    /// Checks `inputs` and `state`; returns batch, rows and columns.
    fn check(&self, inputs: &Inputs<'_>, state: &[Tensor]) -> Result<[i64; 3]> {
        let found = inputs.colour.size();
        let &[batch, 3, height, width] = found.as_slice() else {
            return Err(Error::Input(format!("colours are {found:?}; give [batch, 3, rows, columns]")));
        };
        if batch * height * width == 0 {
            return Err(Error::Input(format!("colours are {found:?}, which are no pixels; give some")));
        }
        if self.plan.inputs().mask.is_some() && inputs.mask.is_none() {
            return Err(Error::Input("this network needs the mask of the samples; give it".into()));
        }
        for (what, given, channels) in [("the mask", inputs.mask, 1), ("the motion", inputs.motion, 2)] {
            let expected = [batch, channels, height, width];
            if let Some(given) = given.filter(|given| given.size() != expected) {
                return Err(Error::Input(format!("{what} is {:?}; give {expected:?}", given.size())));
            }
        }
        let sizes: Vec<Vec<i64>> = state.iter().map(Tensor::size).collect();
        let expected = self.state_shapes([batch, height, width]);
        if sizes != expected {
            return Err(Error::Input(format!("the state is {sizes:?}, not {expected:?}; begin a new one")));
        }
        Ok([batch, height, width])
    }
}

/// Converts `array` to a tensor in f32.
fn tensor(array: &Array) -> Tensor {
    let shape: Vec<i64> = array.shape.iter().map(|&side| side as i64).collect();
    Tensor::from_slice(&array.values).view(shape.as_slice())
}

/// Copies the values of `tensor` as f32.
fn array(tensor: &Tensor) -> Array {
    let shape = tensor.size().iter().map(|&side| side as usize).collect();
    let flat = tensor.detach().to_device(Device::Cpu).to_kind(Kind::Float).contiguous().view([-1]);
    let mut values = vec![0.0; flat.numel()];
    flat.copy_data(&mut values, flat.numel());
    Array { shape, values }
}
