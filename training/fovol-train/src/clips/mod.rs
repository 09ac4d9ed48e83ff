//! Training clips: renderings of random volumes along random camera paths.
//!
//! A clip is a crop of 16 consecutive, fully rendered frames. It also stores the guide (colour without shadows and
//! opacity) and the depth of every pixel, and the cameras, so that motion is exact. A clip follows from its seed alone ([`Recipe`]). It is stored in one file
//! ([`Clip::read`]) and belongs to a set whose list says how to make it again ([`ClipSet`]). Sampling masks are drawn
//! anew each time a clip is used.

mod journey;
mod recipe;
mod record;
mod set;
mod transfer;

pub use journey::Journey;
pub use recipe::{Recipe, VolumeSource};
pub use record::record;
pub use set::{ClipSet, Exceptions};

use crate::{Error, Result};
use fovol_core::{Camera, FrameSize, Reprojection, f16};
use fovolnet::io::atomic;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// Default number of frames of a clip.
pub const LENGTH: usize = 16;
/// Default rows and columns of a clip's frames.
pub const SIDE: usize = 256;

/// A crop of consecutive rendered frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Size, place and cameras of the frames.
    pub scenery: Scenery,
    /// RGB of each frame, row by row, as displayed (sRGB), 0…1. The background is black.
    pub frames: Vec<Vec<f16>>,
    /// RGB without shadows, times opacity, and opacity of each frame, row by row, 0…1.
    pub guides: Vec<Vec<f16>>,
    /// One over the distance from the eye to the visible surface, per pixel, in world units; 0 where nothing is
    /// visible.
    pub inverse_distances: Vec<Vec<f16>>,
}

/// Origin and geometry of a clip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scenery {
    /// The seed of the clip.
    pub seed: u64,
    /// The volume that is rendered.
    pub volume: String,
    /// Size of the full frames that the clip is cropped from.
    pub whole: FrameSize,
    /// Top left pixel of the crop in the full frames.
    pub corner: [u32; 2],
    /// Size of the crop.
    pub part: FrameSize,
    /// The GPU that rendered the clip, if one did. Its pixels differ from the CPU's by rounding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gpu: Option<String>,
    /// The camera of each frame.
    pub cameras: Vec<Camera>,
}

impl Clip {
    /// Number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether the clip has no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Reprojection of the crop's pixels from frame `t` to frame `from`.
    pub fn reprojection(&self, t: usize, from: usize) -> Reprojection {
        let Scenery { cameras, whole, corner: [x, y], .. } = &self.scenery;
        Reprojection::new(&cameras[t], &cameras[from], *whole).of_part(*x, *y)
    }

    /// Reads a clip from `path`.
    ///
    /// # Errors
    /// The file cannot be read or is not a clip.
    pub fn read(path: &Path) -> Result<Self> {
        let broken =
            |why: String| Error::Clip(format!("{}: {why}; delete it and make it again", path.display()));
        let packed = fs::read(path).map_err(|e| Error::file("read", path, &e))?;
        let bytes =
            zstd::decode_all(packed.as_slice()).map_err(|e| broken(format!("it is damaged ({e})")))?;
        Self::unpacked(&bytes).map_err(broken)
    }

    fn unpacked(bytes: &[u8]) -> std::result::Result<Self, String> {
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(|e| e.to_string())?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| e.to_string())?;
        let scenery = metadata
            .metadata()
            .as_ref()
            .and_then(|m| m.get(SCENERY))
            .ok_or("it does not say what it shows")?;
        let scenery: Scenery = serde_json::from_str(scenery).map_err(|e| e.to_string())?;
        let (pixels, frames) = (scenery.part.pixels(), scenery.cameras.len());
        let numbers = |name: &str, channels: usize| {
            let data = tensors.tensor(name).map_err(|e| e.to_string())?.data();
            let expected = 2 * channels * pixels * frames;
            if data.len() != expected {
                return Err(format!("`{name}` has {} bytes, not {expected}", data.len()));
            }
            let frame = |bytes: &[u8]| {
                bytes.as_chunks::<2>().0.iter().map(|pair| f16::from_le_bytes(*pair)).collect()
            };
            Ok(data.chunks(2 * channels * pixels).map(frame).collect())
        };
        Ok(Self {
            frames: numbers(FRAMES, 3)?,
            guides: numbers(GUIDES, 4)?,
            inverse_distances: numbers(INVERSE_DISTANCES, 1)?,
            scenery,
        })
    }

    /// Writes the clip to `path` atomically: the file is complete or absent.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let FrameSize { width, height } = self.scenery.part;
        let shape = |channels: usize| vec![self.len(), height as usize, width as usize, channels];
        let bytes = |frames: &[Vec<f16>]| -> Vec<u8> {
            frames.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
        };
        let [colours, guides, distances] =
            [&self.frames, &self.guides, &self.inverse_distances].map(|frames| bytes(frames));
        let view = |channels, data| {
            TensorView::new(Dtype::F16, shape(channels), data).map_err(|e| Error::Clip(e.to_string()))
        };
        let tensors = [
            (FRAMES, view(3, &colours)?),
            (GUIDES, view(4, &guides)?),
            (INVERSE_DISTANCES, view(1, &distances)?),
        ];
        let scenery = serde_json::to_string(&self.scenery).map_err(|e| Error::Clip(e.to_string()))?;
        let metadata = HashMap::from([(SCENERY.to_owned(), scenery)]);
        let bytes =
            safetensors::serialize(tensors, Some(metadata)).map_err(|e| Error::Clip(e.to_string()))?;
        let packed = zstd::encode_all(bytes.as_slice(), 3).map_err(|e| Error::file("write", path, &e))?;
        Ok(atomic::write_bytes(path, &packed)?)
    }
}

/// Key of the [`Scenery`] in the file's metadata.
const SCENERY: &str = "fovolnet.scenery";
/// Names of the tensors in the file.
const FRAMES: &str = "colours";
const GUIDES: &str = "guides";
const INVERSE_DISTANCES: &str = "inverse_distances";

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::OpenDevice;

    pub(super) fn small_clip() -> Clip {
        let recipe = Recipe::draw(5, &VolumeSource::parse("marschner-lobb:24:0").unwrap()).with_part(24, 3);
        record(&recipe, &recipe.source.open().unwrap(), &OpenDevice::Cpu).unwrap()
    }

    #[test]
    fn clips_are_read_as_they_were_written_and_damage_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.zst");
        let clip = small_clip();
        clip.write(&path).unwrap();
        assert_eq!(Clip::read(&path).unwrap(), clip);
        let mut bytes = fs::read(&path).unwrap();
        bytes.truncate(bytes.len() / 2);
        fs::write(&path, bytes).unwrap();
        assert!(Clip::read(&path).unwrap_err().to_string().contains("make it again"));
    }

    #[test]
    fn a_seed_makes_one_clip_and_another_seed_another() {
        assert_eq!(small_clip(), small_clip());
        let source = VolumeSource::parse("marschner-lobb:24:0").unwrap();
        assert_ne!(Recipe::draw(5, &source), Recipe::draw(6, &source));
    }

    #[test]
    fn distances_explain_the_motion() {
        let clip = small_clip();
        let shown = clip.inverse_distances[1].iter().filter(|d| d.to_f32() > 0.0).count();
        assert!(shown > 100, "{shown}");
        let [dx, dy] = clip.reprojection(1, 1).motion(5.0, 5.0, 0.5);
        assert!(dx.abs() < 1e-3 && dy.abs() < 1e-3);
    }
}
