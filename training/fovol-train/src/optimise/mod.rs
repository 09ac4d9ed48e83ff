//! Optimisers, learning-rate schedule, gradient clipping and weight averaging.
//!
//! Parameters are pairs of a name and a tensor handle, as
//! [`Network::parameters`](crate::network::Network::parameters) returns them. State for an exact resumption consists
//! of named tensors, too.

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
