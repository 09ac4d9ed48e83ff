//! Display modes of a frame.

use fovolnet::core::{Fovea, Frame, SampleMask};

/// Display mode: the picture, or how it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DisplayMode {
    /// The picture.
    #[default]
    Picture,
    /// Only the rendered samples.
    Samples,
    /// The picture with reconstructed pixels tinted.
    Measured,
    /// Sampling probability of each pixel.
    Density,
    /// Difference between the reconstruction and the full frame, times four.
    Difference,
}

impl DisplayMode {
    /// All display modes.
    pub const ALL: [Self; 5] =
        [Self::Picture, Self::Samples, Self::Measured, Self::Density, Self::Difference];

    /// Name of the mode.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Samples => "Samples",
            Self::Measured => "Measured",
            Self::Density => "Density",
            Self::Difference => "Difference",
        }
    }

    /// Explanation for a tooltip.
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

/// Frame with the data of all display modes.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// The current picture.
    pub picture: &'a Frame,
    /// Pixels that have been rendered.
    pub measured: &'a SampleMask,
    /// Reconstruction from the first samples.
    pub reconstructed: &'a Frame,
    /// Fovea of the sampling mask.
    pub fovea: &'a Fovea,
}

/// Tint of reconstructed pixels.
const TINT: [f32; 3] = [1.0, 0.45, 0.0];
/// Opacity of the tint.
const TINTED: f32 = 0.4;
/// Colour of pixels without a sample.
const NOTHING: [f32; 3] = [0.06; 3];
/// Factor of displayed differences.
const GAIN: f32 = 4.0;

/// Renders `parts` in the mode `look` as opaque 8-bit RGBA.
pub fn rgba(look: DisplayMode, parts: &Parts<'_>) -> Vec<u8> {
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

fn colour(look: DisplayMode, parts: &Parts<'_>, x: u32, y: u32) -> [f32; 3] {
    let [r, g, b, _] = parts.picture.pixel(x, y);
    let measured = || parts.measured.contains(x, y);
    match look {
        DisplayMode::Picture => [r, g, b],
        DisplayMode::Samples => {
            if measured() {
                [r, g, b]
            } else {
                NOTHING
            }
        }
        DisplayMode::Measured if measured() => [r, g, b],
        DisplayMode::Measured => std::array::from_fn(|c| [r, g, b][c] * (1.0 - TINTED) + TINT[c] * TINTED),
        DisplayMode::Density => {
            let density = parts.fovea.density_at(x, y, parts.picture.size());
            // Base densities of a few per cent are hard to tell apart; the square root spreads them.
            let shade = density.sqrt() as f32;
            [shade, shade * shade, 0.5 * shade]
        }
        DisplayMode::Difference => {
            let [s, h, c, _] = parts.reconstructed.pixel(x, y);
            [r - s, g - h, b - c].map(|d| d.abs() * GAIN)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::FrameSize;

    fn shown(look: DisplayMode) -> Vec<u8> {
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
        assert_eq!(shown(DisplayMode::Picture), [128, 128, 128, 255, 51, 51, 51, 255]);
        assert_eq!(shown(DisplayMode::Samples), [128, 128, 128, 255, 15, 15, 15, 255]);
        let measured = shown(DisplayMode::Measured);
        assert_eq!(measured[..4], [128, 128, 128, 255]);
        assert!(measured[4] > 100 && measured[6] < 60);
        assert_eq!(shown(DisplayMode::Difference)[..3], [0, 0, 0]);
        assert_eq!(shown(DisplayMode::Difference)[4], 102);
        assert_eq!(shown(DisplayMode::Density)[..3], [128, 64, 64]);
    }
}
