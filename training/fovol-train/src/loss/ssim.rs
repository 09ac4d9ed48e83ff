//! Differentiable SSIM and MS-SSIM.
//!
//! For values in 0…1 they agree with `fovol_metrics::ssim` with its Gaussian window and with
//! `fovol_metrics::ms_ssim`. Values are not clamped here, so that outputs outside the range are penalised.

use super::pictures::{means, picture_shape};
use crate::network::layers::constant;
use crate::{Error, Result};
use tch::Tensor;

/// Side of the window, in pixels.
const WINDOW: i64 = 11;
/// Standard deviation of the window, in pixels.
const SIGMA: f64 = 1.5;
/// (K₁·L)² and (K₂·L)² with K = (0.01, 0.03) and a peak L = 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;
/// Exponents of the five scales, finest first: Wang et al., "Multiscale structural similarity for image quality
/// assessment" (2003).
const WEIGHTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];
/// Lower bound of the similarity of a scale. The powers of MS-SSIM have infinite gradients at 0.
const LEAST: f64 = 1e-4;

/// Mean structural similarity of two batches \[N, C, H, W\], per picture: \[N\] in −1…1, 1 for equal pictures.
///
/// Wang et al., "Image quality assessment: from error visibility to structural similarity" (2004): a Gaussian of σ =
/// 1.5 over 11×11 pixels without padding, population covariance, each channel separately.
///
/// # Errors
/// Pictures of different or invalid shapes, or with a side below 11 pixels.
pub fn ssim(output: &Tensor, reference: &Tensor) -> Result<Tensor> {
    check("SSIM", output, reference)?;
    Ok(means(&similarity(output, reference).whole))
}

/// Multi-scale structural similarity of two batches \[N, C, H, W\], per picture: \[N\] in 0…1, 1 for equal pictures.
///
/// Five scales by 2×2 averages; an odd side gets a line of zeros in front, as in pytorch-msssim. Smaller pictures use
/// as many scales as the window fits into, with weights rescaled to a sum of 1. Similarities of a scale below 10⁻⁴
/// count as 10⁻⁴ (in `fovol_metrics::ms_ssim`, those below 0 as 0).
///
/// # Errors
/// Pictures of different or invalid shapes, or with a side below 11 pixels.
pub fn ms_ssim(output: &Tensor, reference: &Tensor) -> Result<Tensor> {
    check("MS-SSIM", output, reference)?;
    let (mut output, mut reference) = (output.shallow_clone(), reference.shallow_clone());
    let weights = scale_weights(output.size()[2].min(output.size()[3]));
    let mut product: Option<Tensor> = None;
    for (scale, &weight) in weights.iter().enumerate() {
        if scale > 0 {
            (output, reference) = (halved(&output), halved(&reference));
        }
        let found = similarity(&output, &reference);
        // Luminance counts only at the coarsest scale.
        let term = if scale + 1 == weights.len() { found.whole } else { found.structure };
        let factor = term.clamp_min(LEAST).pow_tensor_scalar(weight);
        product = Some(product.map_or_else(|| factor.shallow_clone(), |product| product * &factor));
    }
    // There is always at least one scale.
    Ok(product.map_or_else(|| means(&output), |product| means(&product)))
}

/// Weights of the scales that the window fits into, for pictures whose smaller side is `side`.
fn scale_weights(side: i64) -> Vec<f64> {
    let halved = |side: &i64| Some((side + 1) / 2);
    let sides = std::iter::successors(Some(side), halved).take_while(|&side| side >= WINDOW);
    let scales = sides.take(WEIGHTS.len()).count();
    let kept = &WEIGHTS[..scales];
    // The five weights sum to 1.0001; pytorch-msssim does not rescale them either.
    let sum = if scales == WEIGHTS.len() { 1.0 } else { kept.iter().sum() };
    kept.iter().map(|weight| weight / sum).collect()
}

/// Checks that two pictures can be compared.
fn check(what: &str, output: &Tensor, reference: &Tensor) -> Result<()> {
    let [_, _, height, width] = picture_shape(output, reference)?;
    if height.min(width) < WINDOW {
        return Err(Error::Input(format!(
            "{what} needs pictures of at least {WINDOW}×{WINDOW} pixels, not {width}×{height}; give larger ones"
        )));
    }
    Ok(())
}

/// Means over each channel of each picture: \[N, C\].
struct Similarity {
    /// Luminance × contrast × structure.
    whole: Tensor,
    /// Contrast × structure.
    structure: Tensor,
}

/// Similarity of pictures \[N, C, H, W\].
fn similarity(a: &Tensor, b: &Tensor) -> Similarity {
    let moments = Tensor::cat(&[a, b, &(a.square() + b.square()), &(a * b)], 1);
    let means = blurred(&moments.contiguous()).chunk(4, 1);
    let (mean_product, mean_squares) = (&means[0] * &means[1], means[0].square() + means[1].square());
    let (variances, covariance) = (&means[2] - &mean_squares, &means[3] - &mean_product);
    let structure = (covariance * 2.0 + C2) / (variances + C2);
    let luminance = (mean_product * 2.0 + C1) / (mean_squares + C1);
    let average = |map: &Tensor| map.mean_dim([2i64, 3].as_slice(), false, None);
    Similarity { whole: average(&(luminance * &structure)), structure: average(&structure) }
}

/// Filters each channel of \[N, C, H, W\] by the window, without padding.
fn blurred(pictures: &Tensor) -> Tensor {
    let window = gaussian(WINDOW, SIGMA, pictures);
    let channels = pictures.size()[1];
    // One group per channel: libtorch's single-channel convolutions are forty times slower.
    let along = |pictures: &Tensor, height: i64, width: i64| {
        let window =
            window.view([1, 1, height, width]).expand([channels, 1, height, width], false).contiguous();
        pictures.conv2d::<Tensor>(&window, None, 1, 0, 1, channels)
    };
    along(&along(pictures, WINDOW, 1), 1, WINDOW)
}

/// Normalised Gaussian of standard deviation `sigma` pixels, cut to `size` pixels, in the kind and on the device of
/// `like`.
pub(super) fn gaussian(size: i64, sigma: f64, like: &Tensor) -> Tensor {
    let middle = (size as f64 - 1.0) * 0.5;
    let weight = |i: i64| (-(i as f64 - middle).powi(2) / (2.0 * sigma * sigma)).exp();
    let weights: Vec<f64> = (0..size).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    constant(&weights.iter().map(|weight| weight / sum).collect::<Vec<_>>(), like)
}

/// Downsamples to half the size by averages of 2×2 pixels, with a line of zeros in front of odd sides.
fn halved(pictures: &Tensor) -> Tensor {
    let odd = [pictures.size()[2] % 2, pictures.size()[3] % 2];
    pictures.avg_pool2d([2, 2], [2, 2], odd, false, true, None)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{EXACT, frame, pair, pictures, value, worst_slope};
    use super::*;
    use fovol_metrics::SsimSettings;
    use tch::{Device, Kind};

    /// Mean of a metric over the pictures of a batch.
    fn metric(output: &Tensor, reference: &Tensor, of_two: impl Fn(&[fovol_core::Frame; 2]) -> f64) -> f64 {
        let n = output.size()[0];
        (0..n).map(|i| of_two(&[frame(reference, i), frame(output, i)])).sum::<f64>() / n as f64
    }

    #[test]
    fn ssim_is_that_of_the_metrics() {
        for size in [[2, 40, 31], [1, 11, 64]] {
            let (output, reference) = pair(size, 0.3);
            let (output, reference) = (output.clamp(0.0, 1.0), reference);
            let expected = metric(&output, &reference, |[r, t]| {
                fovol_metrics::ssim(r, t, &SsimSettings::gaussian()).unwrap()
            });
            assert!((value(&ssim(&output, &reference).unwrap()) - expected).abs() < 1e-6);
            let single = [&output, &reference].map(|t| t.to_kind(Kind::Float));
            assert!((value(&ssim(&single[0], &single[1]).unwrap()) - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn ms_ssim_is_that_of_the_metrics_on_odd_sides_too() {
        for size in [[1, 176, 161], [2, 163, 190]] {
            let (output, reference) = pair(size, 0.7);
            let output = output.clamp(0.0, 1.0);
            let expected = metric(&output, &reference, |[r, t]| fovol_metrics::ms_ssim(r, t).unwrap());
            assert!((value(&ms_ssim(&output, &reference).unwrap()) - expected).abs() < 1e-6);
            let single = [&output, &reference].map(|t| t.to_kind(Kind::Float));
            assert!((value(&ms_ssim(&single[0], &single[1]).unwrap()) - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn small_pictures_have_fewer_scales() {
        let counts = [(11, 1), (20, 1), (21, 2), (41, 3), (81, 4), (160, 4), (161, 5), (2000, 5)];
        for (side, count) in counts {
            let weights = scale_weights(side);
            assert_eq!(weights.len(), count, "{side}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 2e-4);
        }
        let (output, reference) = pair([1, 20, 15], 0.2);
        // A single scale is plain SSIM of each channel, and all values are positive here.
        let both = [ssim(&output, &reference).unwrap(), ms_ssim(&output, &reference).unwrap()];
        assert!((value(&both[0]) - value(&both[1])).abs() < 1e-12);
        let tiny = pictures([1, 10, 40], 0.0, EXACT);
        let message = ssim(&tiny, &tiny).unwrap_err().to_string();
        assert!(message.contains("at least 11×11"), "{message}");
        assert!(ms_ssim(&tiny, &reference).is_err());
    }

    #[test]
    fn equal_pictures_score_one() {
        let picture = pictures([2, 170, 180], 0.4, EXACT);
        for score in [ssim(&picture, &picture).unwrap(), ms_ssim(&picture, &picture).unwrap()] {
            assert!((value(&score) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn gradients_are_differences() {
        for size in [[2, 13, 15], [1, 23, 30], [1, 45, 43]] {
            let (output, reference) = pair(size, 0.6);
            for score in [ssim, ms_ssim] {
                let worst = worst_slope(&[output.shallow_clone(), reference.shallow_clone()], |inputs| {
                    score(&inputs[0], &inputs[1]).unwrap()
                });
                assert!(worst < 1e-6, "{size:?}: {worst:e}");
            }
        }
    }

    #[test]
    fn opposite_pictures_have_finite_gradients() {
        let reference = pictures([1, 96, 96], 0.1, (Kind::Float, Device::Cpu));
        let opposite: Tensor = 1.0 - &reference;
        let output = opposite.set_requires_grad(true);
        ms_ssim(&output, &reference).unwrap().mean(None).backward();
        assert!(bool::try_from(output.grad().isfinite().all()).unwrap());
    }
}
