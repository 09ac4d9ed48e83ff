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
//!
//! This page goes on from there step by step: your own data, sparse frames, networks, graphics processors, errors. Four
//! examples can be copied: [`render_frame`], [`custom_volume`], [`reconstruct_sparse`] and [`turntable`]. The [guide] has
//! more about each step.
//!
//! # First picture
//!
//! [`open_volume`] makes or reads a volume. [`Pipeline::new`] prepares it: bricks, macrocells, tables. That takes a moment,
//! and is done once. [`Pipeline::render`] then renders frame after frame. Every setting that is left out has a default: the
//! camera shows the whole volume, and colours follow the histogram.
//!
//! A frame holds RGBA as `f32`, row by row from the top left. Colours are display values from 0 to 1 (sRGB).
//! `fovolnet::io::image::write_png` writes it to a file. [`core::Frame::to_rgba8`] gives bytes for a texture.
//!
//! [`Pipeline::change`] takes new settings and keeps everything that old and new ones share. A new colour costs less than a
//! new pipeline.
//!
//! # Your own data
//!
//! Files are opened by [`open_volume`]: DICOM, raw voxels, NRRD, NIfTI, MetaImage, VTK, TIFF, folders of pictures. [`VolumeSettings`]
//! says what a file leaves out, such as the size of raw voxels. [`OpenVolume::notes`] says what was assumed.
//!
//! Voxels in memory become a [`core::Volume`]. They are stored x fastest, then y, then z:
//!
//! ```
//! use fovolnet::OpenVolume;
//! use fovolnet::core::{Grid, Volume};
//!
//! // 4 × 3 × 2 voxels; slices are twice as far apart as pixels.
//! let grid = Grid::new([4, 3, 2], [1.0, 1.0, 2.0])?;
//! let values: Vec<u16> = (0..24).collect();
//! let volume = OpenVolume::from(Volume::from_values(grid, values)?);
//! assert_eq!(volume.volume.value([1, 2, 0]), 9.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`core::Volume::new`] takes bytes of any of eleven types without a copy, for example a memory map.
//! [`core::Volume::with_range`] chooses which values the transfer function spans. The example [`custom_volume`] colours and
//! renders such a volume.
//!
//! # Sparse frames
//!
//! By default every pixel is marched. With [`Sampling::Compact`] only some are, which is where the speed comes from. Two
//! numbers say how many: P_b, the share of pixels everywhere, and σ, the width of the fovea around the gaze. [`RenderedFrame`] has the sparse frame, the mask, the reconstructed frame, and the
//! times of all stages. [`Pipeline::reference`] marches every pixel, to compare with.
//!
//! [`Viewpoint`] and [`Pipeline::render_from`] replace camera and gaze frame by frame, for a viewer or an eye tracker. The
//! example [`turntable`] makes a clip.
//!
//! # Networks
//!
//! Frames are reconstructed by a small recurrent network, whose weights come with the crate. [`Reconstruction`] lists the
//! other methods. The network remembers earlier frames: render them in order, and call [`Pipeline::reset`] after a cut.
//!
//! A [`Reconstructor`] does this step alone, for sparse frames of any renderer. Sampled pixels have alpha 1, all others are
//! transparent black. [`MotionFinder`] finds where each pixel was in the last frame. The example [`reconstruct_sparse`]
//! measures the result.
//!
//! # Graphics processors
//!
//! [`SpeedSettings`] choose the [`Device`], and the number of threads on a processor. The default is a graphics processor if
//! there is one, else the CPU. Both give the same picture within rounding. `Pipeline::on` renders on a device that your
//! program has already opened with wgpu, and `Pipeline::display_from` leaves pictures there.
//!
//! # Errors
//!
//! Every [`Error`] is one line that says what is wrong, where, and how to mend it. [`one_line`] joins it with its causes and
//! makes it safe for a terminal. Bad input never panics. Work that will not fit into memory is refused before it begins.
//! [`Error::is_of_gpu`] tells whether the CPU may still work. [`Pipeline::notes`] lists what was assumed or left out.
//!
//! # Cargo features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `files` | yes | volume files, pictures, sessions, XML transfer functions, weights of PyTorch |
//! | `dicom` | yes | volumes in DICOM |
//! | `hdf5` | yes | volumes in HDF5 and NetCDF |
//! | `zarr` | yes | volumes in Zarr and OME-Zarr; needs a C compiler |
//! | `jpeg-ls` | no | JPEG-LS in DICOM; needs a C++ compiler and CMake |
//! | `video` | yes | clips: Y4M, and others through an installed ffmpeg |
//! | `procedural` | yes | volumes that the program makes, such as `head` |
//! | `gpu` | yes | graphics processors, by wgpu |
//! | `download` | no | published volumes; needs a C compiler |
//! | `clap` | no | settings as flags of a command line |
//! | `noise-statistics` | no | tests of blue noise |
//!
//! Without defaults there are fewer than 60 packages and no C compiler. The example [`embedder`] is such a program.
//!
//! [guide]: https://github.com/fovolnet/fovolnet/blob/main/docs/guide/src/SUMMARY.md
//! [`render_frame`]: https://github.com/fovolnet/fovolnet/blob/main/crates/fovolnet/examples/render_frame.rs
//! [`custom_volume`]: https://github.com/fovolnet/fovolnet/blob/main/crates/fovolnet/examples/custom_volume.rs
//! [`reconstruct_sparse`]: https://github.com/fovolnet/fovolnet/blob/main/crates/fovolnet/examples/reconstruct_sparse.rs
//! [`turntable`]: https://github.com/fovolnet/fovolnet/blob/main/crates/fovolnet/examples/turntable.rs
//! [`embedder`]: https://github.com/fovolnet/fovolnet/blob/main/examples/embedder/src/main.rs

mod error;
pub mod guide;
mod motion;
mod pipeline;
mod planner;
pub mod presets;
mod reconstruct;
#[cfg(feature = "files")]
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
pub use fovol_simd as simd;
pub use motion::{Depths, Filled, MotionFinder, REMEMBERED, motion, motion_of_depths};
#[cfg(feature = "gpu")]
pub use pipeline::{DeviceFrame, DoneFrame};
pub use pipeline::{
    FrameGuide, FrameReport, MeanReport, PiecedPicture, Pipeline, Rays, RenderReport, RenderedFrame, Timings,
    Viewpoint, camera_path,
};
pub use planner::{Candidate, FramePlan, Freedom, Limit, MadeFrame, PlannedFrames, Planner, Shown, Way};
#[cfg(feature = "files")]
pub use planner::{Engine, FrameMaker, PlannedPipeline, Wanted};
#[cfg(feature = "gpu")]
pub use reconstruct::DeviceReconstructor;
pub use reconstruct::{Reconstructor, Seen};
#[cfg(feature = "files")]
pub use session::Session;
pub use settings::{
    CameraChoice, ChannelChoice, Choice, ComponentChoice, CropBox, Density, GazeChoice, Guide, LayerChoice,
    Mode, NamedView, NanColour, Orientation, PathChoice, Quality, RandomWeights, Reconstruction,
    RenderOverrides, RenderSettings, Rgb, Sampling, ShadowRays, SpeedSettings, StillCamera, TimeChoice,
    TransferChoice, TransferRange, ValueScale, VolumeSettings, WeightsChoice, parse, path_text,
};
pub use system::{Device, Machine, OpenDevice, keep_freed_memory, lower_thread_priority, signals};
pub use volume::{
    CroppedVolume, OpenLayer, OpenVolume, TimeClip, Visibility, WorldBox, open_single_volume, open_volume,
    scene,
};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
