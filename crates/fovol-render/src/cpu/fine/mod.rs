//! Fine integration: what lies between samples is integrated, not skipped. docs/integration.md has the equations.

mod exponential;
mod kernel;
mod lit;
mod lookup;
mod march;
mod stretches;

pub use kernel::{FineKernel, FineScratch};
pub use lookup::Points;
