use crate::{ClipBox, Interpolation, Light, RayMode, Result, TransferFunction, Volume};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Shadow computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadowMode {
    /// Shadow ray from every sample; the reference.
    #[default]
    On,
    /// No shadows.
    Off,
    /// Shadows from a precomputed grid of the volume's resolution: fast, but never the reference.
    Cached,
}

/// Surface term of the lighting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceShading {
    /// None: the factor 1.
    #[default]
    Flat,
    /// |n·l| with n from central differences over ±1 voxel in world units; 1 where the gradient is zero.
    Gradient,
}

/// Numerical integration along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Integration {
    /// Point samples, each with the opacity of one step; the paper's method.
    #[default]
    Plain,
    /// Integral of the transfer function between neighbouring samples; avoids rings at sharp surfaces.
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

/// Lighting of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// The light.
    pub light: Light,
    /// Fraction of ambient light, 0…1.
    pub ambient: f64,
    /// Shadow computation.
    pub shadows: ShadowMode,
    /// Surface term.
    pub surface: SurfaceShading,
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

/// Everything that a ray needs to be rendered.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The volume.
    pub volume: Arc<Volume>,
    /// Crop box; `None` for the whole volume.
    pub clip: Option<ClipBox>,
    /// Mapping from values to colour and opacity.
    pub transfer_function: TransferFunction,
    /// Lighting.
    pub shading: Shading,
    /// Background colour, display RGB in 0…1.
    pub background: [f64; 3],
    /// Step along rays, in voxels of the smallest spacing.
    pub step: f64,
    /// Numerical integration along rays.
    pub integration: Integration,
    /// How values between voxels are found.
    pub interpolation: Interpolation,
    /// Values along rays that pixels show.
    pub mode: RayMode,
}

/// Most samples of a ray, at a step of one, per voxel along the three sides of the volume.
const MOST_SAMPLES_A_VOXEL: f64 = 64.0;

impl Scene {
    /// Scene of `volume` and `transfer_function` with the default light, black background, half-voxel steps and plain
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
            interpolation: Interpolation::Linear,
            mode: RayMode::Composite,
        }
    }

    /// Crop box, or the box of the whole volume.
    pub fn clip_box(&self) -> ClipBox {
        self.clip.unwrap_or_else(|| ClipBox::whole(self.volume.grid()))
    }

    /// Effective integration along rays. Between neighbouring voxels of labels there are no values to integrate over, so the
    /// nearest voxels are always point samples.
    pub fn marching_integration(&self) -> Integration {
        match self.interpolation {
            Interpolation::Linear => self.integration,
            Interpolation::Nearest => Integration::Plain,
        }
    }

    /// Effective step along rays, in voxels of the smallest spacing.
    ///
    /// It equals [`Self::step`] except in volumes of extreme aspect. There the smallest spacing would divide a ray
    /// along the long sides into millions of samples of few voxels. So the diagonal gets at most 64 samples, at a
    /// step of one, per voxel along the three sides.
    pub fn marching_step(&self) -> f64 {
        self.step * self.step_stretch()
    }

    /// Factor from [`Self::step`] to [`Self::marching_step`], at least 1. It depends on the volume alone.
    pub fn step_stretch(&self) -> f64 {
        let grid = self.volume.grid();
        let voxels: usize = grid.dims().iter().sum();
        let diagonal = grid.world_extent().length() / grid.smallest_voxel();
        (diagonal / (MOST_SAMPLES_A_VOXEL * voxels as f64)).max(1.0)
    }

    /// Checks that the parameters are valid.
    ///
    /// # Errors
    /// An ambient, background or isosurface outside [0, 1], a step outside [0.01, 100].
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
        if let RayMode::Isosurface(value) = self.mode {
            let value = f64::from(value);
            crate::checked("isosurface", value, "a display value between 0 and 1", unit(value))?;
        }
        Ok(())
    }
}
