use crate::Result;
use crate::error::{at_least, same_size};
use crate::filter::Window;
use crate::planes::Plane;
use fovol_core::{Frame, stop};
use rayon::prelude::*;

/// Window and covariance of SSIM.
///
/// K = (0.01, 0.03) and the peak of 1 are fixed. SSIM is computed without padding for each RGB channel, then
/// averaged.
#[derive(Debug, Clone, PartialEq)]
pub struct SsimSettings {
    pub(crate) window: Window,
    /// n/(n − 1) for the unbiased covariance of n pixels, 1 for the population's.
    pub(crate) covariance_factor: f64,
}

/// (K₁·L)² and (K₂·L)², which keep the quotients stable in dark or flat areas.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Output rows per task. The window's overlap with the next task is computed twice.
const STRIP: usize = 48;

impl SsimSettings {
    /// Gaussian of σ = 1.5 over 11×11 pixels with population covariance: Wang et al., "Image quality assessment: from
    /// error visibility to structural similarity" (2004). Equals pytorch-msssim.
    pub fn gaussian() -> Self {
        Self { window: Window::gaussian(11, 1.5), covariance_factor: 1.0 }
    }

    /// Uniform window of 7×7 pixels with sample covariance: the defaults of scikit-image.
    pub fn uniform7() -> Self {
        Self { window: Window::uniform(7), covariance_factor: 49.0 / 48.0 }
    }

    /// Smallest width and height that can be measured, in pixels.
    pub fn min_side(&self) -> u32 {
        self.window.size() as u32
    }
}

impl Default for SsimSettings {
    fn default() -> Self {
        Self::gaussian()
    }
}

/// Mean structural similarity, −1…1; 1 for equal frames.
///
/// # Errors
/// Frames that differ in size or are smaller than the window.
pub fn ssim(reference: &Frame, test: &Frame, settings: &SsimSettings) -> Result<f64> {
    let size = same_size(reference, test)?;
    at_least("SSIM", settings.min_side(), size)?;
    let channels: Vec<f64> = (0..3)
        .into_par_iter()
        .map(|c| similarity(&Plane::channel(reference, c), &Plane::channel(test, c), settings).ssim)
        .collect();
    Ok(channels.iter().sum::<f64>() / 3.0)
}

/// Means over one channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Similarity {
    /// Luminance × contrast × structure.
    pub ssim: f64,
    /// Contrast × structure.
    pub structure: f64,
}

/// Similarity of two channels of equal size, at least as large as the window.
pub(crate) fn similarity(a: &Plane, b: &Plane, settings: &SsimSettings) -> Similarity {
    let columns = a.width + 1 - settings.window.size();
    let rows = a.height + 1 - settings.window.size();
    let strips: Vec<[f64; 2]> = (0..rows.div_ceil(STRIP))
        .into_par_iter()
        .map(|strip| {
            stop::point();
            strip_sums(a, b, strip * STRIP..rows.min((strip + 1) * STRIP), settings)
        })
        .collect();
    // Added in order, so that the result does not depend on the number of threads.
    let total = strips.iter().fold([0.0; 2], |t, s| [t[0] + s[0], t[1] + s[1]]);
    let count = (columns * rows) as f64;
    Similarity { ssim: total[0] / count, structure: total[1] / count }
}

/// Sums of (ssim, structure) over the output rows `rows`.
fn strip_sums(a: &Plane, b: &Plane, rows: std::ops::Range<usize>, settings: &SsimSettings) -> [f64; 2] {
    let window = &settings.window;
    let columns = a.width + 1 - window.size();
    let filtered = filtered_rows(a, b, rows.start..rows.end + window.size() - 1, window);
    let mut means: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; columns]);
    let mut sums = [0.0; 2];
    for y in 0..rows.len() {
        for (mean, rows) in means.iter_mut().zip(&filtered) {
            window.across_rows(&rows[y..y + window.size()], mean);
        }
        let row = row_sums(&means, settings.covariance_factor);
        sums = [sums[0] + row[0], sums[1] + row[1]];
    }
    sums
}

/// Rows `rows` of a, b, a² + b² and a·b, filtered along x.
///
/// Double precision, since variances are differences of nearly equal numbers and C₂ is small.
fn filtered_rows(a: &Plane, b: &Plane, rows: std::ops::Range<usize>, window: &Window) -> [Vec<Vec<f64>>; 4] {
    let columns = a.width + 1 - window.size();
    let mut source = vec![0.0; a.width];
    let moments: [fn(f64, f64) -> f64; 4] = [|a, _| a, |_, b| b, |a, b| a * a + b * b, |a, b| a * b];
    moments.map(|moment| {
        rows.clone()
            .map(|y| {
                for ((s, &a), &b) in source.iter_mut().zip(a.row(y)).zip(b.row(y)) {
                    *s = moment(f64::from(a), f64::from(b));
                }
                let mut out = vec![0.0; columns];
                window.along_row(&source, &mut out);
                out
            })
            .collect()
    })
}

/// Sums of (ssim, structure) along a row, from the local means of a, b, a² + b² and a·b.
fn row_sums(means: &[Vec<f64>; 4], covariance_factor: f64) -> [f64; 2] {
    let [a, b, squares, product] = means;
    let mut sums = [0.0; 2];
    for x in 0..a.len() {
        let (mean_product, mean_squares) = (a[x] * b[x], a[x] * a[x] + b[x] * b[x]);
        let variances = covariance_factor * (squares[x] - mean_squares);
        let covariance = covariance_factor * (product[x] - mean_product);
        let structure = (2.0 * covariance + C2) / (variances + C2);
        let luminance = (2.0 * mean_product + C1) / (mean_squares + C1);
        sums[0] += luminance * structure;
        sums[1] += structure;
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    #[test]
    fn frames_smaller_than_the_window_are_refused() {
        let frame = Frame::new(FrameSize::new(10, 40).unwrap());
        let error = ssim(&frame, &frame, &SsimSettings::gaussian()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "SSIM needs frames of at least 11x11 pixels, these are 10x40; use larger frames"
        );
        assert_eq!(ssim(&frame, &frame, &SsimSettings::uniform7()), Ok(1.0));
    }
}
