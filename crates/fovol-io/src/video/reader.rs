use super::{ffmpeg, ffmpeg_installed, y4m_file};
use crate::{Error, Result};
use fovol_core::{Frame, input};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Reads a clip frame by frame: one frame is in memory, however long the clip is.
///
/// After an error there are no more frames.
pub struct VideoReader(Option<Decoder>);

enum Decoder {
    Y4m(Box<y4m_file::Reader<BufReader<File>>>),
    Ffmpeg(Box<ffmpeg::Reader>),
}

impl VideoReader {
    /// Begins to read the clip at `path`.
    ///
    /// # Errors
    /// A file that is missing, no clip, or needs an `ffmpeg` that is not installed.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |e| Error::io("read", path, e);
        let mut magic = [0u8; 9];
        let mut file = input::open(path).map_err(failed)?;
        let is_y4m = file.read_exact(&mut magic).is_ok() && &magic == b"YUV4MPEG2";
        if is_y4m {
            let from = BufReader::new(input::open(path).map_err(failed)?);
            return Ok(Self(Some(Decoder::Y4m(Box::new(y4m_file::Reader::new(path, from)?)))));
        }
        if !ffmpeg_installed() {
            return Err(Error::unsupported(
                path,
                "only .y4m clips are read without ffmpeg; install ffmpeg or convert the clip",
            ));
        }
        Ok(Self(Some(Decoder::Ffmpeg(Box::new(ffmpeg::Reader::new(path)?)))))
    }

    /// The number of frames that are left. They are decoded, and not kept.
    ///
    /// # Errors
    /// A clip that is damaged.
    pub fn count_frames(mut self) -> Result<usize> {
        let mut count = 0;
        while self.pass_over()? {
            count += 1;
        }
        Ok(count)
    }

    fn pass_over(&mut self) -> Result<bool> {
        match &mut self.0 {
            None => Ok(false),
            Some(Decoder::Y4m(reader)) => reader.skip(),
            Some(Decoder::Ffmpeg(reader)) => reader.skip(),
        }
    }
}

impl Iterator for VideoReader {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Result<Frame>> {
        let next = match self.0.as_mut()? {
            Decoder::Y4m(reader) => reader.next(),
            Decoder::Ffmpeg(reader) => reader.next(),
        };
        if !matches!(next, Ok(Some(_))) {
            self.0 = None;
        }
        next.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::video::VideoWriter;
    use fovol_core::FrameSize;

    #[test]
    fn a_clip_that_breaks_off_in_the_middle_has_the_frames_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.y4m");
        let size = FrameSize::new(6, 4).unwrap();
        let mut writer = VideoWriter::create(&path, size, 30).unwrap();
        (0..3).for_each(|_| writer.push(&Frame::new(size)).unwrap());
        writer.finish().unwrap();
        assert_eq!(VideoReader::open(&path).unwrap().count_frames().unwrap(), 3);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() - 10);
        std::fs::write(&path, &bytes).unwrap();
        let mut reader = VideoReader::open(&path).unwrap();
        assert!(reader.next().unwrap().is_ok());
        assert_eq!(reader.count_frames().unwrap(), 1);
        let frame = bytes.windows(5).rposition(|word| word == b"FRAME").unwrap();
        bytes[frame] = b'X';
        std::fs::write(&path, &bytes).unwrap();
        let mut reader = VideoReader::open(&path).unwrap();
        assert!(reader.next().unwrap().is_ok() && reader.next().unwrap().is_ok());
        assert!(reader.next().unwrap().is_err() && reader.next().is_none());
        assert!(VideoReader::open(&path).unwrap().count_frames().is_err());
    }
}
