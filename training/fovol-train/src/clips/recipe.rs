use super::journey::Journey;
use super::transfer::random_transfer;
use super::{LENGTH, SIDE};
use crate::{Error, Result};
use fovol_core::{
    CameraPath, FrameSize, Integration, Light, Scene, Shading, ShadowMode, SurfaceShading, path_of_text,
    text_of_path,
};
use fovolnet::{OpenVolume, VolumeSettings, open_volume, presets};
use glam::DVec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// Source of a volume.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VolumeSource {
    /// Procedural volume: name, voxels along each side, seed.
    Procedural(String, usize, u64),
    /// File or folder.
    File(PathBuf),
}

impl fmt::Display for VolumeSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Procedural(name, side, seed) => write!(f, "{name}:{side}:{seed}"),
            Self::File(path) => f.write_str(&text_of_path(path)),
        }
    }
}

impl VolumeSource {
    /// Parses `NAME:SIDE:SEED` of a procedural volume, or a path.
    ///
    /// # Errors
    /// A side or seed that is no number.
    pub fn parse(text: &str) -> Result<Self> {
        let parts: Vec<&str> = text.split(':').collect();
        let [name, side, seed] = parts[..] else { return Ok(Self::File(path_of_text(text).into_owned())) };
        if name.parse::<fovolnet::io::procedural::Procedural>().is_err() {
            return Ok(Self::File(path_of_text(text).into_owned()));
        }
        let wrong =
            |_| Error::Clip(format!("`{text}` names no volume; write NAME:SIDE:SEED, as in head:128:7"));
        Ok(Self::Procedural(name.into(), side.parse().map_err(wrong)?, seed.parse().map_err(wrong)?))
    }

    /// Opens or generates the volume.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(&self) -> Result<OpenVolume> {
        match self {
            Self::File(path) => Ok(open_volume(&text_of_path(path), &VolumeSettings::default())?),
            Self::Procedural(name, side, seed) => {
                let kind = name.parse().map_err(|e| Error::Clip(format!("{e}")))?;
                let volume = fovolnet::io::procedural::make(kind, [*side; 3], *seed);
                let volume = Arc::new(volume.map_err(|e| Error::Clip(e.to_string()))?);
                Ok(OpenVolume { procedural: Some(kind), ..OpenVolume::of(volume, name) })
            }
        }
    }
}

/// Everything that determines a clip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Seed of all random choices.
    pub seed: u64,
    /// The volume.
    pub source: VolumeSource,
    /// Rows and columns of the crop.
    pub side: u32,
    /// Number of frames.
    pub length: usize,
    /// How views are chosen.
    #[serde(default)]
    pub course: Course,
}

/// How the views of a volume are chosen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// Random transfer function, light, camera path, frame size and crop.
    #[default]
    Drawn,
    /// The paper's data: full frames of 800² pixels along a fly-through around the volume, with the program's default
    /// transfer function and light. The number is the clip's place along the fly-through.
    FlyThrough(usize),
}

/// Rows and columns of the frames of a fly-through.
const WHOLE: u32 = 800;

/// Heights of the full frames that clips are cropped from. Widths are 16/9 of these.
const HEIGHTS: [u32; 4] = [480, 720, 720, 1080];

impl Recipe {
    /// Recipe with random views of the volume of `source`, drawn from `seed`.
    pub fn draw(seed: u64, source: &VolumeSource) -> Self {
        Self { seed, source: source.clone(), side: SIDE as u32, length: LENGTH, course: Course::Drawn }
    }

    /// Recipe of clip number `place` along the fly-through around the volume of `source`.
    pub fn fly_through(seed: u64, source: &VolumeSource, place: usize) -> Self {
        let course = Course::FlyThrough(place);
        Self { seed, source: source.clone(), side: WHOLE, length: LENGTH, course }
    }

    /// Sets the crop to `side`² pixels and the length to `length` frames.
    #[must_use]
    pub fn with_part(self, side: u32, length: usize) -> Self {
        Self { side, length, ..self }
    }

    /// Draws attempt number `attempt`. Attempts that show next to nothing are repeated with the next number.
    pub(super) fn attempt(&self, volume: &OpenVolume, attempt: u64) -> Result<Attempt> {
        if let Course::FlyThrough(place) = self.course {
            let frames = (place * self.length..).take(self.length);
            return Ok(Attempt {
                scene: Scene::new(volume.volume.clone(), presets::find("auto", volume)?),
                whole: FrameSize::new(self.side, self.side)?,
                corner: [0; 2],
                cameras: frames.map(|frame| CameraPath::Flythrough.camera(frame as u32)).collect(),
            });
        }
        let random = &mut ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(attempt);
        let transfer = match random.random::<f64>() {
            x if x < 0.35 => presets::find("auto", volume)?,
            _ => random_transfer(random, &volume.volume.histogram(256, volume.volume.range()))?,
        };
        let mut scene = Scene::new(volume.volume.clone(), transfer);
        scene.step = [0.5, 0.5, 0.75, 1.0][random.random_range(0..4)];
        scene.shading = shading(random)?;
        scene.integration = Integration::Plain;
        let height = HEIGHTS[random.random_range(0..HEIGHTS.len())].max(self.side);
        let whole = FrameSize::new(height * 16 / 9, height)?;
        let journey = Journey::draw(random, self.length);
        let corner = [whole.width, whole.height].map(|side| {
            // The sum of two uniform numbers favours crops near the middle, where the volume is.
            let free = f64::from(side - self.side);
            (free * 0.5 * (random.random::<f64>() + random.random::<f64>())) as u32
        });
        Ok(Attempt { scene, whole, corner, cameras: journey.cameras(self.length) })
    }
}

/// Candidate for a clip; it may turn out to show nothing.
pub(super) struct Attempt {
    pub scene: Scene,
    pub whole: FrameSize,
    pub corner: [u32; 2],
    pub cameras: Vec<fovol_core::Camera>,
}

fn shading(random: &mut impl Rng) -> Result<Shading> {
    let [x, y, z] = [(); 3].map(|()| random.random::<f64>() * 2.0 - 1.0);
    let from_above = random.random::<f64>() < 0.8;
    let y = if from_above { y.abs() + 0.2 } else { y };
    let surface = if random.random::<f64>() < 0.4 { SurfaceShading::Gradient } else { SurfaceShading::Flat };
    // Cached shadows look nearly as good and cost far less.
    let shadows = match random.random::<f64>() {
        x if x < 0.35 => ShadowMode::On,
        x if x < 0.9 => ShadowMode::Cached,
        _ => ShadowMode::Off,
    };
    Ok(Shading {
        light: Light::towards(DVec3::new(x, y, z + 1e-3))?,
        ambient: 0.1 + 0.4 * random.random::<f64>(),
        shadows,
        surface,
    })
}
