//! Fine integration: extinction and colour are integrated between samples. docs/integration.md has the equations.

mod exponential;
mod kernel;
mod lit;
mod lookup;
mod march;
mod stretches;

pub use exponential::passing;
pub use kernel::{FineKernel, FineScratch};
pub use lookup::Points;
