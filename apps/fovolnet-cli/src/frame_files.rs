//! Output files of rendered frames: in a folder, or a single picture.

use crate::commands::mask;
use anyhow::{Context, Result, bail, ensure};
use fovolnet::core::{Frame, FrameSize};
use fovolnet::io::atomic;
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::video;
use fovolnet::{FrameGuide, RenderedFrame};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Kind of picture to write of a frame.
#[derive(clap::ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    Frame,
    Sparse,
    Mask,
    Reference,
    Motion,
    Guide,
}

impl Keep {
    /// Prefix of file names of this kind.
    fn name(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Sparse => "sparse",
            Self::Mask => "mask",
            Self::Reference => "reference",
            Self::Motion => "motion",
            Self::Guide => "guide",
        }
    }

    /// Format of this kind in a folder of pictures in `format`.
    fn format(self, format: Format) -> Format {
        match self {
            Self::Mask => Format::Png,
            Self::Motion | Self::Guide => Format::Exr,
            _ => format,
        }
    }
}

/// Picture format.
#[derive(clap::ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Png,
    Exr,
}

impl Format {
    const ALL: [Self; 2] = [Self::Png, Self::Exr];

    fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// Format by the extension of `path`.
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        Self::ALL.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }
}

/// Picture formats that cannot be written; a path with such an extension is not meant as a folder.
const OTHER_PICTURES: [&str; 6] = ["jpg", "jpeg", "bmp", "tif", "tiff", "webp"];

/// Files to write of rendered frames.
#[derive(Debug, PartialEq)]
pub struct FrameFiles {
    output: PathBuf,
    is_picture: bool,
    keep: Vec<Keep>,
    format: Format,
    has_alpha: bool,
}

impl FrameFiles {
    /// Files of the kinds `keep` for `frames` frames. `output` is a folder, or a single picture if it is named like
    /// `picture.png` and is not a folder.
    pub fn new(output: &Path, keep: &[Keep], format: Option<Format>, frames: usize) -> Result<Self> {
        let named = if output.is_dir() { None } else { Format::of(output) };
        let shown = output.display();
        let Some(named) = named else {
            let extension = output.extension().unwrap_or_default();
            let is_other = OTHER_PICTURES.iter().any(|other| extension.eq_ignore_ascii_case(other));
            ensure!(
                !is_other || output.is_dir(),
                "{shown} is no picture that is written; use .png, .exr, or a folder"
            );
            let format = format.unwrap_or(Format::Png);
            return Ok(Self {
                output: output.to_owned(),
                is_picture: false,
                keep: keep.to_vec(),
                format,
                has_alpha: false,
            });
        };
        ensure!(
            frames == 1,
            "{shown} is one picture and cannot hold {frames} frames; give a folder (-o DIR), or --frames 1"
        );
        let [kept] = *keep else {
            bail!(
                "{shown} is one picture and cannot hold all of --keep; give a folder (-o DIR), or keep one of them"
            );
        };
        let written = kept.format(format.unwrap_or(named));
        ensure!(
            written == named,
            "{shown} is to be a picture of another format; let its name end in .{}",
            written.extension()
        );
        Ok(Self {
            output: output.to_owned(),
            is_picture: true,
            keep: vec![kept],
            format: named,
            has_alpha: false,
        })
    }

    /// Sets whether frames keep their alpha.
    pub fn with_alpha(self, has_alpha: bool) -> Self {
        Self { has_alpha, ..self }
    }

    /// Note on a folder that is named like a clip.
    pub fn doubt(&self) -> Option<String> {
        let extension = self.output.extension()?;
        let is_clip = video::EXTENSIONS.iter().any(|clip| extension.eq_ignore_ascii_case(clip));
        let shown = self.output.display();
        is_clip.then(|| {
            format!("{shown} is a folder of frames, whatever its name says; --video FILE makes a clip")
        })
    }

    /// Makes the folder of the files.
    pub fn make_folder(&self) -> Result<()> {
        let folder = if self.is_picture { self.output.parent() } else { Some(&*self.output) };
        match folder.filter(|folder| !folder.as_os_str().is_empty()) {
            Some(folder) => Ok(atomic::make_folder(folder)?),
            None => Ok(()),
        }
    }

    /// Whether pictures of the kind `keep` are written.
    pub fn has(&self, keep: Keep) -> bool {
        self.keep.contains(&keep)
    }

    /// Paths of all files for the frames `numbers`.
    pub fn paths(&self, numbers: &Range<u32>) -> Vec<PathBuf> {
        let kept = |number| self.keep.iter().map(move |&keep| self.path(keep, number));
        let ratio = |number| (self.has(Keep::Guide) && !self.is_picture).then(|| self.ratio_path(number));
        numbers.clone().flat_map(|number| kept(number).chain(ratio(number))).collect()
    }

    /// Writes the files of a frame.
    pub fn write(&self, rendered: &RenderedFrame, reference: Option<&Frame>) -> Result<()> {
        let alpha = if self.has_alpha { Alpha::Keep } else { Alpha::Drop };
        for &keep in &self.keep {
            let path = self.path(keep, rendered.index);
            match keep {
                Keep::Frame => self.picture(&path, &rendered.frame, alpha)?,
                Keep::Sparse => self.picture(&path, &rendered.samples_picture(), Alpha::Keep)?,
                Keep::Mask => mask::write(&path, &rendered.mask)?,
                Keep::Reference => {
                    let reference = reference.context("the reference was not rendered")?;
                    self.picture(&path, reference, alpha)?;
                }
                Keep::Motion => image::write_exr(&path, &motion_picture(rendered))?,
                Keep::Guide => self.write_guide(&path, rendered)?,
            }
        }
        Ok(())
    }

    /// Names of frames in the folder that are not among `numbers`, left by a longer run before.
    pub fn older(&self, numbers: &Range<u32>) -> Vec<String> {
        if self.is_picture {
            return Vec::new();
        }
        let entries = std::fs::read_dir(&self.output).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let mut older: Vec<String> = names.filter(|name| self.is_older(name, numbers)).collect();
        older.sort();
        older
    }

    fn is_older(&self, name: &str, numbers: &Range<u32>) -> bool {
        self.keep.iter().any(|keep| {
            let rest = name.strip_prefix(keep.name()).and_then(|rest| rest.strip_prefix('_'));
            let parts = rest.and_then(|rest| rest.split_once('.'));
            let Some((number, extension)) = parts else { return false };
            let is_picture = Format::ALL.iter().any(|format| format.extension() == extension);
            let is_made = extension == keep.format(self.format).extension();
            let number = if is_picture { number.parse().ok() } else { None };
            number.is_some_and(|number: u32| !(is_made && numbers.contains(&number)))
        })
    }

    fn path(&self, keep: Keep, number: u32) -> PathBuf {
        if self.is_picture {
            return self.output.clone();
        }
        let extension = keep.format(self.format).extension();
        self.output.join(format!("{}_{number:04}.{extension}", keep.name()))
    }

    /// Writes the guide to `path`, and the light ratio to ratio_NUMBER.exr beside it.
    fn write_guide(&self, path: &Path, rendered: &RenderedFrame) -> Result<()> {
        let size = rendered.frame.size();
        let (guide, ratio) = match &rendered.guide {
            Some(FrameGuide { guide, ratio }) => (guide.to_frame(size), ratio.clone()),
            None => nothing_visible(size),
        };
        image::write_exr(path, &guide)?;
        if !self.is_picture {
            image::write_exr(&self.ratio_path(rendered.index), &ratio)?;
        }
        Ok(())
    }

    fn ratio_path(&self, number: u32) -> PathBuf {
        self.output.join(format!("ratio_{number:04}.exr"))
    }

    fn picture(&self, path: &Path, frame: &Frame, alpha: Alpha) -> Result<()> {
        match self.format {
            Format::Png => image::write_png(path, frame, alpha)?,
            // PNG stores straight alpha, OpenEXR premultiplied alpha. Opaque frames are the same in both.
            Format::Exr if self.has_alpha && alpha == Alpha::Keep => {
                image::write_exr(path, &frame.clone().premultiplied())?;
            }
            Format::Exr => image::write_exr(path, frame)?,
        }
        Ok(())
    }
}

/// Guide and light ratio of a frame in which nothing is visible.
fn nothing_visible(size: FrameSize) -> (Frame, Frame) {
    let mut ratio = Frame::new(size);
    ratio.fill([1.0; 4]);
    (Frame::new(size), ratio)
}

/// Motion of a frame as a picture: red is right, green is down, in pixels; 0 where it is unknown.
fn motion_picture(rendered: &RenderedFrame) -> Frame {
    let mut picture = Frame::new(rendered.frame.size());
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        let [right, down] = rendered.motion.as_ref().map_or([0.0; 2], |motion| motion[i]);
        *pixel = [right, down, 0.0, 1.0];
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(output: &str, keep: &[Keep], format: Option<Format>, frames: usize) -> Result<FrameFiles> {
        FrameFiles::new(Path::new(output), keep, format, frames)
    }

    #[test]
    fn names_of_pictures_are_pictures() {
        let frame = [Keep::Frame];
        assert!(files("a/b.PNG", &frame, None, 1).unwrap().is_picture);
        assert_eq!(files("b.exr", &frame, None, 1).unwrap().format, Format::Exr);
        assert!(files("m.exr", &[Keep::Motion], None, 1).unwrap().is_picture);
        assert!(!files("a/b", &frame, None, 9).unwrap().is_picture);
        assert!(!files("version.2", &frame, None, 9).unwrap().is_picture);
        for wrong in [
            files("b.png", &frame, None, 2),
            files("b.png", &[Keep::Frame, Keep::Mask], None, 1),
            files("b.png", &frame, Some(Format::Exr), 1),
            files("b.exr", &[Keep::Mask], None, 1),
            files("b.jpg", &frame, None, 1),
        ] {
            let error = wrong.unwrap_err().to_string();
            assert!(error.starts_with("b.") && error.contains("; "), "{error}");
        }
    }

    #[test]
    fn folders_named_like_clips_are_noted() {
        let doubt = |output: &str| files(output, &[Keep::Frame], None, 4).unwrap().doubt();
        assert!(doubt("a/clip.MP4").unwrap().starts_with("a/clip.MP4 is a folder of frames"));
        assert_eq!((doubt("clip"), doubt("version.2")), (None, None));
    }

    #[test]
    fn folders_may_have_such_names() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("frames.png");
        std::fs::create_dir(&inside).unwrap();
        let files = FrameFiles::new(&inside, &[Keep::Frame], None, 3).unwrap();
        assert_eq!(files.path(Keep::Frame, 7), inside.join("frame_0007.png"));
    }

    #[test]
    fn frames_of_longer_runs_are_found() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "frame_0000.png",
            "frame_0001.exr",
            "frame_0009.png",
            "mask_0009.png",
            "frame_x.png",
            "frame_0003.txt",
        ] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let files = FrameFiles::new(folder.path(), &[Keep::Frame], None, 2).unwrap();
        assert_eq!(files.older(&(0..2)), ["frame_0001.exr", "frame_0009.png"]);
    }
}
