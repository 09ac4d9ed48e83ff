use crate::{Machine, Timings};
use fovol_core::FrameSize;
use serde::Serialize;

/// The figures of one rendered frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameReport {
    /// Its number.
    pub index: u32,
    /// Pixels marched.
    pub samples: usize,
    /// Their share of the frame.
    pub density: f64,
    /// Pixels marched twice, where positions are drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_samples: Option<usize>,
    /// Milliseconds. Those of the first frame have the making of cached shadows in `march` and `total`.
    pub ms: Timings,
    /// PSNR against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// SSIM against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
}

/// Means over the frames of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct MeanReport {
    /// Pixels marched.
    pub samples: f64,
    /// Their share of the frame.
    pub density: f64,
    /// Milliseconds.
    pub ms: Timings,
    /// PSNR of the mean error against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Mean SSIM against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// PSNR of the mean error of frame differences against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tpsnr: Option<f64>,
}

/// What `render` reports as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderReport {
    /// The volume, as it was named.
    pub volume: String,
    /// Width and height.
    pub size: FrameSize,
    /// How pixels were chosen.
    pub sampling: String,
    /// How frames were filled.
    pub reconstruct: String,
    /// How rays added up what they passed: plain or fine.
    pub integration: String,
    /// How NaN looked: transparent, file, or red, green, blue and opacity.
    pub nan: String,
    /// Every frame.
    pub frames: Vec<FrameReport>,
    /// Their means.
    pub mean: MeanReport,
    /// The machine.
    pub machine: Machine,
}

impl MeanReport {
    /// The means of `frames`, without quality.
    pub fn of(frames: &[FrameReport]) -> Self {
        let n = frames.len().max(1) as f64;
        let parts: Vec<Timings> = frames.iter().map(|f| f.ms).collect();
        let mean = |of: &dyn Fn(&FrameReport) -> f64| frames.iter().map(of).sum::<f64>() / n;
        Self {
            samples: mean(&|f| f.samples as f64),
            density: mean(&|f| f.density),
            ms: Timings::reduced(&parts, |ms| ms.iter().sum::<f64>() / n),
            ..Self::default()
        }
    }
}
