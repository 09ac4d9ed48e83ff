//! Basic types of FoVolNet, used by every other crate.
//!
//! They describe the scene ([`Volume`], [`TransferFunction`], [`Light`], [`Scene`]), the view ([`Camera`],
//! [`CameraPath`]), the sampled pixels ([`Fovea`], [`SampleMask`], [`SampleList`]) and the result ([`Frame`]). There
//! is no rendering here. [`input`] opens files for all crates, and [`keep_workers_spinning`] keeps worker threads spinning.
//! [`stop`] ends work before its time. [`unfinished`] knows every temporary file of the process.
//! [`memory`] asks for large blocks of memory and refuses work that will not fit.
//!
//! # World space
//! The box of a volume has the extent dims × spacing. It is centred on the origin and scaled such that its longest
//! side is 1. `+y` is up. Volumes with a patient position are rotated: +x is the patient's left, +y superior and +z
//! anterior; see [`Placement`].

mod camera;
mod camera_path;
mod child_process;
mod clip_box;
mod contents;
mod downsample;
mod fovea;
mod frame;
mod gaze;
mod grid;
pub mod input;
mod labels;
mod light;
mod long_work;
pub mod memory;
mod names;
mod outliers;
mod path_text;
mod placement;
mod region;
mod reprojection;
mod sample_list;
mod sample_mask;
mod scene;
mod statistics;
pub mod stop;
pub mod temporaries;
mod transfer_function;
pub mod unfinished;
mod volume;
mod voxel;
mod workers;

pub use camera::{Camera, Ray, RayBasis};
pub use camera_path::{CameraPath, Keyframe};
pub use child_process::ChildProcess;
pub use clip_box::ClipBox;
pub use contents::Contents;
pub use fovea::Fovea;
pub use frame::{Frame, FrameSize, MAX_FRAME_SIDE};
pub use gaze::GazePath;
pub use grid::{Grid, MAX_DIM};
pub use half::f16;
pub use light::Light;
pub use long_work::{LongWork, WorkProgress, listen_to_long_work};
pub use names::did_you_mean;
pub use outliers::Outlier;
pub use path_text::{path_of_text, shown_path, text_of_path};
pub use placement::{Placement, Space};
pub use region::Region;
pub use reprojection::Reprojection;
pub use sample_list::{Pixel, SampleList};
pub use sample_mask::SampleMask;
pub use scene::{Integration, Scene, Shading, ShadowMode, SurfaceShading};
pub use statistics::Statistics;
pub use transfer_function::{ControlPoint, TransferFunction};
pub use volume::{Rescale, Volume, VoxelBytes};
pub use voxel::{Dtype, Endian, Voxel};
pub use workers::keep_workers_spinning;

/// Errors of the basic types.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Grid, frame or other extent that is empty or absurdly large.
    #[error("{what} is {found}, expected {expected}")]
    Extent {
        /// The measured quantity.
        what: String,
        /// The value found.
        found: String,
        /// The accepted values.
        expected: String,
    },
    /// Number that is not finite or lies outside its interval.
    #[error("{name} is {value}, expected {expected}")]
    Value {
        /// Name of the parameter.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The accepted values.
        expected: &'static str,
    },
    /// Fewer bytes than dimensions and type need.
    #[error(
        "the volume needs {needed} bytes for its dimensions and type, only {found} are there; check dims and dtype"
    )]
    TooFewBytes {
        /// Bytes that dims × components × type need.
        needed: u64,
        /// Bytes present.
        found: u64,
    },
    /// Transfer function that cannot be evaluated.
    #[error("transfer function: {0}")]
    TransferFunction(String),
    /// Camera path or keyframe that cannot be followed.
    #[error("camera path: {0}")]
    CameraPath(String),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] memory::Shortage),
}

/// Result with the errors of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Returns `value` if it is finite and `ok`, else an [`Error::Value`].
pub(crate) fn checked(name: &'static str, value: f64, expected: &'static str, ok: bool) -> Result<f64> {
    if value.is_finite() && ok { Ok(value) } else { Err(Error::Value { name, value, expected }) }
}

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
