//! C interface of the renderer. `include/fovolnet.h` is made from these sources by cbindgen.
//!
//! Objects have pending and committed parameters, like those of ANARI. Frames use committed ones.

#![expect(clippy::missing_safety_doc, reason = "the top of the header has the rules for all pointers")]

mod boundary;
mod camera;
mod cancel;
mod channels;
mod committed;
mod flags;
mod frame;
mod handles;
mod light;
mod opened;
mod pointers;
mod reconstructor;
mod render_flags;
mod renderer;
mod rotation;
mod status;
mod transfer_function;
mod version;
mod volume;
mod voxels;

pub use boundary::fovolnet_last_error;
pub use camera::*;
pub use cancel::fovolnet_cancel;
pub use channels::*;
pub use frame::*;
pub use light::*;
pub use reconstructor::*;
pub use renderer::*;
pub use status::*;
pub use transfer_function::*;
pub use version::*;
pub use volume::*;
pub use voxels::*;
