//! How different two pictures look.

use super::ssim::ms_ssim;
use super::{mean, picture_shape};
use crate::Result;
use serde::{Deserialize, Serialize};
use tch::{Device, Tensor};

/// A differentiable measure of how different two pictures look.
pub trait Perceptual: std::fmt::Debug + Send {
    /// The mean difference of pictures \[N, 3, H, W\] in 0…1 from their references, 0 for equal ones: a scalar.
    ///
    /// # Errors
    /// Pictures of different shapes, or too small for this measure.
    fn distance(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor>;

    /// What it is called in tables.
    fn name(&self) -> &'static str;
}

/// Which measure, and what it needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "measure", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PerceptualConfig {
    /// [`L1MsSsim`].
    L1MsSsim(L1MsSsim),
}

impl Default for PerceptualConfig {
    fn default() -> Self {
        Self::L1MsSsim(L1MsSsim::default())
    }
}

impl PerceptualConfig {
    /// The measure itself, with its weights on `device`.
    ///
    /// # Errors
    /// Files that cannot be read or hold other weights.
    pub fn build(&self, _device: Device) -> Result<Box<dyn Perceptual>> {
        match self {
            Self::L1MsSsim(measure) => Ok(Box::new(*measure)),
        }
    }
}

/// `structure`·(1 − MS-SSIM) + (1 − `structure`)·L1 + `gradient`·L1 of the gradients.
///
/// The mix is that of Zhao et al., "Loss functions for image restoration with neural networks" (2017), which needs no
/// weights. Gradients are the differences to the pixel below and to the right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct L1MsSsim {
    /// The share of structure, 0…1.
    pub structure: f64,
    /// The weight of gradients.
    pub gradient: f64,
}

impl Default for L1MsSsim {
    fn default() -> Self {
        Self { structure: 0.84, gradient: 0.25 }
    }
}

impl Perceptual for L1MsSsim {
    fn distance(&self, output: &Tensor, reference: &Tensor) -> Result<Tensor> {
        let structure = 1.0 - ms_ssim(output, reference)?;
        let plain = mean(&(output - reference).abs());
        let gradients = gradient_l1(output, reference)?;
        Ok(structure * self.structure + plain * (1.0 - self.structure) + gradients * self.gradient)
    }

    fn name(&self) -> &'static str {
        "L1 + MS-SSIM"
    }
}

/// The mean absolute difference between the gradients of \[N, C, H, W\] and of \[N, C, H, W\]: a scalar.
///
/// Gradients are forward differences along rows and columns, where both exist.
///
/// # Errors
/// Pictures of different or other shapes.
pub fn gradient_l1(output: &Tensor, reference: &Tensor) -> Result<Tensor> {
    let [_, _, height, width] = picture_shape(output, reference)?;
    // Differences are linear: those of the error are the errors of those.
    let error = output - reference;
    let part = |top: i64, left: i64| error.narrow(2, top, height - 1).narrow(3, left, width - 1);
    let corner = part(0, 0);
    let (down, right) = (part(1, 0) - &corner, part(0, 1) - &corner);
    Ok((mean(&down.abs()) + mean(&right.abs())) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{pair, value, worst_slope};
    use super::*;

    #[test]
    fn gradients_of_pictures_are_differences_to_neighbours() {
        let reference = Tensor::from_slice(&[0.0, 0.5, 0.25, 1.0, 0.0, 0.5]).view([1, 1, 2, 3]);
        let output = reference.zeros_like();
        // Down 1.0, −0.5; right 0.5, −0.25.
        let expected = (1.0 + 0.5 + 0.5 + 0.25) / 4.0;
        assert!((value(&gradient_l1(&output, &reference).unwrap()) - expected).abs() < 1e-12);
    }

    #[test]
    fn the_default_is_a_loss_with_a_gradient() {
        let (output, reference) = pair([2, 24, 26], 0.4);
        let measure = L1MsSsim::default();
        assert!(value(&measure.distance(&reference, &reference).unwrap()).abs() < 1e-12);
        let worst = worst_slope(&[output.shallow_clone()], |inputs| {
            measure.distance(&inputs[0], &reference).unwrap()
        });
        assert!(worst < 1e-6, "{worst:e}");
    }
}
