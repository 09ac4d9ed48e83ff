use super::display_names::NAMES;
use super::log_math::{exp2, log2};
use crate::planes::display as clamped;
use crate::{Error, Result};
use fovol_core::Frame;
use rayon::prelude::*;

/// Weights of linear RGB in luminance, for the BT.709 primaries that sRGB uses.
const LUMA: [f32; 3] = [0.212_672_9, 0.715_152_2, 0.072_175];

/// Display model: conversion of display values to light, and viewing geometry.
///
/// [`Display::named`] has presets. All fields can also be set by hand:
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Display {
    /// Pixels along x and y; pixels are square.
    pub resolution: [u32; 2],
    /// Width of the whole display area, in metres.
    pub width_m: f64,
    /// Viewing distance, in metres.
    pub distance_m: f64,
    /// Luminance of white without ambient light, in cd/m².
    pub peak: f64,
    /// Contrast, white over black without ambient light; at least 1.
    pub contrast: f64,
    /// Ambient light on the display, in lux.
    pub ambient: f64,
    /// Fraction of the ambient light that the display reflects, 0…1.
    pub reflectivity: f64,
}

impl Display {
    /// Names of the presets.
    pub const NAMES: [&str; 3] = NAMES;

    /// FovVideoVDP's preset `name`.
    ///
    /// * `standard_4k`: 30 inches, 3840×2160, at 0.7472 m in an office: 75.4 pixels a degree, 200 cd/m².
    /// * `standard_fhd`: 24 inches, 1920×1080, at 0.6 m in an office: 37.8 pixels a degree, 200 cd/m².
    /// * `standard_hmd`: a headset with 1440×1600 pixels per eye and 110° along the diagonal: 13.2 pixels a degree,
    ///   100 cd/m², without ambient light.
    ///
    /// # Errors
    /// Any other name; the message lists the names.
    pub fn named(name: &str) -> Result<Self> {
        let office = |resolution: [u32; 2], inches: f64, distance_m: f64| Self {
            resolution,
            width_m: width_of_diagonal(resolution, inches * 0.0254),
            distance_m,
            peak: 200.0,
            contrast: 1000.0,
            ambient: 250.0,
            reflectivity: 0.005,
        };
        match name {
            "standard_4k" => Ok(office([3840, 2160], 30.0, 0.7472)),
            "standard_fhd" => Ok(office([1920, 1080], 24.0, 0.6)),
            "standard_hmd" => {
                // The optics place the picture far away; only the angle counts.
                let (resolution, distance_m) = ([1440, 1600], 3.0);
                let diagonal = 2.0 * distance_m * 55_f64.to_radians().tan();
                let width_m = width_of_diagonal(resolution, diagonal);
                Ok(Self { width_m, peak: 100.0, ambient: 0.0, ..office(resolution, 1.0, distance_m) })
            }
            _ => Err(Error::UnknownDisplay { name: name.into() }),
        }
    }

    /// Sets the diagonal to `inches`.
    #[must_use]
    pub fn with_diagonal(self, inches: f64) -> Self {
        Self { width_m: width_of_diagonal(self.resolution, inches * 0.0254), ..self }
    }

    /// Pixels per degree of the visual field in the middle of the display.
    pub fn pixels_per_degree(&self) -> f64 {
        let half_pixel = 0.5 * self.width_m / f64::from(self.resolution[0]);
        0.5 / (half_pixel / self.distance_m).atan().to_degrees()
    }

    /// Luminance of black including reflected ambient light, in cd/m².
    pub fn black(&self) -> f64 {
        self.ambient / std::f64::consts::PI * self.reflectivity + self.peak / self.contrast
    }

    /// Checks that the parameters are possible.
    pub(crate) fn check(&self) -> Result<()> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let sizes = self.resolution.iter().all(|&side| side > 0);
        let seen = positive(self.width_m) && positive(self.distance_m);
        let bright = positive(self.peak) && self.contrast >= 1.0 && self.ambient >= 0.0;
        let reflects = (0.0..=1.0).contains(&self.reflectivity);
        if sizes && seen && bright && reflects && self.ambient.is_finite() && self.black() < self.peak {
            Ok(())
        } else {
            Err(Error::ImpossibleDisplay)
        }
    }

    /// Width and height over distance: twice the tangents of the half angles.
    pub(crate) fn extent(&self) -> [f64; 2] {
        let width = self.width_m / self.distance_m;
        [width, width * f64::from(self.resolution[1]) / f64::from(self.resolution[0])]
    }

    /// Computes the luminance of every pixel in cd/m²: the sRGB curve (IEC 61966-2-1) between black and peak.
    pub(crate) fn luminance(&self, frame: &Frame, out: &mut [f32]) {
        let width = frame.size().width as usize;
        let black = self.black();
        let weights = LUMA.map(|w| w * (self.peak - black) as f32);
        let rows = out.par_chunks_mut(width).zip(frame.pixels().par_chunks(width));
        rows.for_each_init(
            || vec![[0.0; 4]; width],
            |linear, (out, pixels)| {
                linearise(pixels, linear);
                for (value, rgb) in out.iter_mut().zip(linear.iter()) {
                    *value = weights[0] * rgb[0] + weights[1] * rgb[1] + weights[2] * rgb[2] + black as f32;
                }
            },
        );
    }
}

/// Converts display values to linear light 0…1; NaN becomes 0. Alpha is converted too, since skipping it would be
/// slower.
pub(crate) fn linearise(pixels: &[[f32; 4]], out: &mut [[f32; 4]]) {
    for (out, &pixel) in out.iter_mut().zip(pixels) {
        let [r, g, b] = clamped(pixel);
        *out = [r, g, b, 0.0];
    }
    for value in out.as_flattened_mut() {
        let v = *value;
        let curve = exp2(2.4 * log2((v + 0.055) * (1.0 / 1.055)));
        *value = if v <= 0.04045 { v * (1.0 / 12.92) } else { curve };
    }
}

/// Width of a rectangle with the aspect ratio of `resolution` and the given diagonal.
fn width_of_diagonal(resolution: [u32; 2], diagonal: f64) -> f64 {
    let ratio = f64::from(resolution[1]) / f64::from(resolution[0]);
    diagonal / (1.0 + ratio * ratio).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    #[test]
    fn the_presets_have_their_published_resolution() {
        let ppd = Display::NAMES.map(|name| Display::named(name).unwrap().pixels_per_degree());
        for (found, expected) in ppd.into_iter().zip([75.4024, 37.8425, 13.1533]) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
        assert!((Display::named("standard_4k").unwrap().black() - 0.59789).abs() < 1e-5);
        assert!((Display::named("standard_hmd").unwrap().black() - 0.1).abs() < 1e-9);
        let error = Display::named("tv").unwrap_err().to_string();
        assert!(error.contains("tv") && error.contains("standard_hmd") && !error.contains('\n'));
    }

    #[test]
    fn luminance_goes_from_black_to_peak_along_the_srgb_curve() {
        let display = Display::named("standard_4k").unwrap();
        let values = [0.0, 0.02, 0.2, 0.5, 1.0, f32::NAN, 7.0];
        let pixels = values.map(|v| [v, v, v, 0.3]).to_vec();
        let frame = Frame::from_pixels(FrameSize::new(7, 1).unwrap(), pixels).unwrap();
        let mut found = [0.0; 7];
        display.luminance(&frame, &mut found);
        for (found, linear) in found.into_iter().zip([0.0, 0.001548, 0.033105, 0.214041, 1.0, 0.0, 1.0]) {
            let expected = (200.0 - 0.597887) * linear + 0.597887;
            assert!((found - expected).abs() < 2e-4, "{found} {expected}");
        }
    }

    #[test]
    fn displays_that_cannot_be_are_refused() {
        let good = Display::named("standard_fhd").unwrap();
        good.check().unwrap();
        assert!((good.with_diagonal(12.0).width_m * 2.0 - good.width_m).abs() < 1e-12);
        for bad in [
            Display { resolution: [0, 10], ..good },
            Display { distance_m: 0.0, ..good },
            Display { width_m: f64::NAN, ..good },
            Display { peak: f64::INFINITY, ..good },
            Display { contrast: 0.5, ..good },
            Display { ambient: -1.0, ..good },
            Display { ambient: 1e9, ..good },
            Display { reflectivity: 2.0, ..good },
        ] {
            assert_eq!(bad.check(), Err(Error::ImpossibleDisplay), "{bad:?}");
        }
    }
}
