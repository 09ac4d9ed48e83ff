//! Display values to light in the opponent channels of the retina: Mantiuk et al. (2024), section 3.1.

use crate::vdp::{Display, linearise};
use fovol_core::Frame;
use rayon::prelude::*;

/// Linear RGB with the BT.709 primaries, which sRGB uses, to XYZ, by rows.
const XYZ: [[f64; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9, 0.119_192, 0.950_304_1],
];

/// XYZ to the responses of L, M and S cones (CIE 2006), by rows.
const CONES: [[f64; 3]; 3] = [
    [0.187_596_268_556_126, 0.585_168_649_077_728, -0.026_384_263_306_304],
    [-0.133_397_430_663_221, 0.405_505_777_260_049, 0.034_502_127_690_364],
    [0.000_244_379_021_663, -0.000_542_995_890_619, 0.019_406_849_066_323],
];

/// Cone responses to the achromatic, the red-green and the violet-yellow channel of Derrington, Krauskopf and Lennie
/// (1984), by rows. Greys (D65) have almost no chromatic response.
const OPPONENT: [[f64; 3]; 3] =
    [[1.0, 1.0, 0.0], [1.0, -2.311_130_179_947_035, 0.0], [-1.0, -1.0, 50.977_571_328_718_78]];

/// Conversion of display values to opponent channels, in cd/m²: achromatic, red-green, violet-yellow.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Opponent {
    /// Weights of linear RGB 0…1, by rows.
    weights: [[f32; 3]; 3],
    /// Black level with the reflected ambient light.
    black: [f32; 3],
}

impl Opponent {
    /// Conversion for `display`: the sRGB curve between its black and its peak, and reflected ambient light.
    pub fn new(display: &Display) -> Self {
        let matrix = product(OPPONENT, product(CONES, XYZ));
        let range = display.peak - display.peak / display.contrast;
        Self {
            weights: matrix.map(|row| row.map(|w| (w * range) as f32)),
            black: matrix.map(|row| (row.iter().sum::<f64>() * display.black()) as f32),
        }
    }

    /// Fills the three channels of `frame`, row by row. NaN counts as 0, alpha is ignored.
    pub fn channels(&self, frame: &Frame, [light, red_green, violet_yellow]: [&mut [f32]; 3]) {
        let width = frame.size().width as usize;
        let out = light.par_chunks_mut(width).zip(red_green.par_chunks_mut(width));
        let out = out.zip(violet_yellow.par_chunks_mut(width));
        out.zip(frame.pixels().par_chunks(width)).for_each_init(
            || vec![[0.0; 4]; width],
            |linear, (((light, red_green), violet_yellow), pixels)| {
                linearise(pixels, linear);
                for (channel, out) in [light, red_green, violet_yellow].into_iter().enumerate() {
                    let ([r, g, b], black) = (self.weights[channel], self.black[channel]);
                    for (value, rgb) in out.iter_mut().zip(linear.iter()) {
                        *value = r * rgb[0] + g * rgb[1] + b * rgb[2] + black;
                    }
                }
            },
        );
    }
}

/// Matrix product, by rows.
fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| [0, 1, 2].map(|column| (0..3).map(|i| row[i] * b[i][column]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    /// Display, display values, and the published program's channels.
    const SPOTS: [(&str, [f32; 3], [f32; 3]); 5] = [
        ("standard_4k", [0.0, 0.0, 0.0], [0.6284, 0.00226, 0.00617]),
        ("standard_4k", [1.0, 1.0, 1.0], [210.62375, 0.75655, 2.06955]),
        ("standard_4k", [0.8, 0.2, 0.4], [35.9462, 13.8468, -7.45099]),
        ("standard_4k", [0.02, 0.5, 0.9], [45.87055, -9.46778, 107.10474]),
        ("standard_hmd", [0.8, 0.2, 0.4], [17.76401, 6.92265, -3.72755]),
    ];

    fn channels(display: &str, rgb: [f32; 3]) -> [f32; 3] {
        let pixels = vec![[rgb[0], rgb[1], rgb[2], 0.5]];
        let frame = Frame::from_pixels(FrameSize::new(1, 1).unwrap(), pixels).unwrap();
        let (mut light, mut red_green, mut violet_yellow) = ([0.0], [0.0], [0.0]);
        let out = [&mut light[..], &mut red_green, &mut violet_yellow];
        Opponent::new(&Display::named(display).unwrap()).channels(&frame, out);
        [light[0], red_green[0], violet_yellow[0]]
    }

    #[test]
    fn channels_are_those_of_the_published_program() {
        for (display, rgb, expected) in SPOTS {
            let found = channels(display, rgb);
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 2e-4), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn values_outside_the_range_count_as_the_nearest() {
        assert_eq!(
            channels("standard_fhd", [f32::NAN, 7.0, -1.0]),
            channels("standard_fhd", [0.0, 1.0, 0.0])
        );
    }
}
