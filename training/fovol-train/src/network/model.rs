use crate::Result;
use fovol_net::Weights;
use fovol_net::plan::{NetworkConfig, Plan};
use fovol_net::weights::Array;
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

/// Network with trainable weights: f32 leaves of autograd, with the names of the plan.
#[derive(Debug)]
pub struct Network {
    pub(super) plan: Plan,
    config: NetworkConfig,
    facts: BTreeMap<String, String>,
    pub(super) parameters: BTreeMap<String, Tensor>,
    pub(super) options: Options,
    pub(super) device: Device,
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

    /// Kind of parameters, pictures and states.
    pub(super) fn kind(&self) -> Kind {
        self.parameters.values().next().map_or(Kind::Float, Tensor::kind)
    }

    /// Rows and columns of the padded frame.
    pub(super) fn padded(&self, sides: [i64; 2]) -> [i64; 2] {
        let multiple = self.plan.multiple() as i64;
        sides.map(|side| (side + multiple - 1) / multiple * multiple)
    }

    pub(super) fn state_shapes(&self, [batch, height, width]: [i64; 3]) -> Vec<[i64; 4]> {
        let [height, width] = self.padded([height, width]);
        let tensors = self.plan.states().iter().map(|state| self.plan.tensor(state.previous));
        tensors.map(|t| [batch, t.channels as i64, height >> t.level, width >> t.level]).collect()
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
