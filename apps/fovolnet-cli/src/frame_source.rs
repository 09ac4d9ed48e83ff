//! Source of frames to compare: a clip, a folder of pictures, or one picture.

use crate::frame_sequence::{self, is_picture};
use anyhow::{Context, Result, bail};
use fovolnet::core::{Frame, input};
use fovolnet::io::image;
use fovolnet::io::video::VideoReader;
use std::path::{Path, PathBuf};

/// Frames in order. Only one of them is in memory at a time.
pub enum FrameSource {
    /// Pictures that are still to be read, and the number of all.
    Pictures { files: std::vec::IntoIter<PathBuf>, count: usize },
    /// Clip, and the number of its frames.
    Video { path: PathBuf, reader: VideoReader, count: usize },
}

impl FrameSource {
    /// Opens the frames at `path`. In a folder it takes the pictures of the first of `prefixes` that has any.
    ///
    /// A clip is read once to count its frames.
    ///
    /// # Errors
    /// A file that cannot be read; a folder without pictures.
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

    /// Whether the source is a clip.
    pub fn is_video(&self) -> bool {
        matches!(self, Self::Video { .. })
    }

    /// Number of all frames.
    pub fn len(&self) -> usize {
        match self {
            Self::Pictures { count, .. } | Self::Video { count, .. } => *count,
        }
    }

    /// Reads the next frame.
    ///
    /// # Errors
    /// A file that cannot be read; no more frames, for example if the clip was changed meanwhile.
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
