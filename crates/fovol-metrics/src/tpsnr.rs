use crate::error::same_size;
use crate::planes::display;
use crate::{Result, psnr_of_mse};
use fovol_core::Frame;
use rayon::prelude::*;

/// Mean squared error of temporal differences: mean of ((o_t − o_{t−1}) − (r_t − r_{t−1}))², 0…4.
///
/// `reference` and `test` are (previous, current) pairs.
///
/// # Errors
/// Frames that differ in size.
pub fn temporal_mse(reference: [&Frame; 2], test: [&Frame; 2]) -> Result<f64> {
    let size = same_size(reference[0], test[0])?;
    same_size(reference[0], reference[1])?;
    same_size(reference[1], test[1])?;
    let row_sum = |y: usize| -> f64 {
        let row = y * size.width as usize..(y + 1) * size.width as usize;
        let change = |pair: [&Frame; 2], i: usize| {
            let [before, now] = pair.map(|frame| display(frame.pixels()[i]));
            std::array::from_fn::<f64, 3, _>(|c| f64::from(now[c]) - f64::from(before[c]))
        };
        row.map(|i| {
            let (r, o) = (change(reference, i), change(test, i));
            (0..3).map(|c| (o[c] - r[c]).powi(2)).sum::<f64>()
        })
        .sum()
    };
    let sums: Vec<f64> = (0..size.height as usize).into_par_iter().map(row_sum).collect();
    Ok(sums.iter().sum::<f64>() / (3 * size.pixels()) as f64)
}

/// Temporal PSNR in decibels: PSNR of the frame differences for a peak of 1, at most [`MAX_PSNR`](crate::MAX_PSNR).
/// It measures flicker and ignores constant errors.
///
/// `reference` and `test` are (previous, current) pairs, so the first frame of a clip has none.
///
/// # Errors
/// Frames that differ in size.
pub fn tpsnr(reference: [&Frame; 2], test: [&Frame; 2]) -> Result<f64> {
    temporal_mse(reference, test).map(psnr_of_mse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    fn filled(value: f32) -> Frame {
        let mut frame = Frame::new(FrameSize::new(3, 2).unwrap());
        frame.fill([value, value, value, 1.0]);
        frame
    }

    #[test]
    fn a_constant_error_is_not_seen_but_flicker_is() {
        let (dark, light) = (filled(0.25), filled(0.5));
        assert_eq!(tpsnr([&dark, &dark], [&light, &light]), Ok(100.0));
        let flicker = tpsnr([&dark, &dark], [&dark, &light]).unwrap();
        assert!((flicker - psnr_of_mse(0.0625)).abs() < 1e-12);
    }

    #[test]
    fn sizes_must_agree() {
        let other = Frame::new(FrameSize::new(2, 2).unwrap());
        let frame = filled(0.0);
        assert!(tpsnr([&frame, &frame], [&frame, &other]).is_err());
        assert!(tpsnr([&other, &frame], [&other, &frame]).is_err());
    }
}
