//! Window and level of the slices.

/// The values shown between black and white. Radiologists call the centre the level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueWindow {
    /// Value in the middle.
    pub centre: f64,
    /// Distance from the value shown black to the value shown white; above 0.
    pub width: f64,
}

/// Points of a drag that change the window by the whole range.
const POINTS: f64 = 400.0;
/// Smallest width, as a fraction of the whole range.
const NARROWEST: f64 = 1e-3;

impl ValueWindow {
    /// Window over `range`. A range without width gets the width 1.
    pub fn over([lo, hi]: [f64; 2]) -> Self {
        let width = if hi > lo { hi - lo } else { 1.0 };
        Self { centre: 0.5 * (lo + hi), width }
    }

    /// The values shown black and white.
    pub fn ends(self) -> [f64; 2] {
        [self.centre - 0.5 * self.width, self.centre + 0.5 * self.width]
    }

    /// Window after a drag by `right` and `down` points: to the right it is wider, upwards the picture is brighter.
    /// `usual` is the window over the whole range.
    #[must_use]
    pub fn dragged(self, right: f64, down: f64, usual: Self) -> Self {
        let point = usual.width / POINTS;
        let width = (self.width + right * point).max(NARROWEST * usual.width);
        Self { centre: self.centre + down * point, width }
    }

    /// Grey of `value`: 0 is black, 255 white. NaN is black.
    #[inline]
    pub fn grey(self, value: f64) -> u8 {
        // A cast saturates.
        ((value - self.centre) / self.width * 255.0 + 128.0) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_black_and_white() {
        let window = ValueWindow::over([-160.0, 240.0]);
        assert_eq!((window.centre, window.width, window.ends()), (40.0, 400.0, [-160.0, 240.0]));
        let greys = [-1000.0, -160.0, 40.0, 240.0, 3000.0, f64::NAN, f64::INFINITY];
        assert_eq!(greys.map(|value| window.grey(value)), [0, 0, 128, 255, 255, 0, 255]);
        assert_eq!(ValueWindow::over([0.0, 255.0]).grey(77.0), 77, "bytes are shown as they are");
        assert_eq!(ValueWindow::over([7.0, 7.0]).width, 1.0);
    }

    #[test]
    fn drags_widen_to_the_right_and_brighten_upwards() {
        let usual = ValueWindow::over([0.0, 400.0]);
        let dragged = usual.dragged(50.0, -30.0, usual);
        assert_eq!((dragged.centre, dragged.width), (170.0, 450.0));
        assert!(dragged.grey(180.0) > usual.grey(180.0));
        let narrow = usual.dragged(-9999.0, 0.0, usual);
        assert_eq!((narrow.centre, narrow.width), (200.0, 0.4));
    }
}
