use crate::ms_ssim::ssim_and_ms_ssim;
use crate::{MS_SSIM_MIN_SIDE, Result, SsimSettings, mse, psnr_of_mse, ssim, temporal_mse};
use fovol_core::Frame;
use serde::Serialize;

/// Quality of one frame of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameQuality {
    /// PSNR in decibels, at most 100.
    pub psnr: f64,
    /// SSIM with the Gaussian window, −1…1; `None` for frames smaller than 11×11 pixels.
    pub ssim: Option<f64>,
    /// MS-SSIM, 0…1; `None` when not asked for, or for frames smaller than 161×161 pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_ssim: Option<f64>,
    /// Temporal PSNR in decibels, at most 100; `None` for the first frame.
    pub tpsnr: Option<f64>,
}

/// Quality of a whole clip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClipSummary {
    /// PSNR of the mean squared error over all frames, in decibels.
    pub psnr: f64,
    /// Mean SSIM over the frames.
    pub ssim: Option<f64>,
    /// Mean MS-SSIM over the frames.
    pub ms_ssim: Option<f64>,
    /// PSNR of the mean squared error of all frame differences, in decibels; `None` for one frame.
    pub tpsnr: Option<f64>,
}

/// Measures a clip frame by frame. Keeps only the previous frames and running means.
#[derive(Debug, Clone)]
pub struct ClipQuality {
    with_ms_ssim: bool,
    window: SsimSettings,
    previous: Option<[Frame; 2]>,
    mse: Mean,
    temporal_mse: Mean,
    ssim: Mean,
    ms_ssim: Mean,
}

impl ClipQuality {
    /// Measures all metrics.
    pub fn new() -> Self {
        Self {
            with_ms_ssim: true,
            window: SsimSettings::gaussian(),
            previous: None,
            mse: Mean::default(),
            temporal_mse: Mean::default(),
            ssim: Mean::default(),
            ms_ssim: Mean::default(),
        }
    }

    /// Leaves out MS-SSIM, which takes about as long as all other metrics together.
    #[must_use]
    pub fn without_ms_ssim(mut self) -> Self {
        self.with_ms_ssim = false;
        self
    }

    /// Measures the next frame.
    ///
    /// # Errors
    /// Frames that differ in size from each other or from earlier frames. The clip is then unchanged.
    pub fn push(&mut self, reference: &Frame, test: &Frame) -> Result<FrameQuality> {
        let error = mse(reference, test)?;
        let change = match &self.previous {
            Some([r, t]) => Some(temporal_mse([r, reference], [t, test])?),
            None => None,
        };
        let [ssim, ms_ssim] = self.structure(reference, test)?;
        self.mse.add(error);
        change.inspect(|&v| self.temporal_mse.add(v));
        ssim.inspect(|&v| self.ssim.add(v));
        ms_ssim.inspect(|&v| self.ms_ssim.add(v));
        self.previous = Some([reference.clone(), test.clone()]);
        Ok(FrameQuality { psnr: psnr_of_mse(error), ssim, ms_ssim, tpsnr: change.map(psnr_of_mse) })
    }

    /// Number of frames measured so far.
    pub fn frames(&self) -> usize {
        self.mse.count
    }

    /// Quality of all frames so far, or `None` before the first.
    pub fn summary(&self) -> Option<ClipSummary> {
        Some(ClipSummary {
            psnr: psnr_of_mse(self.mse.get()?),
            ssim: self.ssim.get(),
            ms_ssim: self.ms_ssim.get(),
            tpsnr: self.temporal_mse.get().map(psnr_of_mse),
        })
    }

    /// SSIM and MS-SSIM, if the frames are large enough.
    fn structure(&self, reference: &Frame, test: &Frame) -> Result<[Option<f64>; 2]> {
        let side = reference.size().width.min(reference.size().height);
        if self.with_ms_ssim && side >= MS_SSIM_MIN_SIDE {
            return Ok(ssim_and_ms_ssim(reference, test)?.map(Some));
        }
        let large_enough = side >= self.window.min_side();
        let ssim = large_enough.then(|| ssim(reference, test, &self.window)).transpose()?;
        Ok([ssim, None])
    }
}

impl Default for ClipQuality {
    fn default() -> Self {
        Self::new()
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn get(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    fn filled(side: u32, value: f32) -> Frame {
        let mut frame = Frame::new(FrameSize::new(side, side).unwrap());
        frame.fill([value, value, value, 1.0]);
        frame
    }

    #[test]
    fn a_clip_averages_errors_not_decibels() {
        let mut clip = ClipQuality::new();
        let black = filled(8, 0.0);
        assert!(clip.summary().is_none());
        clip.push(&black, &filled(8, 0.5)).unwrap();
        let second = clip.push(&black, &black).unwrap();
        assert_eq!(second.psnr, 100.0);
        let summary = clip.summary().unwrap();
        assert!((summary.psnr - psnr_of_mse(0.125)).abs() < 1e-12);
        assert!((summary.tpsnr.unwrap() - psnr_of_mse(0.25)).abs() < 1e-12);
        assert_eq!((summary.ssim, summary.ms_ssim), (None, None));
        assert_eq!(clip.frames(), 2);
    }

    #[test]
    fn another_size_is_an_error_that_leaves_the_clip_alone() {
        let mut clip = ClipQuality::new();
        clip.push(&filled(20, 0.0), &filled(20, 0.1)).unwrap();
        let before = clip.summary();
        assert!(clip.push(&filled(21, 0.0), &filled(21, 0.1)).is_err());
        assert_eq!((clip.frames(), clip.summary()), (1, before));
    }

    #[test]
    fn ms_ssim_is_there_for_large_frames_unless_declined() {
        let frame = filled(161, 0.5);
        let with = ClipQuality::new().push(&frame, &frame).unwrap();
        assert_eq!((with.ssim, with.ms_ssim), (Some(1.0), Some(1.0)));
        let without = ClipQuality::new().without_ms_ssim().push(&frame, &frame).unwrap();
        assert_eq!((without.ssim, without.ms_ssim), (Some(1.0), None));
    }
}
