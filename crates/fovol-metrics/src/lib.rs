//! Image and video quality metrics.
//!
//! All metrics compare display values: RGB clamped to [0, 1], alpha ignored, peak 1. NaN counts as 0, as in files.
//! See docs/guide/src/internals/algorithm.md, section 8.

mod clip;
mod cvvdp;
mod error;
mod filter;
mod fvvdp;
mod ms_ssim;
mod planes;
mod psnr;
mod ssim;
mod tpsnr;
mod vdp;

pub use clip::{ClipQuality, ClipSummary, FrameQuality};
pub use cvvdp::ColorVideoVdp;
pub use error::{Error, Result};
pub use fvvdp::FovVideoVdp;
pub use ms_ssim::{MIN_SIDE as MS_SSIM_MIN_SIDE, ms_ssim};
pub use psnr::{MAX_PSNR, mse, psnr, psnr_of_mse};
pub use ssim::{SsimSettings, ssim};
pub use tpsnr::{temporal_mse, tpsnr};
pub use vdp::{Display, MAX_FPS, MIN_SIDE as FVVDP_MIN_SIDE, MIN_SIDE as CVVDP_MIN_SIDE};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
