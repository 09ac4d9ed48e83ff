use super::overlay::overlay;
#[cfg(feature = "clap")]
use super::parse;
use super::{
    Choice, CropBox, Density, GazeChoice, Guide, Mode, NamedView, NanColour, Orientation, PathChoice,
    Quality, RandomWeights, Reconstruction, Sampling, ShadowRays, StillCamera, TransferChoice, TransferRange,
    ValueScale, as_text,
};
use crate::{Error, Result};
use fovol_core::{FrameSize, Integration, Interpolation, Projection, ShadowMode, SurfaceShading};
use fovol_net::Weights;
use fovol_net::cpu::Precision;
use fovol_render::noise::NoiseKind;
use serde::{Deserialize, Serialize};

overlay! {
/// Settings of a picture besides the volume, as far as they are given. Flags of the command line, the `[render]` table of
/// a session file and the panels of the viewer share them and their names. [`RenderOverrides::resolve`] completes them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct RenderOverrides {
    /// Frame size in pixels [default: 1280x720]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WxH"))]
    pub size: Option<FrameSize>,
    /// Number of frames [default: 1]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..)))]
    pub frames: Option<u32>,
    /// Number of the first frame; cameras and noise follow it [default: 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "T"))]
    pub first_frame: Option<u32>,
    /// Camera path: turntable, orbit, flythrough, or a TOML file of keyframes [default: the default view for one frame,
    /// turntable for more]
    #[cfg_attr(feature = "clap", arg(long, value_name = "PATH", value_parser = parse::file_or::<PathChoice>(), conflicts_with = "camera"))]
    pub path: Option<PathChoice>,
    /// Degrees that the turntable turns over all frames [default: 360]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES", value_parser = parse::number, allow_hyphen_values = true, conflicts_with = "camera"))]
    pub turn: Option<f64>,
    /// Side that the default view and the turntable look from: anterior, posterior, left, right, superior or inferior
    /// [default: the front]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIDE", conflicts_with = "camera"))]
    pub view: Option<NamedView>,
    /// How the volume stands: grid, its axes along x, y, z, or patient, with +x to the patient's left, +y up (superior)
    /// and +z to the front (anterior) [default: patient where the file says how the patient lies, else grid]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub orientation: Option<Orientation>,
    /// A still camera in the world of --orientation: eye, target, vertical field of view in degrees. The box of the
    /// volume is centred at 0 and its longest side is 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "EX,EY,EZ,TX,TY,TZ,FOVY", allow_hyphen_values = true))]
    pub camera: Option<StillCamera>,
    /// How the camera projects: perspective, or orthographic, with parallel rays and a picture as high as at the target
    /// [default: perspective]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub projection: Option<Projection>,
    /// Values along rays that pixels show: composite (all, by the transfer function), mip, minip or average (the
    /// greatest, the least or the mean), or isosurface (the first place that has the value --iso) [default: composite, or
    /// isosurface with --iso]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE"))]
    pub mode: Option<Mode>,
    /// Value of the isosurface, in the values of the file [default: between the two main groups of values]
    #[cfg_attr(feature = "clap", arg(long, value_name = "V", value_parser = parse::number, allow_hyphen_values = true))]
    pub iso: Option<f64>,
    /// Transfer function: auto, a preset or a colour map (`fovolnet info --transfer-functions` lists them), or a file
    /// (our JSON, one of ParaView, 3D Slicer, VTK, vtk.js or Inviwo), with #NAME for one of several. Opacity may depend on
    /// the gradient in our JSON and in files of 3D Slicer, VTK and vtk.js [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME|FILE", value_parser = parse::file_or::<TransferChoice>()))]
    pub tf: Option<TransferChoice>,
    /// Where a transfer function in data values lies: data, at its own values, or stretch, over all values shown
    /// [default: as its file says]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHERE"))]
    pub tf_range: Option<TransferRange>,
    /// How values run along the transfer function: linear or log [default: linear]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SCALE"))]
    pub scale: Option<ValueScale>,
    /// Appearance of NaN: transparent, R,G,B,A (0 to 1 each; A is the opacity of a voxel), or file, as the file of the
    /// transfer function says [default: transparent]
    #[cfg_attr(feature = "clap", arg(long, value_name = "R,G,B,A", allow_hyphen_values = true))]
    pub nan: Option<NanColour>,
    /// The part that is shown, as fractions of the sides of the volume's own grid; the rest is cut away [default:
    /// 0,1,0,1,0,1]
    #[cfg_attr(feature = "clap", arg(long, value_name = "X0,X1,Y0,Y1,Z0,Z1", allow_hyphen_values = true))]
    pub clip: Option<CropBox>,
    /// A plane in the world of --orientation that keeps the side where NX·x + NY·y + NZ·z is at least D; up to 6 times
    #[cfg_attr(feature = "clap", arg(long, value_name = "NX,NY,NZ,D", value_parser = parse::numbers::<4>, allow_hyphen_values = true))]
    pub clip_plane: Option<Vec<[f64; 4]>>,
    /// Direction from the scene towards the light, in the world of --orientation [default: 0.5,1,0.3]
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", value_parser = parse::numbers::<3>, allow_hyphen_values = true))]
    pub light: Option<[f64; 3]>,
    /// Shadows: on, off or cached [default: on]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE", value_parser = shadows))]
    pub shadows: Option<ShadowMode>,
    /// Shadow rays of each pixel where shadows are on: exact (one from every sample), or a number, from samples chosen at
    /// random by their light; 16 look almost the same and take a fraction of the time [default: exact]
    #[cfg_attr(feature = "clap", arg(long, value_name = "exact|K"))]
    #[serde(with = "as_text")]
    pub shadow_rays: Option<ShadowRays>,
    /// Surface shading: flat or gradient [default: flat]
    #[cfg_attr(feature = "clap", arg(long, value_name = "MODE", value_parser = shading))]
    pub shading: Option<SurfaceShading>,
    /// Share of ambient light, 0 to 1 [default: 0.3]
    #[cfg_attr(feature = "clap", arg(long, value_name = "A", value_parser = parse::number, allow_hyphen_values = true))]
    pub ambient: Option<f64>,
    /// Background colour, 0 to 1 each [default: 0,0,0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "R,G,B", value_parser = parse::colour, allow_hyphen_values = true))]
    pub background: Option<[f64; 3]>,
    /// Leave the background out: pictures with alpha, for which every pixel is marched (--sampling full)
    #[cfg_attr(feature = "clap", arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true"))]
    pub transparent: Option<bool>,
    /// Distance between samples along rays, in voxels [default: 0.5]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", value_parser = parse::number, allow_hyphen_values = true))]
    pub step: Option<f64>,
    /// How values between voxels are found: linear, nearest (the nearest voxel, for labels, which are then integrated as
    /// --integration plain does), or auto: nearest for label maps, never for mip, minip and average [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    #[serde(with = "as_text")]
    pub interpolation: Option<Choice<Interpolation>>,
    /// Integration along rays: fine, the integral of the transfer function between samples, without rings, or plain,
    /// separate samples [default: fine]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub integration: Option<Integration>,
    /// Which pixels are marched and how: full, reject, direct, compact, or auto: compact for clips and wherever a flag
    /// asks for sparse pixels or a reconstruction, else full [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    #[serde(with = "as_text")]
    pub sampling: Option<Choice<Sampling>>,
    /// Share of pixels sampled away from the gaze, 0 to 1 [default: 0.03]
    #[cfg_attr(feature = "clap", arg(long, value_name = "P", value_parser = parse::number, allow_hyphen_values = true))]
    pub pb: Option<f64>,
    /// Standard deviation of the fovea in image widths; 0 for none [default: 0.02]
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", value_parser = parse::number, allow_hyphen_values = true))]
    pub sigma: Option<f64>,
    /// Gaze as fractions of the image from its top left, `wander`, or a TOML file of stops [default: 0.5,0.5]
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y", value_parser = parse::file_or::<GazeChoice>(), allow_hyphen_values = true))]
    pub gaze: Option<GazeChoice>,
    /// Where samples go away from the gaze: fixed (the same everywhere, as the paper), adaptive (more where the last frame
    /// needs them, as many in all), or auto: adaptive where wnet-fast fills the frames [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHERE"))]
    #[serde(with = "as_text")]
    pub density: Option<Choice<Density>>,
    /// Noise that chooses the pixels: stbn, blue or uniform [default: stbn]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND"))]
    #[serde(with = "as_text")]
    pub noise: Option<NoiseKind>,
    /// Seed of everything random [default: 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub seed: Option<u64>,
    /// How sparse frames are filled: none, pull-push, linear, wnet or deepfovea [default: the network of the weights
    /// that are given, else wnet]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub reconstruct: Option<Reconstruction>,
    /// Pixels that are marched without shadow rays, so that only the light ratio is reconstructed: none (colours, as the
    /// paper), quarter, full, cached (a quarter with cached shadows), or auto: a quarter where shadows are on and wnet-fast fills the frames [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHICH"))]
    #[serde(with = "as_text")]
    pub guide: Option<Choice<Guide>>,
    /// Weights of the network: wnet-fast, which the program has, a safetensors file, or a state dict of PyTorch (.pt) of
    /// a network with a name [default: wnet-fast for wnet]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME|FILE", value_parser = parse::file()))]
    pub weights: Option<String>,
    /// Seeded random weights of a network, to measure its speed
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME[:SEED]"))]
    #[serde(with = "as_text")]
    pub random_weights: Option<RandomWeights>,
    /// Precision of the network: auto, f32, bf16, f16 (on GPUs), int8 or mixed [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "P"))]
    #[serde(with = "as_text")]
    pub precision: Option<Precision>,
    /// Who decides how frames are made: fixed, the flags as written, or auto, a planner. It decides what is not given of
    /// --sampling, --reconstruct, --weights, --guide, --shadows and --shadow-rays, and the size before frames are enlarged
    /// [default: auto with --budget, else fixed]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHO"))]
    #[serde(with = "as_text")]
    pub quality: Option<Quality>,
    /// Milliseconds that a frame may take; without, frames planned by --quality auto take no more work than the flags ask for
    #[cfg_attr(feature = "clap", arg(long, value_name = "MS", value_parser = parse::number))]
    pub budget: Option<f64>,
}
}

impl RenderOverrides {
    /// Combines these settings with `over`, which takes precedence.
    #[must_use]
    pub fn overridden_by(mut self, over: Self) -> Self {
        // A path replaces a still camera, and the other way round.
        if over.path.is_some() || over.camera.is_some() {
            (self.path, self.camera) = (None, None);
        }
        // Weights and a reconstruction replace each other. Marching all pixels replaces both.
        if over.names_weights() {
            (self.weights, self.random_weights, self.reconstruct) = (None, None, None);
        }
        if over.reconstruct.is_some_and(|how| how != self.reconstruction()) {
            (self.weights, self.random_weights) = (None, None);
        }
        // A side to look from replaces a camera, which would hide it.
        if over.view.is_some() || over.turn.is_some() {
            self.camera = None;
        }
        if over.camera.is_some() {
            (self.view, self.turn) = (None, None);
        }
        // The value of a surface and other modes replace each other.
        if over.mode.is_some_and(|mode| mode != Mode::Isosurface) {
            self.iso = None;
        }
        if over.iso.is_some() {
            self.mode = None;
        }
        // A budget is for planned frames.
        if over.budget.is_some() {
            self.quality = None;
        }
        if over.quality.is_some() {
            self.budget = None;
        }
        self.laid_under(over)
    }

    /// Mode of the picture: the given one, else an isosurface where its value is given.
    pub fn mode(&self) -> Mode {
        self.mode.unwrap_or(if self.iso.is_some() { Mode::Isosurface } else { Mode::Composite })
    }

    /// Method of choosing pixels: the given one, else compact where another setting needs sparse pixels, else full.
    pub fn sampling(&self) -> Sampling {
        let chosen = self.sampling.and_then(Choice::fixed);
        chosen.unwrap_or(if self.asks_for_sparse_pixels() { Sampling::Compact } else { Sampling::Full })
    }

    /// Whether another setting than `sampling` asks for sparse pixels: several frames, or a setting that needs them.
    fn asks_for_sparse_pixels(&self) -> bool {
        self.frames.is_some_and(|frames| frames > 1)
            || self.pb.is_some()
            || self.sigma.is_some()
            || self.gaze.is_some()
            || self.noise.is_some()
            || self.density.and_then(Choice::fixed).is_some_and(|density| density == Density::Adaptive)
            || self.guide.and_then(Choice::fixed).is_some_and(|guide| guide != Guide::None)
            || self.reconstruct.is_some_and(|how| how != Reconstruction::None)
            || self.names_weights()
    }

    /// Whether weights are named, from a file or random ones.
    fn names_weights(&self) -> bool {
        self.weights.is_some() || self.random_weights.is_some()
    }

    /// Method of filling sparse frames: the given one, else the network of the named weights, else our own network. Reads
    /// the file of weights if only that is given.
    pub fn reconstruction(&self) -> Reconstruction {
        self.reconstruct.unwrap_or_else(|| match (self.random_weights, self.weights.as_deref()) {
            (Some(random), _) => Reconstruction::by(&random.network.config()),
            (None, Some(weights)) => Reconstruction::of_weights(weights),
            (None, None) => Reconstruction::default(),
        })
    }

    /// Checks that the flags of one command line fit together. Session files may hold more than their pictures need.
    ///
    /// # Errors
    /// [`Error::Contradiction`]; weights that are neither a known name nor a file.
    pub fn check_flags(&self) -> Result<()> {
        if self.weights.is_some() && self.random_weights.is_some() {
            return Err(contradiction("--weights and --random-weights exclude each other; give one"));
        }
        if let Some(weights) = self.weights.as_deref() {
            Weights::named_or_read(weights)?;
        }
        let network = Self { reconstruct: None, ..self.clone() }.reconstruction();
        if let Some(how) = self.reconstruct.filter(|&how| self.names_weights() && how != network) {
            return Err(contradiction(format!(
                "the weights are of another reconstruction than --reconstruct {how}; leave it out, or write --reconstruct {network}"
            )));
        }
        let is_full = self.sampling == Some(Sampling::Full.into());
        let reconstructs = self.reconstruct.is_some_and(|how| how != Reconstruction::None);
        if is_full && (reconstructs || self.names_weights()) {
            return Err(contradiction(
                "--sampling full marches every pixel and leaves nothing to reconstruct; leave out either it or --reconstruct and weights",
            ));
        }
        if self.iso.is_some() && self.mode() != Mode::Isosurface {
            return Err(contradiction(format!(
                "--iso is for --mode isosurface, not {}; leave out one of them",
                self.mode()
            )));
        }
        self.limit()?;
        let leaves_turntable = self.path.as_ref().is_some_and(|path| *path != PathChoice::Turntable);
        if self.turn.is_some() && leaves_turntable {
            return Err(contradiction("--turn is for --path turntable; leave out one of them"));
        }
        if self.view.is_some() && leaves_turntable {
            return Err(contradiction(
                "--view is for the default view and --path turntable; leave out one of them",
            ));
        }
        Ok(())
    }
}

fn contradiction(problem: impl Into<String>) -> Error {
    Error::Contradiction(problem.into())
}

#[cfg(feature = "clap")]
fn shadows(text: &str) -> std::result::Result<ShadowMode, String> {
    match text {
        "on" => Ok(ShadowMode::On),
        "off" => Ok(ShadowMode::Off),
        "cached" => Ok(ShadowMode::Cached),
        other => Err(format!("`{other}` is no shadow mode; use on, off or cached")),
    }
}

#[cfg(feature = "clap")]
fn shading(text: &str) -> std::result::Result<SurfaceShading, String> {
    match text {
        "flat" => Ok(SurfaceShading::Flat),
        "gradient" => Ok(SurfaceShading::Gradient),
        other => Err(format!("`{other}` is no shading; use flat or gradient")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given() -> RenderOverrides {
        RenderOverrides {
            pb: Some(0.1),
            sigma: Some(0.2),
            path: Some(PathChoice::Orbit),
            weights: Some("wnet-paper".into()),
            ..RenderOverrides::default()
        }
    }

    #[test]
    fn what_is_not_given_stays() {
        assert_eq!(given().overridden_by(RenderOverrides::default()), given());
        assert_eq!(RenderOverrides::default().overridden_by(given()), given());
        let over = RenderOverrides { pb: Some(0.3), ..RenderOverrides::default() };
        assert_eq!(given().overridden_by(over), RenderOverrides { pb: Some(0.3), ..given() });
    }

    #[test]
    fn cameras_and_paths_replace_each_other() {
        let camera = Some([0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 35.0].into());
        let still = given().overridden_by(RenderOverrides { camera, ..RenderOverrides::default() });
        assert_eq!((still.camera, &still.path), (camera, &None));
        let view = RenderOverrides { view: Some(NamedView::Left), ..RenderOverrides::default() };
        assert_eq!(still.clone().overridden_by(view).camera, None);
        let path = RenderOverrides { path: Some(PathChoice::Turntable), ..RenderOverrides::default() };
        assert_eq!(still.overridden_by(path).camera, None);
    }

    #[test]
    fn modes_and_values_of_surfaces_replace_each_other() {
        let of = |mode, iso| RenderOverrides { mode, iso, ..RenderOverrides::default() };
        let surface = of(None, Some(3.0));
        assert_eq!((surface.mode(), RenderOverrides::default().mode()), (Mode::Isosurface, Mode::Composite));
        assert_eq!(surface.clone().overridden_by(of(Some(Mode::Mip), None)), of(Some(Mode::Mip), None));
        assert_eq!(of(Some(Mode::Mip), None).overridden_by(surface.clone()), surface);
        let named = surface.clone().overridden_by(of(Some(Mode::Isosurface), None));
        assert_eq!((named.mode(), named.iso), (Mode::Isosurface, Some(3.0)));
        assert!(of(Some(Mode::Mip), Some(3.0)).check_flags().unwrap_err().to_string().contains("--iso"));
        assert!(named.check_flags().is_ok());
    }

    #[test]
    fn weights_and_reconstructions_replace_each_other() {
        let linear =
            RenderOverrides { reconstruct: Some("linear".parse().unwrap()), ..RenderOverrides::default() };
        let linear = given().overridden_by(linear);
        assert_eq!(linear.weights, None);
        let random = RenderOverrides {
            random_weights: Some("deepfovea-fvn:3".parse().unwrap()),
            ..RenderOverrides::default()
        };
        assert_eq!(linear.overridden_by(random).reconstruction(), Reconstruction::DeepFovea);
    }
}
