//! From stored numbers to values: the smallest type that holds them exactly.

use super::plane::{Plane, Scale};
use crate::volume::reals;
use fovol_core::{Dtype, Endian, Rescale};

/// How values come from what is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values {
    /// All pictures are scaled alike; what is stored is kept.
    Alike(Scale),
    /// Each picture is scaled in its own way, to 32-bit floats.
    Each,
}

impl Values {
    /// How the values of `planes` are made; colours are not scaled.
    pub fn of(planes: &[Plane], is_coloured: bool) -> Self {
        match planes.first() {
            Some(first) if !is_coloured && planes.iter().any(|plane| plane.scale != first.scale) => {
                Self::Each
            }
            Some(first) if !is_coloured => Self::Alike(first.scale),
            _ => Self::Alike(Scale::IDENTITY),
        }
    }
}

/// Writes the scaled values of little-endian `samples` to `out` as 32-bit floats.
pub fn scaled(samples: &[u8], dtype: Dtype, scale: Scale, out: &mut [u8]) {
    let mut places = out.chunks_exact_mut(4);
    reals::for_each(samples, dtype, Endian::Little, |sample| {
        if let Some(place) = places.next() {
            let value = scale.slope * sample + scale.intercept;
            place.copy_from_slice(&(value as f32).to_le_bytes());
        }
    });
}

/// Adds a whole intercept to 16-bit `samples` where all sums fit, which are then signed.
///
/// Returns the type of the samples and the scaling that is left.
pub fn folded(samples: &mut [u8], dtype: Dtype, scale: Scale) -> (Dtype, Rescale) {
    let left = Rescale { slope: scale.slope, intercept: scale.intercept };
    let is_whole = scale.slope == 1.0 && scale.intercept.fract() == 0.0 && scale.intercept.abs() < 1e6;
    if !is_whole || scale.intercept == 0.0 || !matches!(dtype, Dtype::I16 | Dtype::U16) {
        return (dtype, left);
    }
    let intercept = scale.intercept as i32;
    let decoded = |pair: &[u8]| {
        let word = u16::from_le_bytes([pair[0], pair[1]]);
        if dtype == Dtype::I16 { i32::from(word as i16) } else { i32::from(word) }
    };
    let fits = |pair: &[u8]| i16::try_from(decoded(pair) + intercept).is_ok();
    if !samples.chunks_exact(2).all(fits) {
        return (dtype, left);
    }
    for pair in samples.chunks_exact_mut(2) {
        let sum = (decoded(pair) + intercept) as i16;
        pair.copy_from_slice(&sum.to_le_bytes());
    }
    (Dtype::I16, Rescale::IDENTITY)
}

/// The least of little-endian `samples`; 0 of none.
pub fn least(samples: &[u8], dtype: Dtype) -> f64 {
    let mut least = f64::INFINITY;
    reals::for_each(samples, dtype, Endian::Little, |sample| {
        if sample.is_finite() {
            least = least.min(sample);
        }
    });
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hounsfield_units_are_signed_words() {
        let scale = Scale { slope: 1.0, intercept: -1024.0 };
        let mut samples = [0, 0, 0xFF, 0x0F];
        assert_eq!(folded(&mut samples, Dtype::U16, scale), (Dtype::I16, Rescale::IDENTITY));
        assert_eq!(samples, [0x00, 0xFC, 0xFF, 0x0B]);
        let mut samples = [0xFF, 0xFF];
        let left = Rescale { slope: 1.0, intercept: -1024.0 };
        assert_eq!(folded(&mut samples, Dtype::U16, scale), (Dtype::U16, left));
    }

    #[test]
    fn scales_that_differ_make_floats() {
        let mut out = [0; 8];
        scaled(&[1, 2], Dtype::U8, Scale { slope: 0.5, intercept: 1.0 }, &mut out);
        assert_eq!(out, [1.5f32.to_le_bytes(), 2f32.to_le_bytes()].concat()[..]);
    }
}
