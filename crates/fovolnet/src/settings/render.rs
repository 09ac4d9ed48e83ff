use super::{
    CameraChoice, Choice, CropBox, Density, Guide, Mode, NamedView, NanColour, Orientation, Reconstruction,
    Sampling, ShadowRays, TransferChoice, TransferRange, ValueScale, WeightsChoice,
};
use crate::{Error, Result};
use fovol_core::{
    ClipPlanes, Fovea, FrameSize, GazePath, Integration, Interpolation, Light, Projection, ShadowMode,
    SurfaceShading,
};
use fovol_net::cpu::Precision;
use fovol_net::plan::Named;
use fovol_render::noise::NoiseKind;
use std::ops::Range;

/// Settings of a picture besides the volume, complete and typed. [`Self::default`] has the defaults of the program; flags
/// and sessions become settings by [`crate::RenderOverrides::resolve`].
///
/// ```
/// use fovolnet::RenderSettings;
/// use fovolnet::core::{Camera, ControlPoint, FrameSize, TransferFunction};
///
/// let bone = TransferFunction::new(vec![
///     ControlPoint::new(0.4, [0.9, 0.8, 0.7], 0.0),
///     ControlPoint::new(1.0, [1.0, 1.0, 0.9], 0.8),
/// ])?;
/// let settings = RenderSettings {
///     size: FrameSize::new(320, 240)?,
///     camera: Camera::new([0.0, 0.5, 2.0].into(), [0.0; 3].into(), 35.0)?.into(),
///     transfer_function: bone.into(),
///     ..Default::default()
/// };
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSettings {
    /// Frame size in pixels.
    pub size: FrameSize,
    /// Number of frames.
    pub frames: u32,
    /// Number of the first frame. Cameras, gaze and noise follow the number of a frame.
    pub first_frame: u32,
    /// Camera of every frame.
    pub camera: CameraChoice,
    /// Degrees that a turntable turns over all frames.
    pub turn: f64,
    /// Side that the default view and the turntable look from; `None` for the front.
    pub view: Option<NamedView>,
    /// Orientation of the volume in world space; `None` for patient orientation where the file declares it, else grid.
    pub orientation: Option<Orientation>,
    /// How the camera projects.
    pub projection: Projection,
    /// Values along rays that pixels show.
    pub mode: Mode,
    /// Data value of an isosurface; `None` for one between the two main groups of values.
    pub iso: Option<f64>,
    /// Transfer function.
    pub transfer_function: TransferChoice,
    /// Place of a transfer function in data values; `None` for what its file says.
    pub transfer_range: Option<TransferRange>,
    /// Scale along which values run through the transfer function.
    pub scale: ValueScale,
    /// Appearance of NaN.
    pub nan: NanColour,
    /// Part of the volume that is shown; `None` for all of it.
    pub crop: Option<CropBox>,
    /// Planes that cut away more of it, in world space.
    pub planes: ClipPlanes,
    /// Light, in world space.
    pub light: Light,
    /// Shadow computation.
    pub shadows: ShadowMode,
    /// Shadow rays of each pixel, where shadows are on.
    pub shadow_rays: ShadowRays,
    /// Surface term of the lighting.
    pub shading: SurfaceShading,
    /// Share of ambient light, 0…1.
    pub ambient: f64,
    /// Background: red, green and blue, 0…1.
    pub background: [f64; 3],
    /// Whether the background is left out. Such pictures have alpha and need [`Sampling::Full`].
    pub transparent: bool,
    /// Distance between samples along rays, in voxels.
    pub step: f64,
    /// How values between voxels are found. `auto` is the nearest voxel for label maps.
    pub interpolation: Choice<Interpolation>,
    /// Integration along rays.
    pub integration: Integration,
    /// Method of choosing the pixels that are marched. [`Sampling::Full`] leaves nothing to reconstruct, and the settings
    /// below it without effect.
    pub sampling: Sampling,
    /// Share P_b of pixels sampled away from the gaze, 0…1; see [`Fovea::base`].
    pub pb: f64,
    /// Standard deviation σ of the fovea in image widths; 0 for none.
    pub sigma: f64,
    /// Gaze of every frame.
    pub gaze: GazePath,
    /// Distribution of the samples away from the gaze; see [`Self::density_kind`].
    pub density: Choice<Density>,
    /// Noise that chooses the pixels.
    pub noise: NoiseKind,
    /// Seed of everything random besides the gaze.
    pub seed: u64,
    /// Method of filling sparse frames.
    pub reconstruction: Reconstruction,
    /// Guide of the light ratio; see [`Self::guide_kind`].
    pub guide: Choice<Guide>,
    /// Weights of the network, if the method has one.
    pub weights: WeightsChoice,
    /// Precision of the network.
    pub precision: Precision,
}

impl Default for RenderSettings {
    /// One frame of 1280×720 in the default view, every pixel marched, with shadows.
    fn default() -> Self {
        let Fovea { base, sigma, .. } = Fovea::default();
        Self {
            size: FrameSize::default(),
            frames: 1,
            first_frame: 0,
            camera: CameraChoice::Auto,
            turn: 360.0,
            view: None,
            orientation: None,
            projection: Projection::Perspective,
            mode: Mode::Composite,
            iso: None,
            transfer_function: TransferChoice::Auto,
            transfer_range: None,
            scale: ValueScale::Linear,
            nan: NanColour::Transparent,
            crop: None,
            planes: ClipPlanes::default(),
            light: Light::default(),
            shadows: ShadowMode::On,
            shadow_rays: ShadowRays::Exact,
            shading: SurfaceShading::Flat,
            ambient: 0.3,
            background: [0.0; 3],
            transparent: false,
            step: 0.5,
            interpolation: Choice::Auto,
            integration: Integration::Fine,
            sampling: Sampling::Full,
            pb: base,
            sigma,
            gaze: GazePath::default(),
            density: Choice::Auto,
            noise: NoiseKind::default(),
            seed: 0,
            reconstruction: Reconstruction::default(),
            guide: Choice::Auto,
            weights: WeightsChoice::Usual,
            precision: Precision::default(),
        }
    }
}

impl RenderSettings {
    /// Numbers of the frames to render.
    pub fn frame_numbers(&self) -> Range<u32> {
        self.first_frame..self.first_frame.saturating_add(self.frames)
    }

    /// Fovea of frame `i`.
    ///
    /// # Errors
    /// Invalid densities.
    pub fn fovea(&self, i: u32) -> Result<Fovea> {
        let fovea = Fovea { base: self.pb, sigma: self.sigma, gaze: self.gaze.gaze(i) };
        fovea.check()?;
        Ok(fovea)
    }

    /// Checks that a transparent background goes with every pixel marched.
    pub(crate) fn check_transparency(&self) -> Result<()> {
        if self.transparent && self.sampling != Sampling::Full {
            return Err(Error::Setting(
                "a transparent picture needs every pixel marched, what is reconstructed has no alpha; add --sampling full, or \
                 leave out --transparent"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Guide that frames have. `auto` is a quarter of the pixels where shadows are on and the weights are made for
    /// it: `wnet-fast` and `wnet-paper-ratio`.
    pub fn guide_kind(&self) -> Guide {
        let has_samples_only = self.sampling != Sampling::Full && self.reconstruction != Reconstruction::None;
        match self.guide {
            _ if !has_samples_only => Guide::None,
            Choice::Fixed(guide) => guide,
            Choice::Auto if self.shadows == ShadowMode::On && self.is_made_for_light_ratios() => {
                Guide::Quarter
            }
            Choice::Auto => Guide::None,
        }
    }

    /// Distribution of the samples. `auto` is adaptive where pixels are listed (`compact`) and `wnet-fast` or
    /// `wnet-paper-ratio` fills the frames, else fixed.
    pub fn density_kind(&self) -> Density {
        let is_known = self.sampling == Sampling::Compact && self.reconstruction != Reconstruction::None;
        match self.density {
            _ if !is_known => Density::Fixed,
            Choice::Fixed(density) => density,
            Choice::Auto if self.is_made_for_light_ratios() => Density::Adaptive,
            Choice::Auto => Density::Fixed,
        }
    }

    /// These settings as frames of a GPU take them: with `reject` there is no list of samples, so no guide.
    #[cfg(feature = "gpu")]
    pub(crate) fn on_gpu(&self) -> Self {
        let guide = if self.sampling == Sampling::Reject { Guide::None.into() } else { self.guide };
        Self { guide, ..self.clone() }
    }

    /// Whether the network fills light ratios as well as colours.
    fn is_made_for_light_ratios(&self) -> bool {
        self.reconstruction == Reconstruction::WNet
            && match &self.weights {
                WeightsChoice::Usual => true,
                WeightsChoice::Named(name) => {
                    ["wnet-fast", "wnet-paper-ratio"].iter().any(|made| made.eq_ignore_ascii_case(name))
                }
                WeightsChoice::Random(random) => random.network == Named::WNetFast,
            }
    }

    /// Whether `other` reconstructs the same full frames from the same samples.
    pub(crate) fn reconstructs_as(&self, other: &Self) -> bool {
        let of = |settings: &Self| {
            (
                settings.size,
                settings.sampling == Sampling::Full,
                settings.reconstruction,
                settings.weights.clone(),
                settings.precision,
                settings.guide_kind(),
                settings.density_kind(),
            )
        };
        of(self) == of(other)
    }
}
