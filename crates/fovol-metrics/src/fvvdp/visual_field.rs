//! Positions of pixels in the visual field for a fixed gaze.

use crate::planes::Plane;
use crate::vdp::Display;
use rayon::prelude::*;

/// Largest angle from the middle of the display in the magnification, in degrees.
const WIDEST: f64 = 89.0;

/// Directions of the pixels of one band.
///
/// The frame is assumed to fill the display, whatever its size, as in the published program. Band frequencies still
/// use the display's own pixels.
#[derive(Debug, Clone)]
pub(crate) struct VisualField {
    extent: [f64; 2],
    /// Degrees right of and below the middle of the display, by column and by row.
    columns: Vec<f32>,
    rows: Vec<f32>,
    /// log₂ of pixels per degree relative to the middle of the display.
    pub log_magnification: Plane,
}

impl VisualField {
    pub fn new(display: &Display, width: usize, height: usize) -> Self {
        let extent = display.extent();
        let along = |count: usize, extent: f64| -> Vec<f32> {
            (0..count).map(|i| degrees((i as f64 + 0.5) / count as f64, extent) as f32).collect()
        };
        let (columns, rows) = (along(width, extent[0]), along(height, extent[1]));
        let half_pixel = 0.5 / display.pixels_per_degree();
        let row = |y: &f32| -> Vec<f32> {
            columns.iter().map(|x| log_magnification(x.hypot(*y).into(), half_pixel)).collect()
        };
        let values = rows.par_iter().flat_map_iter(row).collect();
        Self { extent, log_magnification: Plane { width, height, values }, columns, rows }
    }

    /// Direction of `gaze` in degrees; `gaze` is in fractions of the frame from its top left.
    pub fn direction(&self, gaze: [f64; 2]) -> [f32; 2] {
        [0, 1].map(|i| degrees(gaze[i], self.extent[i]) as f32)
    }

    /// Square roots of the distances, in degrees, of the pixels of row `y` from the direction `gaze`.
    pub fn root_eccentricity(&self, y: usize, gaze: [f32; 2], out: &mut [f32]) {
        let below = self.rows[y] - gaze[1];
        for (root, column) in out.iter_mut().zip(&self.columns) {
            let right = column - gaze[0];
            *root = (right * right + below * below).sqrt().sqrt();
        }
    }
}

/// Angle between the middle of the display and a point at the fraction `fraction` of its side, in degrees.
fn degrees(fraction: f64, extent: f64) -> f64 {
    ((fraction - 0.5) * extent).atan().to_degrees()
}

/// log₂ of the pixel density per degree at the angle `away` from the middle of a flat display, relative to the
/// middle. `half_pixel` is the angle of half a pixel in the middle; angles are in degrees.
fn log_magnification(away: f64, half_pixel: f64) -> f32 {
    let (away, half_pixel) = (away.min(WIDEST).to_radians(), half_pixel.to_radians());
    (((away + half_pixel).tan() - away.tan()) / half_pixel.tan()).log2() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_and_magnification_are_those_of_the_published_program() {
        let display = Display::named("standard_hmd").unwrap();
        let field = VisualField::new(&display, 64, 48);
        let gaze = field.direction([10.5 / 64.0, 7.5 / 48.0]);
        let mut roots = [0.0; 64];
        field.root_eccentricity(0, gaze, &mut roots);
        assert!((roots[0] * roots[0] - 14.523168).abs() < 1e-4);
        assert!((roots[63] * roots[63] - 76.592224).abs() < 1e-4);
        let half_pixel = 0.5 / display.pixels_per_degree();
        for (away, expected) in [(0.0, 1.0), (10.0, 1.031_211_8), (40.0, 1.705_037_4), (63.6396, 5.079_078)] {
            let found = f64::from(log_magnification(away, half_pixel)).exp2();
            assert!((found - expected).abs() < 2e-5 * expected, "{away}: {found}");
        }
        assert!(log_magnification(120.0, half_pixel).is_finite());
    }
}
