//! Sparse frames of any renderer, with their motion, in a folder.

use crate::console;
use crate::frame_sequence::{self, file_name, number};
use anyhow::{Context, Result, bail};
use fovolnet::core::{Frame, FrameSize, SparseFrame};
use fovolnet::guide::UpsampledGuide;
use fovolnet::io::image::{self, Picture};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Tolerance for colours outside 0 to 1, which rounding may cause.
const ROUNDING: f32 = 1e-3;

/// Folder of sparse frames, all of one size.
pub struct SparseSequence {
    frames: Vec<PathBuf>,
    /// Files of motion by frame numbers.
    motion: BTreeMap<String, PathBuf>,
    /// Files of guides by frame numbers.
    guides: BTreeMap<String, PathBuf>,
    size: FrameSize,
    /// Printed notes. Each is printed once, for the first file that it concerns.
    said: BTreeSet<String>,
}

impl SparseSequence {
    /// Checks the names and sizes of all frames in `folder`.
    ///
    /// # Errors
    /// No frames, two frames with the same number, frames of different sizes, files that are not pictures.
    pub fn open(folder: &Path) -> Result<Self> {
        let frames = frame_sequence::pictures_named(folder, "sparse_")?;
        if let Some(gaps) = frame_sequence::gaps(&frames, "sparse_") {
            console::note(format!("{}: {gaps}", folder.display()));
        }
        let first = frames.first().context("there are no frames")?;
        let size = image::size(first)?;
        for path in &frames {
            let found = image::size(path)?;
            if found != size {
                bail!(
                    "{} is of {found} and {} of {size}; give frames of one size",
                    path.display(),
                    file_name(first)
                );
            }
        }
        let [motion, guides] = [beside(folder, "motion_")?, beside(folder, "guide_")?];
        let sequence = Self { frames, motion, guides, size, said: BTreeSet::new() };
        sequence.check_guides()?;
        Ok(sequence)
    }

    /// # Errors
    /// Guides of some frames only: light ratios cannot follow colours.
    fn check_guides(&self) -> Result<()> {
        let lacking = self.frames.iter().find(|path| !self.guides.contains_key(&number(path, "sparse_")));
        match lacking {
            Some(path) if !self.guides.is_empty() => bail!(
                "{} has no guide beside it, as others have; give every frame a guide_NUMBER.exr, or none",
                path.display()
            ),
            _ => Ok(()),
        }
    }

    /// Whether frames have a guide.
    pub fn has_guide(&self) -> bool {
        !self.guides.is_empty()
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// File of frame `i`.
    pub fn path(&self, i: usize) -> &Path {
        &self.frames[i]
    }

    /// Size of all frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Notes that `how` does not use the motion in the folder, if there is any.
    pub fn leave_motion_out(&mut self, how: &str) {
        if let Some(path) = self.motion.values().next().cloned() {
            self.note(&path, &format!("motion is not used by {how}"));
        }
    }

    /// Reads frame `i`.
    ///
    /// # Errors
    /// A file that cannot be read, or that has no alpha.
    pub fn frame(&mut self, i: usize) -> Result<SparseFrame> {
        let path = self.frames[i].clone();
        let Picture { mut frame, has_alpha, notes } = image::read_picture(&path)?;
        if !has_alpha {
            bail!(
                "{} has no alpha, so nothing says which pixels are sampled; write RGBA with alpha 1 at samples and 0 elsewhere",
                path.display()
            );
        }
        notes.into_iter().chain(sampled_alone(&mut frame)).for_each(|note| self.note(&path, &note));
        Ok(SparseFrame::from(&frame))
    }

    /// Reads the motion of frame `i`, if there is any.
    ///
    /// # Errors
    /// A file that cannot be read, is of another size, or lacks two channels of motion.
    pub fn motion(&mut self, i: usize) -> Result<Option<Vec<[f32; 2]>>> {
        let path = self.frames[i].clone();
        let Some(file) = self.motion.get(&number(&path, "sparse_")).cloned() else {
            // The first frame has no predecessor to move from.
            if i > 0 && !self.motion.is_empty() {
                self.note(&path, "no motion lies beside it, so the scene counts as still there");
            }
            return Ok(None);
        };
        let mut motion = image::read_motion(&file)?;
        if motion.size != self.size {
            bail!(
                "{} is of {} and its frame of {}; write motion at the size of the frames",
                file.display(),
                motion.size,
                self.size
            );
        }
        let mut is_finite = true;
        for way in &mut motion.ways {
            if way.iter().any(|part| !part.is_finite()) {
                (*way, is_finite) = ([0.0; 2], false);
            }
        }
        motion.notes.into_iter().for_each(|note| self.note(&file, &note));
        if !is_finite {
            self.note(&file, "motion that is no finite number counts as still");
        }
        Ok(Some(motion.ways))
    }

    /// Reads the guide of frame `i`, if there is any.
    ///
    /// # Errors
    /// A file that cannot be read, is of another size, or has no alpha.
    pub fn guide(&mut self, i: usize) -> Result<Option<UpsampledGuide>> {
        let Some(file) = self.guides.get(&number(&self.frames[i], "sparse_")).cloned() else {
            return Ok(None);
        };
        let Picture { frame, has_alpha, notes } = image::read_picture(&file)?;
        if !has_alpha {
            bail!("{} has no alpha; write the opacity of the volume as alpha", file.display());
        }
        if frame.size() != self.size {
            bail!(
                "{} is of {} and its frame of {}; write guides at the size of the frames",
                file.display(),
                frame.size(),
                self.size
            );
        }
        notes.into_iter().for_each(|note| self.note(&file, &note));
        Ok(Some(UpsampledGuide::of_frame(&frame)))
    }

    fn note(&mut self, path: &Path, note: &str) {
        if self.said.insert(note.to_owned()) {
            console::note(format!("{}: {note}", path.display()));
        }
    }
}

/// EXR files of `folder` whose names begin with `prefix`, by their numbers.
fn beside(folder: &Path, prefix: &str) -> Result<BTreeMap<String, PathBuf>> {
    let mut files = frame_sequence::pictures_if_any(folder, prefix)?;
    files.retain(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")));
    let files = frame_sequence::by_number(&files, prefix)?;
    Ok(files.into_iter().map(|(number, path)| (number, path.to_owned())).collect())
}

/// Sets alpha of `frame` to 1 at samples and all other pixels to 0. Returns notes for the user.
fn sampled_alone(frame: &mut Frame) -> Vec<String> {
    let [mut is_partial, mut is_infinite, mut is_outside] = [false; 3];
    let mut samples = 0;
    for pixel in frame.pixels_mut() {
        let [r, g, b, alpha] = *pixel;
        is_partial |= alpha > 0.0 && alpha < 1.0;
        let mut is_sampled = alpha > 0.5;
        if is_sampled && [r, g, b].iter().any(|value| !value.is_finite()) {
            (is_sampled, is_infinite) = (false, true);
        }
        is_outside |= is_sampled && [r, g, b].iter().any(|v| !(-ROUNDING..=1.0 + ROUNDING).contains(v));
        samples += usize::from(is_sampled);
        *pixel = if is_sampled { [r, g, b, 1.0] } else { [0.0; 4] };
    }
    let all = frame.size().pixels();
    [
        (is_partial, "alpha lies between 0 and 1 at some pixels; those above 1/2 count as sampled"),
        (is_infinite, "samples that are no finite numbers count as not sampled"),
        (
            is_outside,
            "colours lie outside 0 to 1, where display values (sRGB) are expected; convert linear light first",
        ),
        (samples == 0, "no pixel is sampled; alpha must be 1 at samples"),
        (samples == all, "every pixel is sampled, so nothing is left to fill; alpha must be 0 elsewhere"),
    ]
    .into_iter()
    .filter(|(holds, _)| *holds)
    .map(|(_, note)| note.to_owned())
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(pixels: [[f32; 4]; 4]) -> Frame {
        Frame::from_pixels(FrameSize::new(2, 2).unwrap(), pixels.to_vec()).unwrap()
    }

    #[test]
    fn only_samples_are_left_and_guesses_are_said() {
        let sample = [0.1, 0.2, 0.3, 1.0];
        let mut usual = frame([sample, [0.9, 0.9, 0.9, 0.0], [0.0; 4], sample]);
        assert!(sampled_alone(&mut usual).is_empty());
        assert_eq!(usual.pixels(), [sample, [0.0; 4], [0.0; 4], sample]);
        let mut odd = frame([[0.5, 0.5, 0.5, 0.4], [3.0, 0.0, 0.0, 0.6], [f32::NAN, 0.0, 0.0, 1.0], sample]);
        let said = sampled_alone(&mut odd).join("; ");
        for words in ["above 1/2", "no finite", "linear light"] {
            assert!(said.contains(words), "{said}");
        }
        assert_eq!(odd.pixels(), [[0.0; 4], [3.0, 0.0, 0.0, 1.0], [0.0; 4], sample]);
        assert!(sampled_alone(&mut frame([sample; 4]))[0].contains("every pixel"));
        assert!(sampled_alone(&mut frame([[0.0; 4]; 4]))[0].contains("no pixel"));
    }
}
