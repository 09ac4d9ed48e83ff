//! The words of FoVolNet.
//!
//! Every other crate speaks in these types: what is looked at ([`Volume`], [`TransferFunction`],
//! [`Light`], [`Scene`]), from where ([`Camera`], [`CameraPath`]), which pixels are computed
//! ([`Fovea`], [`SampleMask`], [`SampleList`]) and what comes out ([`Frame`]).
//! There is no rendering here. [`input`] is how all of them open the files that they read, [`memory`] how
//! they ask for much memory, [`awake`] how they keep their threads at work.
//!
//! # World space
//! The box of a volume has the extent dims × spacing, is centred on the origin and scaled so that
//! its longest side is 1. `+y` is up. Where a volume stands in patient space, its box is turned
//! so that +x is the patient's left, +y superior and +z anterior; see [`Placement`].

mod awake;
mod camera;
mod camera_path;
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
mod transfer_function;
mod volume;
mod voxel;

pub use awake::awake;
pub use camera::{Camera, Ray, RayBasis};
pub use camera_path::{CameraPath, Keyframe};
pub use clip_box::ClipBox;
pub use contents::Contents;
pub use fovea::Fovea;
pub use frame::{Frame, FrameSize, MAX_FRAME_SIDE};
pub use gaze::GazePath;
pub use grid::{Grid, MAX_DIM};
pub use half::f16;
pub use light::Light;
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

/// What can be wrong with a word.
///
/// Each message says what is wrong, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A grid, frame or other extent that is empty or absurdly large.
    #[error("{what} is {found}, expected {expected}")]
    Extent {
        /// What was measured.
        what: String,
        /// The value found.
        found: String,
        /// The values that would do.
        expected: String,
    },
    /// A number that is not finite or lies outside its interval.
    #[error("{name} is {value}, expected {expected}")]
    Value {
        /// The name of the parameter.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The values that would do.
        expected: &'static str,
    },
    /// Fewer bytes than the dimensions and the type need.
    #[error(
        "the volume needs {needed} bytes for its dimensions and type, only {found} are there; check dims and dtype"
    )]
    TooFewBytes {
        /// Bytes that dims × components × type need.
        needed: u64,
        /// Bytes present.
        found: u64,
    },
    /// A transfer function that cannot be evaluated.
    #[error("transfer function: {0}")]
    TransferFunction(String),
    /// A camera path or keyframe that cannot be followed.
    #[error("camera path: {0}")]
    CameraPath(String),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] memory::Shortage),
}

/// The result of the operations of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// `value`, if it is finite and `ok` says so.
pub(crate) fn checked(name: &'static str, value: f64, expected: &'static str, ok: bool) -> Result<f64> {
    if value.is_finite() && ok { Ok(value) } else { Err(Error::Value { name, value, expected }) }
}
