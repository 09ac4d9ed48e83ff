use crate::{ClipBox, Light, Result, TransferFunction, Volume};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How the light's way to a sample is taken into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadowMode {
    /// A shadow ray from every sample; the reference.
    #[default]
    On,
    /// Full light everywhere.
    Off,
    /// Read from a grid of half the volume's resolution; cheap, never the reference.
    Cached,
}

/// What multiplies the light besides the shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceShading {
    /// Nothing.
    #[default]
    Flat,
    /// |n·l| with n from central differences over ±1 voxel in world units; 1 where the gradient is zero.
    Gradient,
}

/// How a ray adds up what it passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Integration {
    /// Separate samples, each with the opacity of one step; the paper's marching.
    #[default]
    Plain,
    /// The integral of the transfer function between neighbouring samples; no rings at sharp surfaces.
    Fine,
}

impl std::fmt::Display for Integration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain",
            Self::Fine => "fine",
        })
    }
}

impl std::str::FromStr for Integration {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "plain" => Ok(Self::Plain),
            "fine" => Ok(Self::Fine),
            other => Err(format!("`{other}` is no integration; use plain or fine")),
        }
    }
}

/// How samples are lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// The light.
    pub light: Light,
    /// The share of light that reaches every sample, 0…1.
    pub ambient: f64,
    /// Shadows.
    pub shadows: ShadowMode,
    /// Surface shading.
    pub surface: SurfaceShading,
}

impl Shading {
    /// Whether samples lie in the same shadows with `other`.
    pub fn casts_as(&self, other: &Self) -> bool {
        self.light == other.light && self.shadows == other.shadows
    }
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            light: Light::default(),
            ambient: 0.3,
            shadows: ShadowMode::default(),
            surface: SurfaceShading::default(),
        }
    }
}

/// Everything a ray meets.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What is looked at.
    pub volume: Arc<Volume>,
    /// The part of it that is there; `None` for all.
    pub clip: Option<ClipBox>,
    /// How values become colour and opacity.
    pub transfer_function: TransferFunction,
    /// How samples are lit.
    pub shading: Shading,
    /// What shows through, display RGB 0…1.
    pub background: [f64; 3],
    /// The sampling distance in voxels (of the smallest spacing).
    pub step: f64,
    /// How rays add up what they pass.
    pub integration: Integration,
}

/// A ray takes at most this many samples for each voxel along the three sides of the volume, at a step of one.
const MOST_SAMPLES_A_VOXEL: f64 = 64.0;

impl Scene {
    /// `volume` through `transfer_function` with the default light, black background, half-voxel steps and plain
    /// integration.
    pub fn new(volume: Arc<Volume>, transfer_function: TransferFunction) -> Self {
        Self {
            volume,
            clip: None,
            transfer_function,
            shading: Shading::default(),
            background: [0.0; 3],
            step: 0.5,
            integration: Integration::Plain,
        }
    }

    /// The part of the volume that rays pass.
    pub fn clip_box(&self) -> ClipBox {
        self.clip.unwrap_or_else(|| ClipBox::whole(self.volume.grid()))
    }

    /// The sampling distance that rays take, in voxels (of the smallest spacing).
    ///
    /// It is [`Self::step`] but in volumes of extreme aspect. There the smallest spacing would cut a ray along the long
    /// sides into millions of samples of the same few voxels. So the diagonal has at most 64 samples, at a step of one,
    /// for each voxel along the three sides.
    pub fn marching_step(&self) -> f64 {
        let grid = self.volume.grid();
        let voxels: usize = grid.dims().iter().sum();
        let diagonal = grid.world_extent().length() / grid.smallest_voxel();
        self.step * (diagonal / (MOST_SAMPLES_A_VOXEL * voxels as f64)).max(1.0)
    }

    /// Whether the numbers can be rendered with.
    ///
    /// # Errors
    /// An ambient or background outside [0, 1], a step outside [0.01, 100].
    pub fn check(&self) -> Result<()> {
        let unit = |x: f64| (0.0..=1.0).contains(&x);
        crate::checked(
            "ambient",
            self.shading.ambient,
            "a number between 0 and 1",
            unit(self.shading.ambient),
        )?;
        for c in self.background {
            crate::checked("background", c, "three numbers between 0 and 1", unit(c))?;
        }
        crate::checked(
            "step",
            self.step,
            "a number of voxels between 0.01 and 100",
            (0.01..=100.0).contains(&self.step),
        )?;
        Ok(())
    }
}
