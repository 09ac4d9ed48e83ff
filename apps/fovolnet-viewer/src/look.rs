//! What of a frame is put on the screen.

use fovolnet::core::{Fovea, Frame, SampleMask};

/// What is shown of a frame: the picture, or how it came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Look {
    /// The picture.
    #[default]
    Picture,
    /// What was measured, and nothing else.
    Samples,
    /// The picture, with what was not measured coloured.
    Measured,
    /// How likely each pixel is sampled.
    Density,
    /// How far the reconstruction is from what was measured later, four times as large.
    Difference,
}

impl Look {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Picture, Self::Samples, Self::Measured, Self::Density, Self::Difference];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Samples => "Samples",
            Self::Measured => "Measured",
            Self::Density => "Density",
            Self::Difference => "Difference",
        }
    }

    /// What it tells.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Picture => "The picture",
            Self::Samples => "Only the pixels that rays were sent through",
            Self::Measured => "Orange is what was not measured but reconstructed",
            Self::Density => "How likely each pixel is sampled: dark is rarely, bright is always",
            Self::Difference => {
                "How far the reconstruction was from the full frame, four times as large; stand still to see it"
            }
        }
    }
}

/// A frame with everything that looks need.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// The picture as far as it is known.
    pub picture: &'a Frame,
    /// What was measured of it.
    pub measured: &'a SampleMask,
    /// What was reconstructed of the first samples.
    pub reconstructed: &'a Frame,
    /// How samples were chosen.
    pub fovea: &'a Fovea,
}

/// What pixels are tinted with that were not measured.
const TINT: [f32; 3] = [1.0, 0.45, 0.0];
/// How much of them is tint.
const TINTED: f32 = 0.4;
/// What is seen where nothing was sampled.
const NOTHING: [f32; 3] = [0.06; 3];
/// How much differences are enlarged.
const GAIN: f32 = 4.0;

/// `parts` as opaque 8-bit RGBA.
pub fn rgba(look: Look, parts: &Parts<'_>) -> Vec<u8> {
    let size = parts.picture.size();
    let mut rgba = Vec::with_capacity(4 * size.pixels());
    for y in 0..size.height {
        for x in 0..size.width {
            let [r, g, b] = colour(look, parts, x, y).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
            rgba.extend([r, g, b, 255]);
        }
    }
    rgba
}

fn colour(look: Look, parts: &Parts<'_>, x: u32, y: u32) -> [f32; 3] {
    let [r, g, b, _] = parts.picture.pixel(x, y);
    let measured = || parts.measured.contains(x, y);
    match look {
        Look::Picture => [r, g, b],
        Look::Samples => {
            if measured() {
                [r, g, b]
            } else {
                NOTHING
            }
        }
        Look::Measured if measured() => [r, g, b],
        Look::Measured => std::array::from_fn(|c| [r, g, b][c] * (1.0 - TINTED) + TINT[c] * TINTED),
        Look::Density => {
            let density = parts.fovea.density_at(x, y, parts.picture.size());
            // Few per cent apart from all: the root tells them apart.
            let shade = density.sqrt() as f32;
            [shade, shade * shade, 0.5 * shade]
        }
        Look::Difference => {
            let [s, h, c, _] = parts.reconstructed.pixel(x, y);
            [r - s, g - h, b - c].map(|d| d.abs() * GAIN)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::FrameSize;

    fn shown(look: Look) -> Vec<u8> {
        let size = FrameSize::new(2, 1).unwrap();
        let picture = Frame::from_pixels(size, vec![[0.5, 0.5, 0.5, 1.0], [0.2, 0.2, 0.2, 1.0]]).unwrap();
        let reconstructed =
            Frame::from_pixels(size, vec![[0.5, 0.5, 0.5, 1.0], [0.3, 0.2, 0.2, 1.0]]).unwrap();
        let measured = SampleMask::from_fn(size, |x, _| x == 0);
        let fovea = Fovea { base: 0.25, sigma: 0.0, gaze: [0.5; 2] };
        rgba(
            look,
            &Parts { picture: &picture, measured: &measured, reconstructed: &reconstructed, fovea: &fovea },
        )
    }

    #[test]
    fn looks_tell_measured_from_made() {
        assert_eq!(shown(Look::Picture), [128, 128, 128, 255, 51, 51, 51, 255]);
        assert_eq!(shown(Look::Samples), [128, 128, 128, 255, 15, 15, 15, 255]);
        let measured = shown(Look::Measured);
        assert_eq!(measured[..4], [128, 128, 128, 255]);
        assert!(measured[4] > 100 && measured[6] < 60);
        assert_eq!(shown(Look::Difference)[..3], [0, 0, 0]);
        assert_eq!(shown(Look::Difference)[4], 102);
        assert_eq!(shown(Look::Density)[..3], [128, 64, 64]);
    }
}
