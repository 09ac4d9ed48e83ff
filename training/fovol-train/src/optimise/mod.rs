//! How weights follow gradients.
//!
//! Parameters are pairs of a name and a handle of the tensor itself, as
//! [`Network::parameters`](crate::network::Network::parameters) gives them. What has to be kept to go on exactly where
//! training was cut off comes as named tensors, too.
//!
//! ```
//! use fovol_train::optimise::{Cosine, Ranger, RangerConfig, clip_gradients};
//! use tch::{Device, Kind, Tensor};
//!
//! let x = Tensor::ones([3], (Kind::Float, Device::Cpu)).set_requires_grad(true);
//! let parameters = vec![("x".to_owned(), x)];
//! let mut ranger = Ranger::new(&parameters, RangerConfig::default());
//! let schedule = Cosine { first: 0.05, last: 1e-8, epochs: 400 };
//! for epoch in 0..400 {
//!     ranger.zero_gradients();
//!     parameters[0].1.square().sum(Kind::Float).backward();
//!     clip_gradients(&parameters, 10.0);
//!     ranger.step(schedule.rate(epoch));
//! }
//! assert!(parameters[0].1.abs().max().double_value(&[]) < 0.1);
//! ```

mod average;
mod clip;
mod cosine;
mod orthogonal;
mod ranger;
mod saved;

pub use average::Average;
pub use clip::{clip_gradients, gradient_norm};
pub use cosine::Cosine;
pub use ranger::{Ranger, RangerConfig};
