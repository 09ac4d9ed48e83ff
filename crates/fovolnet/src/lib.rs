//! Foveated sparse volume rendering with reconstruction.
//!
//! Rays are marched for a few per cent of the pixels, most densely where the eye looks. A network reconstructs the rest
//! of the frame. [`Pipeline`] does all of this, one frame after another. [`RenderSettings`] are the settings that
//! command-line flags and [`Session`] files share.
//!
//! ```
//! use fovolnet::{Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};
//!
//! let volume = open_volume("marschner-lobb", &VolumeSettings { dims: Some([24; 3]), ..Default::default() })?;
//! let settings = RenderSettings { size: Some("64x48".parse()?), ..Default::default() };
//! let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default())?;
//! let frame = pipeline.render(0)?;
//! assert!(frame.samples > 0 && frame.frame.pixels().iter().all(|p| p[3] == 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod camera_path;
mod choice;
mod clip;
mod device;
#[cfg(feature = "gpu")]
mod device_reconstructor;
mod error;
mod machine;
mod memory;
mod motion;
mod nan_colour;
mod open;
mod orientation;
pub mod parse;
mod pipeline;
pub mod presets;
mod priority;
mod rays;
mod reconstruction;
mod reconstructor;
mod report;
mod sampling;
mod scene;
#[cfg(feature = "files")]
mod session;
#[cfg(feature = "files")]
mod session_files;
mod settings;
pub mod signals;
mod toml_text;
mod transfer_range;
mod visibility;
mod window;
mod world_box;

pub use camera_path::{camera_path, path_text};
pub use choice::Choice;
pub use clip::Clip;
pub use device::{Device, OpenDevice};
#[cfg(feature = "gpu")]
pub use device_reconstructor::DeviceReconstructor;
#[cfg(feature = "clap")]
pub use error::usage_line;
pub use error::{Error, Result, one_line, printable, printable_line};
pub use fovol_core as core;
#[cfg(feature = "gpu")]
pub use fovol_gpu as gpu;
pub use fovol_io as io;
pub use fovol_metrics as metrics;
pub use fovol_net as net;
pub use fovol_render as render;
pub use machine::Machine;
pub use memory::keep_freed_memory;
pub use motion::{Depths, Filled, MotionFinder, REMEMBERED, Sparse, motion, motion_of_depths};
pub use nan_colour::NanColour;
pub use open::{OpenVolume, open_volume};
pub use orientation::{NamedView, Orientation};
#[cfg(feature = "gpu")]
pub use pipeline::{DeviceFrame, DoneFrame};
pub use pipeline::{Pipeline, RenderedFrame, Timings, Viewpoint};
pub use priority::lower_thread_priority;
pub use rays::Rays;
pub use reconstruction::Reconstruction;
pub use reconstructor::Reconstructor;
pub use report::{FrameReport, MeanReport, RenderReport};
pub use sampling::Sampling;
pub use scene::scene;
#[cfg(feature = "files")]
pub use session::Session;
pub use settings::{RandomWeights, RenderSettings, SpeedSettings, VolumeSettings};
pub use transfer_range::{TransferRange, ValueScale};
pub use visibility::Visibility;
pub use window::Seen;
pub use world_box::WorldBox;

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
