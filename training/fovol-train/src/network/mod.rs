//! Networks under autograd: a [`Plan`](fovol_net::plan::Plan) evaluated with libtorch.
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

mod forward;
mod frame;
mod initialise;
mod inputs;
pub(crate) mod layers;
mod model;
mod quantise;

pub use initialise::{Spread, initial_weights};
pub use inputs::Inputs;
pub use model::{Network, Options};
