//! Fine integration: what lies between samples is integrated, not skipped. docs/integration.md has the equations.

mod exponential;
mod extinction;
mod kernel;
mod lit;
mod lookup;
mod march;
mod stretches;

pub use extinction::ExtinctionTable;
pub use kernel::{FineKernel, FineScratch};
pub use lookup::Points;
