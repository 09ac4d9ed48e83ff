//! Foveated sparse volume rendering with reconstruction.
//!
//! Rays are marched for a few per cent of the pixels, most densely where the eye looks. A network reconstructs the rest
//! of the frame. [`Pipeline`] does all of this, one frame after another. [`RenderSettings`] hold everything that a picture
//! depends on besides the volume. [`RenderOverrides`] are the part of them that flags and [`Session`] files give.
//!
//! ```
//! use fovolnet::core::FrameSize;
//! use fovolnet::{Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};
//!
//! let volume = open_volume("marschner-lobb", &VolumeSettings { dims: Some([24; 3]), ..Default::default() })?;
//! let settings = RenderSettings { size: FrameSize::new(64, 48)?, ..Default::default() };
//! let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default())?;
//! let frame = pipeline.render(0)?;
//! assert!(frame.samples > 0 && frame.frame.pixels().iter().all(|p| p[3] == 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod motion;
mod pipeline;
pub mod presets;
mod reconstruct;
mod session;
mod settings;
mod system;
mod volume;

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
pub use motion::{Depths, Filled, MotionFinder, REMEMBERED, Sparse, motion, motion_of_depths};
#[cfg(feature = "gpu")]
pub use pipeline::{DeviceFrame, DoneFrame};
pub use pipeline::{
    FrameReport, MeanReport, Pipeline, Rays, RenderReport, RenderedFrame, Timings, Viewpoint, camera_path,
};
#[cfg(feature = "gpu")]
pub use reconstruct::DeviceReconstructor;
pub use reconstruct::{Reconstructor, Seen};
pub use session::Session;
pub use settings::{
    CameraChoice, Choice, CropBox, GazeChoice, NamedView, NanColour, Orientation, PathChoice, RandomWeights,
    Reconstruction, RenderOverrides, RenderSettings, Sampling, SpeedSettings, StillCamera, TransferChoice,
    TransferRange, ValueScale, VolumeSettings, WeightsChoice, parse, path_text,
};
pub use system::{Device, Machine, OpenDevice, keep_freed_memory, lower_thread_priority, signals};
pub use volume::{CroppedVolume, OpenVolume, Visibility, WorldBox, open_volume, scene};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
