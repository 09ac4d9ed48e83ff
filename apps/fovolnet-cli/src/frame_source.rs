//! Frames to compare, one after the other: those of a clip, of a folder of pictures, or one picture.

use crate::frame_sequence::{self, is_picture};
use anyhow::{Context, Result, bail};
use fovolnet::core::{Frame, input};
use fovolnet::io::image;
use fovolnet::io::video::VideoReader;
use std::path::{Path, PathBuf};

/// Frames in their order. One of them is in memory at a time, however many there are.
pub enum FrameSource {
    /// Pictures that are still to be read.
    Pictures { files: std::vec::IntoIter<PathBuf>, count: usize },
    /// A clip, and how many frames it has in all.
    Video { path: PathBuf, reader: VideoReader, count: usize },
}

impl FrameSource {
    /// The frames at `path`; in a folder, the pictures of the first of `prefixes` that there are any of.
    ///
    /// Clips are gone through to count their frames.
    ///
    /// # Errors
    /// What cannot be read; a folder without pictures.
    pub fn open(path: &Path, prefixes: &[&str]) -> Result<Self> {
        if is_picture(path) && path.is_file() {
            input::add(path);
            return Ok(Self::pictures(vec![path.to_owned()]));
        }
        if !path.is_dir() {
            let count = VideoReader::count_frames(path)?;
            return Ok(Self::Video { path: path.to_owned(), reader: VideoReader::open(path)?, count });
        }
        for prefix in prefixes {
            let files = frame_sequence::pictures_if_any(path, prefix)?;
            if !files.is_empty() {
                return Ok(Self::pictures(files));
            }
        }
        bail!("{}: there are no pictures in it; check the folder", path.display())
    }

    fn pictures(files: Vec<PathBuf>) -> Self {
        let count = files.len();
        Self::Pictures { files: files.into_iter(), count }
    }

    /// Whether it is a clip.
    pub fn is_video(&self) -> bool {
        matches!(self, Self::Video { .. })
    }

    /// The number of all its frames.
    pub fn len(&self) -> usize {
        match self {
            Self::Pictures { count, .. } | Self::Video { count, .. } => *count,
        }
    }

    /// The next frame.
    ///
    /// # Errors
    /// What cannot be read; no more frames, as of a clip that has changed meanwhile.
    pub fn next(&mut self) -> Result<Frame> {
        match self {
            Self::Pictures { files, .. } => {
                Ok(image::read(&files.next().context("there are no more pictures")?)?)
            }
            Self::Video { path, reader, .. } => match reader.next() {
                Some(frame) => Ok(frame?),
                None => bail!("{} has fewer frames than before; is it being written?", path.display()),
            },
        }
    }
}
