use crate::Result;
use crate::error::same_size;
use crate::planes::display;
use fovol_core::Frame;
use rayon::prelude::*;

/// PSNR of equal pictures, in decibels, where the logarithm would be infinite. Higher values are meaningless.
pub const MAX_PSNR: f64 = 100.0;

/// Mean squared error over all pixels and RGB channels, 0…1.
///
/// # Errors
/// Frames that differ in size.
pub fn mse(reference: &Frame, test: &Frame) -> Result<f64> {
    let size = same_size(reference, test)?;
    let row = size.width as usize;
    let rows = reference.pixels().par_chunks(row).zip(test.pixels().par_chunks(row));
    let sums: Vec<f64> = rows
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| squared_distance(display(*a), display(*b))).sum())
        .collect();
    // Row sums are added in order, so that the result does not depend on the number of threads.
    Ok(sums.iter().sum::<f64>() / (3 * size.pixels()) as f64)
}

/// PSNR for a peak of 1: 10 · log₁₀(1 / `mse`) in decibels, at most [`MAX_PSNR`].
///
/// The PSNR of a clip uses the mean of its frames' errors.
pub fn psnr_of_mse(mse: f64) -> f64 {
    (-10.0 * mse.log10()).min(MAX_PSNR)
}

/// Peak signal-to-noise ratio in decibels, at most [`MAX_PSNR`].
///
/// # Errors
/// Frames that differ in size.
pub fn psnr(reference: &Frame, test: &Frame) -> Result<f64> {
    mse(reference, test).map(psnr_of_mse)
}

pub(crate) fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use fovol_core::FrameSize;

    fn filled(size: [u32; 2], value: [f32; 4]) -> Frame {
        let mut frame = Frame::new(FrameSize::try_from(size).unwrap());
        frame.fill(value);
        frame
    }

    #[test]
    fn equal_frames_reach_the_cap() {
        let frame = filled([5, 3], [0.3, 0.2, 0.1, 1.0]);
        assert_eq!(psnr(&frame, &frame), Ok(MAX_PSNR));
        assert_eq!(psnr_of_mse(1e-12), MAX_PSNR);
    }

    #[test]
    fn values_are_clamped_and_alpha_is_ignored() {
        let a = filled([4, 4], [2.0, -1.0, f32::NAN, 0.0]);
        let b = filled([4, 4], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(mse(&a, &b), Ok(0.0));
        let half = filled([4, 4], [0.5, 0.0, 0.0, 1.0]);
        assert_eq!(mse(&a, &half), Ok(0.25 / 3.0));
    }

    #[test]
    fn sizes_must_agree() {
        let (a, b) = (filled([4, 4], [0.0; 4]), filled([4, 5], [0.0; 4]));
        let error = mse(&a, &b).unwrap_err();
        assert_eq!(error, Error::SizesDiffer { reference: a.size(), test: b.size() });
        assert!(!error.to_string().contains('\n'));
    }
}
