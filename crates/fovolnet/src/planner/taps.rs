use fovol_core::{Frame, FrameSize, Pixel};

/// Pixels of a smaller frame, with their weights, that a pixel of the enlarged frame is made of.
pub type Taps = Vec<(Pixel, f32)>;

/// How smaller frames are enlarged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enlargement {
    /// Linear between pixels, as textures on a screen.
    Linear,
    /// Cubic (Catmull and Rom), as [`fovol_io::image::resized`].
    Cubic,
}

impl Enlargement {
    /// Taps in a frame of `small` for `pixel` of the enlarged frame of size `large`.
    pub fn taps(self, pixel: Pixel, large: FrameSize, small: FrameSize) -> Taps {
        if large == small {
            return vec![(pixel, 1.0)];
        }
        let columns = self.along(pixel.x, large.width, small.width);
        let rows = self.along(pixel.y, large.height, small.height);
        let mut taps = Vec::with_capacity(columns.len() * rows.len());
        for &(y, row) in &rows {
            taps.extend(columns.iter().map(|&(x, column)| (Pixel { x, y }, row * column)));
        }
        taps
    }

    /// Taps along one side, whose weights add up to 1.
    fn along(self, at: u16, large: u32, small: u32) -> Vec<(u16, f32)> {
        let place = (f64::from(at) + 0.5) * f64::from(small) / f64::from(large) - 0.5;
        let whole = place.floor();
        let radius = match self {
            Self::Linear => 1,
            Self::Cubic => 2,
        };
        let inside = |tap: i64| (0..i64::from(small)).contains(&tap);
        let weight = |tap: i64| (tap as u16, self.weight((tap as f64 - place).abs()) as f32);
        let taps = (whole as i64 - radius + 1..=whole as i64 + radius).filter(|tap| inside(*tap));
        let mut taps: Vec<(u16, f32)> = taps.map(weight).collect();
        let sum: f32 = taps.iter().map(|(_, weight)| weight).sum();
        taps.iter_mut().for_each(|(_, weight)| *weight /= sum);
        taps
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

    /// Colour that `frame` shows at `pixel` when it is enlarged to `large`.
    pub fn colour(self, frame: &Frame, pixel: Pixel, large: FrameSize) -> [f32; 3] {
        let taps = self.taps(pixel, large, frame.size());
        let width = frame.size().width;
        let colours = taps.iter().map(|(tap, weight)| (frame.pixels()[tap.index(width)], weight));
        blended(colours.map(|([r, g, b, _], weight)| ([r, g, b], *weight)))
    }
}

/// Weighted sum of colours, cut to 0…1.
pub fn blended(colours: impl IntoIterator<Item = ([f32; 3], f32)>) -> [f32; 3] {
    let mut sum = [0.0f32; 3];
    for (colour, weight) in colours {
        for (sum, value) in sum.iter_mut().zip(colour) {
            *sum += weight * value;
        }
    }
    sum.map(|value| value.clamp(0.0, 1.0))
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
