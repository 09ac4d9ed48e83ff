/// How a segment of a function runs from its left node to the right one, after VTK's `vtkPiecewiseFunction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    /// Where in the segment half of the way is made, 0…1.
    midpoint: f64,
    /// 0 for a straight line, 1 for nearly a jump at the midpoint.
    sharpness: f64,
}

/// Midpoints closer to an end are moved here, so that both halves have a length.
const NEAREST_MIDPOINT: f64 = 1e-5;

/// Sharpnesses below are straight lines.
const STRAIGHT: f64 = 0.01;

impl Warp {
    /// Straight lines.
    pub const LINEAR: Self = Self { midpoint: 0.5, sharpness: 0.0 };

    /// The segment of `midpoint` and `sharpness`, brought into their intervals.
    pub fn new(midpoint: f64, sharpness: f64) -> Self {
        let midpoint = midpoint.clamp(NEAREST_MIDPOINT, 1.0 - NEAREST_MIDPOINT);
        Self { midpoint, sharpness: sharpness.clamp(0.0, 1.0) }
    }

    /// Where in the segment the function may bend or jump, if anywhere.
    pub fn bend(self) -> Option<f64> {
        (self != Self::LINEAR).then_some(self.midpoint)
    }

    /// The share of the right node's value at the place `s` of the segment, both 0…1.
    pub fn share(self, s: f64) -> f64 {
        let Self { midpoint, sharpness } = self;
        let s = if s < midpoint { 0.5 * s / midpoint } else { 0.5 + 0.5 * (s - midpoint) / (1.0 - midpoint) };
        if sharpness < STRAIGHT {
            return s;
        }
        let power = 1.0 + 10.0 * sharpness;
        let s = if s < 0.5 { 0.5 * (2.0 * s).powf(power) } else { 1.0 - 0.5 * (2.0 - 2.0 * s).powf(power) };
        // Hermite's cubic from 0 to 1 with the slope 1 − sharpness at both ends.
        let slope = 1.0 - sharpness;
        let cubic = s * s * (3.0 - 2.0 * s) + slope * s * (2.0 * s - 1.0) * (s - 1.0);
        cubic.clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ends_and_half_way_are_met(midpoint in 0.0f64..=1.0, sharpness in 0.0f64..=1.0) {
            let warp = Warp::new(midpoint, sharpness);
            prop_assert!(warp.share(0.0).abs() < 1e-9);
            prop_assert!((warp.share(1.0) - 1.0).abs() < 1e-9);
            prop_assert!((warp.share(warp.midpoint) - 0.5).abs() < 1e-9);
        }
    }
}
