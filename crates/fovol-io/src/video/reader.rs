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
        let decoder = match y4m(path)? {
            Some(reader) => Decoder::Y4m(Box::new(reader)),
            None => Decoder::Ffmpeg(Box::new(ffmpeg::Reader::new(path)?)),
        };
        Ok(Self(Some(decoder)))
    }

    /// The number of frames of the clip at `path`. They are decoded, and not kept.
    ///
    /// # Errors
    /// Those of [`Self::open`]; a clip that is damaged.
    pub fn count_frames(path: &Path) -> Result<usize> {
        let Some(mut reader) = y4m(path)? else { return ffmpeg::count_frames(path) };
        let mut count = 0;
        while reader.skip()? {
            count += 1;
        }
        Ok(count)
    }
}

/// Opens the file at `path` as uncompressed frames; none if it needs ffmpeg.
fn y4m(path: &Path) -> Result<Option<y4m_file::Reader<BufReader<File>>>> {
    let failed = |e| Error::io("read", path, e);
    let mut magic = [0u8; 9];
    let mut file = input::open(path).map_err(failed)?;
    let is_y4m = file.read_exact(&mut magic).is_ok() && &magic == b"YUV4MPEG2";
    if is_y4m {
        let from = BufReader::new(input::open(path).map_err(failed)?);
        return y4m_file::Reader::new(path, from).map(Some);
    }
    if !ffmpeg_installed() {
        return Err(Error::unsupported(
            path,
            "only .y4m clips are read without ffmpeg; install ffmpeg or convert the clip",
        ));
    }
    Ok(None)
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
        assert_eq!(VideoReader::count_frames(&path).unwrap(), 3);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() - 10);
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(VideoReader::count_frames(&path).unwrap(), 2);
        assert_eq!(VideoReader::open(&path).unwrap().map(Result::unwrap).count(), 2);
        let frame = bytes.windows(5).rposition(|word| word == b"FRAME").unwrap();
        bytes[frame] = b'X';
        std::fs::write(&path, &bytes).unwrap();
        let mut reader = VideoReader::open(&path).unwrap();
        assert!(reader.next().unwrap().is_ok() && reader.next().unwrap().is_ok());
        assert!(reader.next().unwrap().is_err() && reader.next().is_none());
        assert!(VideoReader::count_frames(&path).is_err());
    }
}
