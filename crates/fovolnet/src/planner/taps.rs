use fovol_core::{Frame, FrameSize, Pixel};

/// How smaller frames are enlarged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enlargement {
    /// Linear between pixels, as textures on a screen.
    Linear,
    /// Cubic (Catmull and Rom), as [`fovol_io::image::resized`].
    Cubic,
}

impl Enlargement {
    /// Colour that `frame` shows at `pixel` when it is enlarged to `large`.
    pub fn colour(self, frame: &Frame, pixel: Pixel, large: FrameSize) -> [f32; 3] {
        self.blended(pixel, [large, frame.size()], |tap| {
            let [r, g, b, _] = frame.pixels()[tap.index(frame.size().width)];
            [r, g, b]
        })
    }

    /// Colour that `frame` shows at `pixel` when it is made `smaller`, then enlarged to `large`.
    pub fn colour_made_smaller(
        self,
        frame: &Frame,
        pixel: Pixel,
        [large, smaller]: [FrameSize; 2],
    ) -> [f32; 3] {
        self.blended(pixel, [large, smaller], |tap| Self::Cubic.colour(frame, tap, smaller))
    }

    /// Colour at `pixel` of a frame of size `large` that is enlarged from `small`, whose pixels have a colour `of` their own.
    fn blended(
        self,
        pixel: Pixel,
        [large, small]: [FrameSize; 2],
        of: impl Fn(Pixel) -> [f32; 3],
    ) -> [f32; 3] {
        if large == small {
            return of(pixel).map(|value| value.clamp(0.0, 1.0));
        }
        let columns = self.taps(pixel.x, large.width, small.width);
        let rows = self.taps(pixel.y, large.height, small.height);
        let mut sum = [0.0f32; 3];
        for (y, row) in rows.each() {
            for (x, column) in columns.each() {
                let colour = of(Pixel { x, y });
                (0..3).for_each(|c| sum[c] += row * column * colour[c]);
            }
        }
        sum.map(|value| value.clamp(0.0, 1.0))
    }

    /// Taps of pixel `at` along one side.
    fn taps(self, at: u16, large: u32, small: u32) -> Taps {
        let place = (f64::from(at) + 0.5) * f64::from(small) / f64::from(large) - 0.5;
        let radius = match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        };
        let last = i64::from(small) - 1;
        let [first, end] = [1 - radius, radius + 1].map(|beside| place.floor() as i64 + beside);
        let [first, end] = [first.clamp(0, last), end.clamp(1, last + 1)];
        let mut weights = [0.0; MOST_TAPS];
        for (weight, tap) in weights.iter_mut().zip(first..end) {
            *weight = self.weight((tap as f64 - place).abs()) as f32;
        }
        let sum: f32 = weights.iter().sum();
        Taps {
            first: first as u16,
            count: (end - first) as usize,
            weights: weights.map(|weight| weight / sum),
        }
    }

    /// Weight of a tap at `distance` pixels.
    fn weight(self, distance: f64) -> f64 {
        let d = distance;
        match self {
            Self::Linear => (1.0 - d).max(0.0),
            Self::Cubic if d < 1.0 => 1.0 + d * d * (1.5 * d - 2.5),
            Self::Cubic if d < 2.0 => 2.0 + d * (-4.0 + d * (2.5 - 0.5 * d)),
            Self::Cubic => 0.0,
        }
    }
}

/// Most pixels along a side that a pixel of an enlarged frame is made of.
const MOST_TAPS: usize = 4;

/// Pixels along a side of a smaller frame that a pixel of the enlarged frame is made of. Their weights add up to 1.
struct Taps {
    first: u16,
    count: usize,
    weights: [f32; MOST_TAPS],
}

impl Taps {
    fn each(&self) -> impl Iterator<Item = (u16, f32)> {
        (self.first..).zip(self.weights).take(self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks(size: FrameSize) -> Frame {
        let value = |i: usize| ((i * 7919) % 101) as f32 / 100.0;
        Frame::from_pixels(size, (0..size.pixels()).map(|i| [value(i), value(i + 5), 0.5, 1.0]).collect())
            .unwrap()
    }

    #[cfg(feature = "files")]
    #[test]
    fn taps_are_those_of_the_enlarged_frame() {
        let (small, large) = (FrameSize::new(13, 9).unwrap(), FrameSize::new(32, 24).unwrap());
        let frame = checks(small);
        let enlarged = fovol_io::image::resized(&frame, large);
        for y in 0..24u16 {
            for x in 0..32u16 {
                let found = Enlargement::Cubic.colour(&frame, Pixel { x, y }, large);
                let expected = enlarged.pixel(x.into(), y.into());
                assert!(
                    (0..3).all(|c| (found[c] - expected[c]).abs() < 2e-3),
                    "{x} {y}: {found:?} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn frames_made_smaller_lose_what_they_cannot_hold() {
        let [small, large] = [[12, 10], [48, 40]].map(|[w, h]| FrameSize::new(w, h).unwrap());
        let smooth = (0..large.pixels()).map(|i| [(i % 48) as f32 / 48.0, 0.25, 0.5, 1.0]).collect();
        let smooth = Frame::from_pixels(large, smooth).unwrap();
        let rough = checks(large);
        let lost = |frame: &Frame| {
            let at = Pixel { x: 21, y: 18 };
            let made = Enlargement::Cubic.colour_made_smaller(frame, at, [large, small]);
            (made[0] - frame.pixel(21, 18)[0]).abs()
        };
        assert!(lost(&smooth) < 1e-3, "{}", lost(&smooth));
        assert!(lost(&rough) > 1e-2, "{}", lost(&rough));
    }

    #[test]
    fn equal_sizes_change_nothing_and_edges_stay_inside() {
        let size = FrameSize::new(6, 4).unwrap();
        let frame = checks(size);
        for enlargement in [Enlargement::Linear, Enlargement::Cubic] {
            let same = enlargement.colour(&frame, Pixel { x: 5, y: 3 }, size);
            assert_eq!(same, [frame.pixel(5, 3)[0], frame.pixel(5, 3)[1], 0.5]);
            let corner = enlargement.colour(&frame, Pixel { x: 59, y: 0 }, FrameSize::new(60, 40).unwrap());
            assert!((corner[2] - 0.5).abs() < 1e-6);
        }
    }
}
