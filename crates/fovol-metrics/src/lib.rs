//! How close one picture or clip is to another.
//!
//! All measures compare display values: RGB clamped to [0, 1], alpha ignored, peak 1. A value that
//! is not a number counts as 0, as it does when a frame is written to a file.
//!
//! ```
//! use fovol_core::{Frame, FrameSize};
//! use fovol_metrics::{SsimSettings, psnr, ssim};
//!
//! let size = FrameSize::new(32, 32)?;
//! let (black, mut grey) = (Frame::new(size), Frame::new(size));
//! grey.fill([0.1, 0.1, 0.1, 1.0]);
//! assert!((psnr(&black, &grey)? - 20.0).abs() < 1e-5);
//! assert_eq!(ssim(&grey, &grey, &SsimSettings::gaussian())?, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clip;
mod error;
mod filter;
mod fvvdp;
mod ms_ssim;
mod planes;
mod psnr;
mod ssim;
mod tpsnr;

pub use clip::{ClipQuality, ClipSummary, FrameQuality};
pub use error::{Error, Result};
pub use fvvdp::{Display, FovVideoVdp, MAX_FPS, MIN_SIDE as FVVDP_MIN_SIDE};
pub use ms_ssim::{MIN_SIDE as MS_SSIM_MIN_SIDE, ms_ssim};
pub use psnr::{MAX_PSNR, mse, psnr, psnr_of_mse};
pub use ssim::{SsimSettings, ssim};
pub use tpsnr::{temporal_mse, tpsnr};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
