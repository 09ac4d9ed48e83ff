use crate::layer::{Layer, MOST_VOLUMES, VoxelColours, check_dims};
use crate::{ClipBox, Error, Interpolation, Light, RayMode, Result, TransferFunction, Volume};
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
    /// Colours of the voxels, which take the place of the transfer function's.
    pub colours: Option<VoxelColours>,
    /// Further volumes at the same points, at most three.
    pub layers: Vec<Layer>,
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
            colours: None,
            layers: Vec::new(),
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
    /// nearest voxels are always point samples. So are several volumes, voxels with colours of their own, and opacities
    /// that depend on the gradient.
    pub fn marching_integration(&self) -> Integration {
        match self.interpolation {
            Interpolation::Linear if !self.is_layered() && !self.has_gradient_opacity() => self.integration,
            _ => Integration::Plain,
        }
    }

    /// Whether samples blend several volumes, or have colours of their own.
    pub fn is_layered(&self) -> bool {
        self.colours.is_some() || !self.layers.is_empty()
    }

    /// Whether the opacity of any volume depends on the gradient of its values. Only [`RayMode::Composite`] shows that:
    /// projections and isosurfaces ignore it.
    pub fn has_gradient_opacity(&self) -> bool {
        let others = self.layers.iter().map(|layer| &layer.transfer_function);
        let mut all = std::iter::once(&self.transfer_function).chain(others);
        self.mode == RayMode::Composite && all.any(|transfer| transfer.gradient_opacity().is_some())
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
    /// An ambient, background or isosurface outside [0, 1], a step outside [0.01, 100]; volumes that cannot be shown
    /// together, or not in this mode.
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
        self.check_layers()
    }

    fn check_layers(&self) -> Result<()> {
        if self.layers.len() >= MOST_VOLUMES {
            return Err(Error::Layers(format!(
                "at most {MOST_VOLUMES} can be shown, not {}",
                self.layers.len() + 1
            )));
        }
        let own = self.colours.iter().flatten();
        let others = self
            .layers
            .iter()
            .flat_map(|layer| std::iter::once(&layer.volume).chain(layer.colours.iter().flatten()));
        check_dims(own.chain(others), self.volume.grid())?;
        let have_colours = self.colours.is_some() || self.layers.iter().any(|layer| layer.colours.is_some());
        match self.mode {
            RayMode::Isosurface(_) if self.is_layered() => Err(Error::Layers(
                "an isosurface is that of one volume; choose --mode composite, or show one volume and one component".into(),
            )),
            mode if mode.is_projection() && have_colours => Err(Error::Layers(
                "voxels with colours have no greatest, least or mean value; choose --mode composite, or one --component"
                    .into(),
            )),
            _ => Ok(()),
        }
    }
}
