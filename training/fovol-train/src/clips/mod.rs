//! Clips to learn from: what the renderer shows of random volumes on random journeys.
//!
//! A clip is a part of 16 consecutive frames with every pixel marched, and what the marcher knows besides: how far away
//! what shows is, and the cameras, so that the motion is exact. It is made from its seed alone ([`Recipe`]), kept in a
//! file ([`Clip::read`]), and belongs to a set whose list says how to make it again ([`ClipSet`]). Which pixels a
//! network gets to see of it is drawn anew whenever it is used.

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

/// Frames of a clip, unless said otherwise.
pub const LENGTH: usize = 16;
/// Rows and columns of its frames.
pub const SIDE: usize = 256;

/// A part of consecutive frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// What the clip shows besides its pixels.
    pub scenery: Scenery,
    /// Red, green and blue of each frame, row by row, as displayed.
    pub frames: Vec<Vec<u8>>,
    /// For each pixel one over the distance of what shows from the eye, in world units; 0 where nothing does.
    pub inverse_distances: Vec<Vec<f16>>,
}

/// Where the pixels of a clip lie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scenery {
    /// The number it was made from.
    pub seed: u64,
    /// The volume that it shows.
    pub volume: String,
    /// Width and height of the frames that it is a part of.
    pub whole: FrameSize,
    /// The pixel of these that is its top left one.
    pub corner: [u32; 2],
    /// Width and height of the part.
    pub part: FrameSize,
    /// The graphics processor that rendered it, if one did: its pixels differ from the processor's by rounding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gpu: Option<String>,
    /// What each frame is seen from.
    pub cameras: Vec<Camera>,
}

impl Clip {
    /// How many frames it has.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// How pixels of frame `t` of the part move to frame `from`.
    pub fn reprojection(&self, t: usize, from: usize) -> Reprojection {
        let Scenery { cameras, whole, corner: [x, y], .. } = &self.scenery;
        Reprojection::new(&cameras[t], &cameras[from], *whole).of_part(*x, *y)
    }

    /// Reads a clip from `path`.
    ///
    /// # Errors
    /// A file that cannot be read, or holds no clip.
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
        let data = |name: &str, bytes_per_pixel: usize| {
            let data = tensors.tensor(name).map_err(|e| e.to_string())?.data();
            let expected = pixels * bytes_per_pixel * frames;
            (data.len() == expected)
                .then_some(data)
                .ok_or(format!("`{name}` has {} bytes, not {expected}", data.len()))
        };
        let colours = data("frames", 3)?;
        let distances = data("inverse_distances", 2)?;
        let half = |pair: &[u8]| f16::from_le_bytes([pair[0], pair[1]]);
        Ok(Self {
            frames: colours.chunks(3 * pixels).map(<[u8]>::to_vec).collect(),
            inverse_distances: distances
                .chunks(2 * pixels)
                .map(|frame| frame.chunks(2).map(half).collect())
                .collect(),
            scenery,
        })
    }

    /// Writes the clip to `path`: complete, or not at all.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let FrameSize { width, height } = self.scenery.part;
        let shape = |channels: usize| vec![self.len(), height as usize, width as usize, channels];
        let colours = self.frames.concat();
        let distances: Vec<u8> =
            self.inverse_distances.iter().flatten().flat_map(|d| d.to_le_bytes()).collect();
        let view = |dtype, channels, data| {
            TensorView::new(dtype, shape(channels), data).map_err(|e| Error::Clip(e.to_string()))
        };
        let tensors = [
            ("frames", view(Dtype::U8, 3, &colours)?),
            ("inverse_distances", view(Dtype::F16, 1, &distances)?),
        ];
        let scenery = serde_json::to_string(&self.scenery).map_err(|e| Error::Clip(e.to_string()))?;
        let metadata = HashMap::from([(SCENERY.to_owned(), scenery)]);
        let bytes =
            safetensors::serialize(tensors, Some(metadata)).map_err(|e| Error::Clip(e.to_string()))?;
        let packed = zstd::encode_all(bytes.as_slice(), 3).map_err(|e| Error::file("write", path, &e))?;
        Ok(atomic::write_bytes(path, &packed)?)
    }
}

/// Where files say what they show.
const SCENERY: &str = "fovolnet.scenery";

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
