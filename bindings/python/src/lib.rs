//! The native part of the Python package: volumes, renderers, frames, reconstruction and metrics.
//!
//! `python/fovolnet` has what people use. This part takes arrays in C order and settings as JSON, with the names of the command
//! line's flags.

mod array_bytes;
mod array_facts;
mod buffer;
mod clip;
mod encoding;
mod errors;
mod frame;
mod interrupts;
mod metrics;
mod pictures;
mod planned;
mod programs;
mod reconstructor;
mod refinement;
mod renderer;
mod session;
mod settings;
mod volume;
mod weights;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::clip::Clip;
    #[pymodule_export]
    use crate::errors::FovolnetError;
    #[pymodule_export]
    use crate::frame::Frame;
    #[pymodule_export]
    use crate::metrics::{Jod, ms_ssim, psnr, ssim, tpsnr};
    #[pymodule_export]
    use crate::planned::FrameProducer;
    #[pymodule_export]
    use crate::programs::{run_command, run_viewer};
    #[pymodule_export]
    use crate::reconstructor::Reconstructor;
    #[pymodule_export]
    use crate::renderer::Renderer;
    #[pymodule_export]
    use crate::session::{read_session, write_session};
    #[pymodule_export]
    use crate::volume::Volume;
    #[pymodule_export]
    use crate::weights::{export_onnx, safetensors, weights};

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
