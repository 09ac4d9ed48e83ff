use crate::{FramePlan, Machine, RenderedFrame, Timings};
use fovol_core::FrameSize;
use fovol_metrics::{ClipSummary, FrameQuality};
use serde::Serialize;

/// Figures of one rendered frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub index: u32,
    /// Number of marched pixels.
    pub samples: usize,
    /// Their fraction of the frame.
    pub density: f64,
    /// Number of pixels marched without shadow rays, for the guide.
    pub guide_samples: usize,
    /// Number of repeated pixels, if positions are drawn at random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_samples: Option<usize>,
    /// Times in milliseconds. Those of the first frame include the grid of cached shadows in `march` and `total`.
    pub ms: Timings,
    /// PSNR against the reference, in dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// SSIM against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// How a planner made the frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<FramePlan>,
}

/// Means over all frames of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct MeanReport {
    /// Number of marched pixels.
    pub samples: f64,
    /// Their fraction of the frame.
    pub density: f64,
    /// Number of pixels marched without shadow rays, for the guide.
    pub guide_samples: f64,
    /// Times in milliseconds.
    pub ms: Timings,
    /// PSNR of the mean error against the reference, in dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Mean SSIM against the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// PSNR of the mean error of differences between frames against the reference, in dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tpsnr: Option<f64>,
}

/// Report of `render`, written as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RenderReport {
    /// Name of the volume as the user gave it.
    pub volume: String,
    /// Frame size.
    pub size: FrameSize,
    /// Who decided how frames are made: fixed or auto. With auto, see the plan of each frame.
    pub quality: String,
    /// Milliseconds that a frame might take.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget_ms: Option<f64>,
    /// Method of choosing pixels, as asked for.
    pub sampling: String,
    /// Method of filling frames.
    pub reconstruct: String,
    /// Guide of the light ratio: none, quarter or full.
    pub guide: String,
    /// Integration along rays: plain or fine.
    pub integration: String,
    /// Appearance of NaN: transparent, file, or red, green, blue and opacity.
    pub nan: String,
    /// Figures of each frame.
    pub frames: Vec<FrameReport>,
    /// Means over all frames.
    pub mean: MeanReport,
    /// Machine that rendered.
    pub machine: Machine,
}

impl FrameReport {
    /// Figures of frame `index`, with its `quality` where there is a reference.
    pub fn of(index: u32, rendered: &RenderedFrame, quality: Option<&FrameQuality>) -> Self {
        Self {
            index,
            samples: rendered.samples,
            density: rendered.mask.density(),
            guide_samples: rendered.guide_samples,
            lost_samples: rendered.lost,
            ms: rendered.timings,
            psnr: quality.map(|q| q.psnr),
            ssim: quality.and_then(|q| q.ssim),
            plan: None,
        }
    }

    /// These figures, for a frame of `size` that was made as `plan` says.
    #[must_use]
    pub fn planned(self, plan: FramePlan, size: FrameSize) -> Self {
        // Smaller frames are enlarged: samples count against the pixels that are shown.
        let density = self.samples as f64 / size.pixels() as f64;
        Self { density, plan: Some(plan), ..self }
    }
}

impl MeanReport {
    /// Means of `frames`, and the `quality` of the clip where there is a reference.
    pub fn of(frames: &[FrameReport], quality: Option<&ClipSummary>) -> Self {
        let n = frames.len().max(1) as f64;
        let parts: Vec<Timings> = frames.iter().map(|f| f.ms).collect();
        let mean = |of: &dyn Fn(&FrameReport) -> f64| frames.iter().map(of).sum::<f64>() / n;
        Self {
            samples: mean(&|f| f.samples as f64),
            density: mean(&|f| f.density),
            guide_samples: mean(&|f| f.guide_samples as f64),
            ms: Timings::reduced(&parts, |ms| ms.iter().sum::<f64>() / n),
            psnr: quality.map(|q| q.psnr),
            ssim: quality.and_then(|q| q.ssim),
            tpsnr: quality.and_then(|q| q.tpsnr),
        }
    }
}
