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
mod clip_planes;
mod contents;
mod downsample;
mod error;
mod found;
mod fovea;
mod frame;
mod gaze;
mod grid;
pub mod input;
mod interpolation;
mod labels;
mod layer;
mod light;
mod long_work;
pub mod memory;
mod names;
mod outliers;
mod path_text;
mod placement;
mod projection;
mod ray_mode;
mod region;
mod reprojection;
mod resample;
mod sample_list;
mod sample_mask;
mod scene;
mod sparse_frame;
mod statistics;
pub mod stop;
mod summary;
pub mod temporaries;
mod transfer_function;
pub mod unfinished;
mod volume;
mod voxel;
mod voxel_colours;
mod workers;

pub use camera::{Camera, Ray, RayBasis, RaysBeside};
pub use camera_path::{CameraPath, Keyframe};
pub use child_process::ChildProcess;
pub use clip_box::ClipBox;
pub use clip_planes::{ClipPlane, ClipPlanes};
pub use contents::{ChannelDisplay, Contents, Label};
pub use error::{Error, Result};
pub use fovea::Fovea;
pub use frame::{Frame, FrameSize, MAX_FRAME_SIDE};
pub use gaze::GazePath;
pub use grid::{Grid, MAX_DIM};
pub use half::f16;
pub use interpolation::Interpolation;
pub use layer::{Layer, MOST_VOLUMES, VoxelColours};
pub use light::Light;
pub use long_work::{LongWork, WorkProgress, listen_to_long_work};
pub use names::did_you_mean;
pub use path_text::{path_of_text, shown_path, text_of_path};
pub use placement::{Placement, Space};
pub use projection::Projection;
pub use ray_mode::RayMode;
pub use region::Region;
pub use reprojection::Reprojection;
pub use resample::Alignment;
pub use sample_list::{Pixel, SampleList};
pub use sample_mask::SampleMask;
pub use scene::{Integration, Scene, Shading, ShadowMode, SurfaceShading};
pub use sparse_frame::SparseFrame;
pub use summary::{Outlier, Statistics};
pub use transfer_function::{ControlPoint, GradientOpacity, TransferFunction};
pub use volume::{Rescale, Volume, VoxelBytes};
pub use voxel::{Dtype, Endian, Voxel};
pub use workers::keep_workers_spinning;

pub(crate) use error::checked;

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
