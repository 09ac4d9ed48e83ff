//! Fine integration: what lies between samples is integrated, not skipped. docs/integration.md has the equations.

mod extinction;
mod march;

pub use extinction::ExtinctionTable;
