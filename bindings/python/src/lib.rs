//! The native part of the Python package: volumes, renderers, frames, reconstruction and metrics.
//!
//! `python/fovolnet` has what people use. This part takes arrays in C order and settings as JSON, with the names of the command
//! line's flags.

mod array_bytes;
mod array_facts;
mod buffer;
mod clip;
mod errors;
mod frame;
mod interrupts;
mod metrics;
mod pictures;
mod programs;
mod reconstructor;
mod renderer;
mod session;
mod settings;
mod volume;
mod weights;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("FovolnetError", module.py().get_type::<errors::FovolnetError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<volume::Volume>()?;
    module.add_class::<renderer::Renderer>()?;
    module.add_class::<frame::Frame>()?;
    module.add_class::<reconstructor::Reconstructor>()?;
    module.add_class::<clip::Clip>()?;
    metrics::add_to(module)?;
    programs::add_to(module)?;
    session::add_to(module)?;
    weights::add_to(module)
}
