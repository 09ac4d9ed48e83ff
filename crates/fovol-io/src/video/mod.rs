//! Clips in and out: y4m by itself, everything else through an installed `ffmpeg`.

mod even_size;
mod ffmpeg;
mod frame_rate;
mod reader;
mod y4m_file;

use crate::atomic::{self, Temporary};
use crate::{Error, Result};
use fovol_core::{Frame, FrameSize};
use std::path::{Path, PathBuf};

pub use even_size::padded_to_even;
pub use ffmpeg::ffmpeg_installed;
pub use frame_rate::FrameRate;
pub use reader::VideoReader;

/// File extensions of clips, `y4m` first; all others need ffmpeg.
pub const EXTENSIONS: [&str; 13] =
    ["y4m", "mp4", "m4v", "mov", "mkv", "webm", "avi", "ogv", "mpg", "wmv", "gif", "webp", "apng"];

/// Checks that the extension of `path` is that of a clip.
///
/// # Errors
/// An unknown extension; the message lists the known ones.
pub fn check_name(path: &Path) -> Result<()> {
    let found = path.extension().unwrap_or_default();
    if EXTENSIONS.iter().any(|known| found.eq_ignore_ascii_case(known)) {
        return Ok(());
    }
    let known = EXTENSIONS.join(", .");
    let problem = match found.is_empty() {
        true => format!("its name does not say what kind of clip it is to be; let it end in one of .{known}"),
        false => format!(".{} is no kind of clip that is written; use one of .{known}", found.display()),
    };
    Err(Error::unsupported(path, problem))
}

/// Preferred file extension for clips on this machine: `mp4`, or `y4m` without ffmpeg.
pub fn best_extension() -> &'static str {
    if ffmpeg_installed() { "mp4" } else { "y4m" }
}

/// Writes a clip frame by frame. The file gets its name only when it is finished.
pub struct VideoWriter {
    path: PathBuf,
    size: FrameSize,
    /// Dropped before the file that it writes, which it might make anew.
    encoder: Encoder,
    temporary: Temporary,
}

enum Encoder {
    Y4m(y4m_file::Writer),
    Ffmpeg(ffmpeg::Writer),
}

impl VideoWriter {
    /// Begins the clip `path` with frames of `size` at `rate` frames per second.
    ///
    /// Colours are limited-range BT.709 and tagged as such. All formats but y4m, GIF and APNG subsample chroma (4:2:0).
    /// Frames of odd size then repeat their last row or column ([`padded_to_even`]).
    ///
    /// `.y4m` files are written without other programs. All other [`EXTENSIONS`] need `ffmpeg`. If it is not installed,
    /// `clip.mp4` becomes `clip.mp4.y4m`, so that no clip of another format is replaced; [`Self::path`] is that name.
    ///
    /// # Errors
    /// An unknown extension, see [`check_name`]; errors of the operating system.
    pub fn create(path: &Path, size: FrameSize, rate: impl Into<FrameRate>) -> Result<Self> {
        let rate = rate.into();
        check_name(path)?;
        let is_y4m = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("y4m"));
        let through_ffmpeg = !is_y4m && ffmpeg_installed();
        let path = if is_y4m || through_ffmpeg { path.to_owned() } else { without_ffmpeg(path) };
        let (file, temporary) = atomic::temporary(&path)?;
        let encoder = match through_ffmpeg {
            true => ffmpeg::Writer::new(temporary.path(), size, rate).map(Encoder::Ffmpeg),
            false => y4m_file::Writer::new(file, size, rate).map(Encoder::Y4m),
        };
        let encoder = encoder.map_err(|e| Error::io("write", &path, e))?;
        Ok(Self { path, size, encoder, temporary })
    }

    /// The path of the finished clip.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends `frame`.
    ///
    /// # Errors
    /// A frame of another size, or errors of the operating system.
    pub fn push(&mut self, frame: &Frame) -> Result<()> {
        if frame.size() != self.size {
            let problem = format!("a clip of {} cannot take a frame of {}", self.size, frame.size());
            return Err(Error::malformed(&self.path, problem));
        }
        let written = match &mut self.encoder {
            Encoder::Y4m(writer) => writer.push(frame),
            Encoder::Ffmpeg(writer) => writer.push(frame),
        };
        written.map_err(|e| Error::io("write", &self.path, e))
    }

    /// Completes the clip, gives the file its name and returns it. Clips from `ffmpeg` are read back first.
    ///
    /// # Errors
    /// Errors of the operating system or of `ffmpeg`; a clip that lacks frames, for example on a full disk.
    pub fn finish(self) -> Result<PathBuf> {
        let Self { path, temporary, encoder, .. } = self;
        match encoder {
            Encoder::Y4m(writer) => drop(writer),
            Encoder::Ffmpeg(writer) => writer.finish().map_err(|e| Error::io("write", &path, e))?,
        }
        atomic::persist(temporary, &path)?;
        Ok(path)
    }
}

/// The name of a clip that was to be `path`, without ffmpeg.
fn without_ffmpeg(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".y4m");
    name.into()
}

/// The frames of the clip at `path`, all of them in memory; [`VideoReader`] reads them one by one.
///
/// # Errors
/// A file that is missing, damaged, or needs an `ffmpeg` that is not installed.
pub fn read(path: &Path) -> Result<Vec<Frame>> {
    VideoReader::open(path)?.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_y4m_clip_reads_back_within_its_precision() {
        let folder = tempfile::tempdir().unwrap();
        let size = FrameSize::new(6, 4).unwrap();
        let frame = |k: usize| {
            let pixels = (0..24).map(|i| [i as f32 / 23.0, 0.5, ((i + k) % 5) as f32 / 4.0, 1.0]).collect();
            Frame::from_pixels(size, pixels).unwrap()
        };
        let mut writer = VideoWriter::create(&folder.path().join("clip.y4m"), size, 30).unwrap();
        (0..3).for_each(|k| writer.push(&frame(k)).unwrap());
        assert!(writer.push(&Frame::new(FrameSize::new(2, 2).unwrap())).is_err());
        let path = writer.finish().unwrap();
        let frames = read(&path).unwrap();
        assert_eq!(frames.len(), 3);
        for (k, found) in frames.iter().enumerate() {
            for (a, b) in frame(k).pixels().iter().zip(found.pixels()) {
                assert!((0..3).all(|c| (a[c] - b[c]).abs() < 0.012), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn kinds_of_clips_are_known_by_their_names() {
        for name in ["a.y4m", "a.MP4", "a.b.gif"] {
            check_name(Path::new(name)).unwrap();
        }
        for name in ["clip", "clip.mp5", "clip.y4m.txt", ".mp4"] {
            let error = check_name(Path::new(name)).unwrap_err().to_string();
            assert!(error.starts_with(name) && error.contains(".y4m, .mp4, "), "{error}");
        }
        assert_eq!(without_ffmpeg(Path::new("a/clip.mp4")), Path::new("a/clip.mp4.y4m"));
    }

    #[test]
    fn a_full_disk_is_an_error() {
        let full = Path::new("/dev/full");
        if !full.exists() {
            println!("skipped: no /dev/full");
            return;
        }
        let file = std::fs::File::options().write(true).open(full).unwrap();
        let size = FrameSize::new(6, 4).unwrap();
        let writer = y4m_file::Writer::new(file, size, 30.into());
        let error = writer.map(drop).unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
    }

    #[test]
    fn a_write_that_fails_at_any_byte_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.y4m");
        let size = FrameSize::new(6, 4).unwrap();
        let make = || {
            let mut writer = VideoWriter::create(&path, size, 30)?;
            (0..2).try_for_each(|_| writer.push(&Frame::new(size)))?;
            writer.finish()
        };
        make().unwrap();
        let length = std::fs::metadata(&path).unwrap().len() as usize;
        std::fs::remove_file(&path).unwrap();
        for room in 0..length {
            crate::fault::after(room, make).unwrap_err();
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{room}");
        }
        crate::fault::after(length, make).unwrap();
    }

    #[test]
    fn kinds_of_clips_keep_colours_sizes_and_frames() {
        if !ffmpeg_installed() {
            println!("skipped: no ffmpeg");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let size = FrameSize::new(33, 17).unwrap();
        let colours =
            [[1.0, 0.0, 0.0, 1.0], [0.1, 0.8, 0.2, 1.0], [0.0, 0.0, 1.0, 1.0], [0.5, 0.5, 0.5, 1.0]];
        for (ending, even) in
            [("mp4", true), ("m4v", true), ("mov", true), ("mkv", true), ("apng", false), ("gif", false)]
        {
            let path = folder.path().join(format!("clip.{ending}"));
            let mut writer =
                VideoWriter::create(&path, size, "30000/1001".parse::<FrameRate>().unwrap()).unwrap();
            for colour in colours {
                writer.push(&Frame::from_pixels(size, vec![colour; size.pixels()]).unwrap()).unwrap();
            }
            assert_eq!(writer.finish().unwrap(), path);
            let frames = read(&path).unwrap();
            assert_eq!(frames.len(), colours.len(), "{ending}");
            for (frame, colour) in frames.iter().zip(colours) {
                assert_eq!(frame.size(), if even { padded_to_even(size) } else { size }, "{ending}");
                for (x, y) in [(0, 0), (16, 8), (frame.size().width - 1, frame.size().height - 1)] {
                    let found = frame.pixel(x, y);
                    assert!(
                        (0..3).all(|c| (found[c] - colour[c]).abs() < 0.03),
                        "{ending}: {found:?} {colour:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_unfinished_clip_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let size = FrameSize::new(6, 4).unwrap();
        let mut writer = VideoWriter::create(&folder.path().join("clip.y4m"), size, 30).unwrap();
        writer.push(&Frame::new(size)).unwrap();
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn what_is_no_clip_is_said_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.y4m");
        std::fs::write(&path, b"YUV4MPEG2 W100000 H100000 F30:1\nFRAME\nxx").unwrap();
        assert!(read(&path).is_err());
    }
}
