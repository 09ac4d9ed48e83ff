//! Noise for drawing sampling masks.

use crate::{Error, Result};
use fovolnet::render::noise::{FrameNoise, Noise, NoiseKind, NoiseSize, STBN_SEED, ranks};
use serde::{Deserialize, Serialize};

/// Period of the noise in frames.
const FRAMES: usize = NoiseSize::STBN.frames;

/// Choice of the mask noise; by default the program's own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct NoiseConfig {
    /// `stbn`, `blue` or `uniform`.
    pub kind: NoiseKind,
    /// Side of the noise tile that repeats over the frame, 16…256 pixels. Sizes other than the program's 128 exist
    /// only for spatio-temporal noise. They are generated anew, in seconds for 64 and minutes for 256.
    pub tile: usize,
}

impl Default for NoiseConfig {
    fn default() -> Self {
        Self { kind: NoiseKind::Stbn, tile: NoiseSize::STBN.width }
    }
}

/// Noise ranks of the pixels of every frame.
pub(crate) enum MaskNoise {
    /// The program's own noise.
    Carried(Noise),
    /// Spatio-temporal noise of another tile size.
    Made { size: NoiseSize, ranks: Vec<u32> },
}

impl MaskNoise {
    /// Loads or generates the noise of `config`.
    ///
    /// # Errors
    /// Tile sizes that cannot be made.
    pub fn new(config: &NoiseConfig) -> Result<Self> {
        if config.tile == NoiseSize::STBN.width {
            return Ok(Self::Carried(Noise::new(config.kind, 0)));
        }
        if config.kind != NoiseKind::Stbn {
            return Err(Error::Config(format!(
                "`lesson.noise` is {} in tiles of {}; only stbn is made in other tiles than {}",
                config.kind,
                config.tile,
                NoiseSize::STBN.width
            )));
        }
        let size = NoiseSize::new(config.tile, config.tile, FRAMES).map_err(Error::Config)?;
        Ok(Self::Made { size, ranks: ranks(size, STBN_SEED) })
    }

    /// Noise of frame `t`.
    pub fn frame(&self, t: u32) -> MaskNoiseFrame<'_> {
        match self {
            Self::Carried(noise) => MaskNoiseFrame::Carried(noise.frame(t)),
            Self::Made { size, ranks } => {
                let slice = t as usize % size.frames * size.frame_len();
                MaskNoiseFrame::Made { size: *size, ranks: &ranks[slice..][..size.frame_len()] }
            }
        }
    }
}

/// Noise ranks of the pixels of one frame.
pub(crate) enum MaskNoiseFrame<'a> {
    Carried(FrameNoise<'a>),
    Made { size: NoiseSize, ranks: &'a [u32] },
}

impl MaskNoiseFrame<'_> {
    /// Threshold (rank + ½) / levels of pixel (`x`, `y`). A pixel is sampled if this is below the density.
    pub fn threshold(&self, x: u32, y: u32) -> f64 {
        let (rank, levels) = match self {
            Self::Carried(noise) => (noise.rank(x, y), noise.levels() as usize),
            Self::Made { size, ranks } => {
                (ranks[y as usize % size.height * size.width + x as usize % size.width], size.len())
            }
        };
        (f64::from(rank) + 0.5) / levels as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_even_whatever_the_tile() {
        for (kind, tile) in [(NoiseKind::Stbn, 128), (NoiseKind::Stbn, 16), (NoiseKind::Uniform, 128)] {
            let noise = MaskNoise::new(&NoiseConfig { kind, tile }).unwrap();
            let places = (0..64 * 64u32).map(|i| noise.frame(3).threshold(i % 64, i / 64));
            let below = places.filter(|&threshold| threshold < 0.25).count() as f64 / 4096.0;
            assert!((below - 0.25).abs() < 0.03, "{kind} {tile}: {below}");
        }
        let small = MaskNoise::new(&NoiseConfig { kind: NoiseKind::Stbn, tile: 16 }).unwrap();
        assert_eq!(small.frame(1).threshold(3, 5), small.frame(65).threshold(19, 37));
    }

    #[test]
    fn what_cannot_be_made_is_said() {
        for (kind, tile) in [(NoiseKind::Blue, 64), (NoiseKind::Stbn, 8)] {
            assert!(MaskNoise::new(&NoiseConfig { kind, tile }).is_err());
        }
    }
}
