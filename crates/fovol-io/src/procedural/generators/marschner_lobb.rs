use super::domain::Domain;
use fovol_core::{Result, Volume};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Marschner and Lobb, "An evaluation of reconstruction filters for volume rendering" (1994),
/// section 5: most of its energy lies just below the Nyquist frequency of a grid of 40³.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    Volume::from_values(domain.grid(), domain.sample(|site| signal(site.centre))?)
}

/// The signal over [−1, 1]³, 0…1.
pub(super) fn signal(p: Vec3) -> f32 {
    const ALPHA: f32 = 0.25;
    const FREQUENCY: f32 = 6.0;
    let r = p.truncate().length();
    let ripples = (TAU * FREQUENCY * (0.5 * PI * r).cos()).cos();
    (1.0 - (0.5 * PI * p.z).sin() + ALPHA * (1.0 + ripples)) / (2.0 * (1.0 + ALPHA))
}
