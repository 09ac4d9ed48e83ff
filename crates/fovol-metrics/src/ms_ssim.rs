use crate::error::{at_least, same_size};
use crate::planes::Plane;
use crate::ssim::similarity;
use crate::{Result, SsimSettings};
use fovol_core::Frame;
use rayon::prelude::*;

/// Smallest width and height that MS-SSIM can measure, in pixels: an 11-pixel window must fit after four halvings.
pub const MIN_SIDE: u32 = 161;

/// Exponents of the five scales, finest first: Wang et al., "Multiscale structural similarity for image quality
/// assessment" (2003).
const WEIGHTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];

/// Multi-scale structural similarity, 0…1; 1 for equal frames.
///
/// Five scales by 2×2 averages, each measured like [`SsimSettings::gaussian`]; negative terms count as 0. Results
/// equal those of pytorch-msssim, including its padding of odd sides.
///
/// # Errors
/// Frames that differ in size or have a side below [`MIN_SIDE`].
pub fn ms_ssim(reference: &Frame, test: &Frame) -> Result<f64> {
    ssim_and_ms_ssim(reference, test).map(|both| both[1])
}

/// MS-SSIM, and SSIM as a by-product of the finest scale; SSIM first.
pub(crate) fn ssim_and_ms_ssim(reference: &Frame, test: &Frame) -> Result<[f64; 2]> {
    let size = same_size(reference, test)?;
    at_least("MS-SSIM", MIN_SIDE, size)?;
    let channels: Vec<[f64; 2]> = (0..3)
        .into_par_iter()
        .map(|c| channel_scales(Plane::channel(reference, c), Plane::channel(test, c)))
        .collect();
    Ok([0, 1].map(|i| channels.iter().map(|c| c[i]).sum::<f64>() / 3.0))
}

fn channel_scales(mut a: Plane, mut b: Plane) -> [f64; 2] {
    let settings = SsimSettings::gaussian();
    let (mut finest, mut product) = (0.0, 1.0);
    for (scale, weight) in WEIGHTS.into_iter().enumerate() {
        if scale > 0 {
            (a, b) = (a.halved(), b.halved());
        }
        let found = similarity(&a, &b, &settings);
        if scale == 0 {
            finest = found.ssim;
        }
        // Luminance counts only at the coarsest scale.
        let term = if scale + 1 == WEIGHTS.len() { found.ssim } else { found.structure };
        product *= term.max(0.0).powf(weight);
    }
    [finest, product]
}
