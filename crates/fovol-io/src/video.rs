//! Clips in and out: y4m by itself, everything else through an installed `ffmpeg`.

use crate::{Error, Result, atomic};
use ffmpeg_sidecar::command::FfmpegCommand;
use ffmpeg_sidecar::paths::ffmpeg_path;
use fovol_core::{Frame, FrameSize};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use tempfile::TempPath;

/// What the names of clips may end in, `.y4m` first; all others need ffmpeg.
pub const EXTENSIONS: [&str; 13] =
    ["y4m", "mp4", "m4v", "mov", "mkv", "webm", "avi", "ogv", "mpg", "wmv", "gif", "webp", "apng"];

/// Refuses a name that says no kind of clip.
///
/// # Errors
/// Such a name, with what it may end in.
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

/// What a clip is best written as on this machine: `mp4`, or `y4m` without ffmpeg.
pub fn best_extension() -> &'static str {
    if ffmpeg_installed() { "mp4" } else { "y4m" }
}

/// Whether an `ffmpeg` can be started.
pub fn ffmpeg_installed() -> bool {
    let probe =
        Command::new(ffmpeg_path()).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    probe.is_ok_and(|status| status.success())
}

/// Writes a clip frame by frame; it has its name only once it is finished.
pub struct VideoWriter {
    path: PathBuf,
    temporary: TempPath,
    size: FrameSize,
    encoder: Encoder,
}

enum Encoder {
    Y4m(Box<y4m::Encoder<BufWriter<File>>>),
    Ffmpeg { child: Child, input: BufWriter<ChildStdin> },
}

impl VideoWriter {
    /// Begins the clip `path` of frames of `size` at `fps` frames a second.
    ///
    /// Names that end in `.y4m` need nothing else. For all others of [`EXTENSIONS`] `ffmpeg` is used where it is
    /// installed; where it is not, `clip.mp4` becomes `clip.mp4.y4m` ([`Self::path`] says so), which takes the place of no clip
    /// of another kind.
    ///
    /// # Errors
    /// A name that ends otherwise, see [`check_name`]; what the system said.
    pub fn create(path: &Path, size: FrameSize, fps: u32) -> Result<Self> {
        check_name(path)?;
        let is_y4m = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("y4m"));
        let through_ffmpeg = !is_y4m && ffmpeg_installed();
        let path = if is_y4m || through_ffmpeg { path.to_owned() } else { without_ffmpeg(path) };
        let failed = |e| Error::io("write", &path, e);
        let (file, temporary) = atomic::temporary(&path)?.into_parts();
        let encoder = if through_ffmpeg {
            ffmpeg_encoder(&temporary, size, fps).map_err(failed)?
        } else {
            let rate = y4m::Ratio::new(fps as usize, 1);
            let header = y4m::encode(size.width as usize, size.height as usize, rate)
                .with_colorspace(y4m::Colorspace::C444)
                .write_header(BufWriter::new(file));
            Encoder::Y4m(Box::new(header.map_err(|e| failed(io::Error::other(e.to_string())))?))
        };
        Ok(Self { path, temporary, size, encoder })
    }

    /// The name that the finished clip will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends `frame`.
    ///
    /// # Errors
    /// A frame of another size, or what the system said.
    pub fn push(&mut self, frame: &Frame) -> Result<()> {
        if frame.size() != self.size {
            let problem = format!("a clip of {} cannot take a frame of {}", self.size, frame.size());
            return Err(Error::malformed(&self.path, problem));
        }
        let written = match &mut self.encoder {
            Encoder::Y4m(encoder) => {
                let [y, u, v] = planes(frame);
                encoder
                    .write_frame(&y4m::Frame::new([&y, &u, &v], None))
                    .map_err(|e| io::Error::other(e.to_string()))
            }
            Encoder::Ffmpeg { input, .. } => input.write_all(&frame.to_rgb8()),
        };
        written.map_err(|e| Error::io("write", &self.path, e))
    }

    /// Completes the clip and gives it its name, which is returned.
    ///
    /// # Errors
    /// What the system or `ffmpeg` said.
    pub fn finish(self) -> Result<PathBuf> {
        let Self { path, temporary, encoder, .. } = self;
        let failed = |e| Error::io("write", &path, e);
        match encoder {
            Encoder::Y4m(encoder) => drop(encoder),
            Encoder::Ffmpeg { mut child, mut input } => {
                input.flush().map_err(failed)?;
                drop(input);
                if !child.wait().map_err(failed)?.success() {
                    return Err(Error::unsupported(
                        &path,
                        "ffmpeg could not encode it; try a name that ends in .mp4 or .y4m",
                    ));
                }
            }
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

fn ffmpeg_encoder(to: &Path, size: FrameSize, fps: u32) -> io::Result<Encoder> {
    let mut command = FfmpegCommand::new();
    command
        .overwrite()
        .args(["-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"])
        .args(["-s", &size.to_string(), "-r", &fps.to_string(), "-i", "-"])
        .args(["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-crf", "16"]);
    let mut child = command
        .as_inner_mut()
        .arg(to)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let input = child.stdin.take().ok_or_else(|| io::Error::other("ffmpeg takes no input"))?;
    Ok(Encoder::Ffmpeg { child, input: BufWriter::with_capacity(1 << 20, input) })
}

/// The frames of the clip at `path`.
///
/// # Errors
/// A file that is missing, damaged, or needs an `ffmpeg` that is not installed.
pub fn read(path: &Path) -> Result<Vec<Frame>> {
    let mut file = File::open(path).map_err(|e| Error::io("read", path, e))?;
    let mut magic = [0u8; 9];
    let is_y4m = file.read_exact(&mut magic).is_ok() && &magic == b"YUV4MPEG2";
    if is_y4m {
        return read_y4m(path, BufReader::new(File::open(path).map_err(|e| Error::io("read", path, e))?));
    }
    if !ffmpeg_installed() {
        return Err(Error::unsupported(
            path,
            "only .y4m clips are read without ffmpeg; install ffmpeg or convert the clip",
        ));
    }
    let mut command = FfmpegCommand::new();
    command.args(["-loglevel", "error", "-i"]);
    command.as_inner_mut().arg(path).args(["-f", "yuv4mpegpipe", "-pix_fmt", "yuv444p", "-"]);
    let output = command.as_inner_mut().stdin(Stdio::null()).stderr(Stdio::null()).output();
    let output = output.map_err(|e| Error::io("read", path, e))?;
    if !output.status.success() {
        return Err(Error::malformed(path, "ffmpeg cannot read it as a clip"));
    }
    read_y4m(path, output.stdout.as_slice())
}

fn read_y4m(path: &Path, from: impl Read) -> Result<Vec<Frame>> {
    let bad = |e: y4m::Error| Error::malformed(path, format!("it is damaged ({e})"));
    // One frame of the largest size that is accepted.
    let limits = y4m::Limits { bytes: 3 << 28 };
    let mut decoder = y4m::Decoder::new_with_limits(from, limits).map_err(bad)?;
    if !matches!(decoder.get_colorspace(), y4m::Colorspace::C444) {
        return Err(Error::unsupported(
            path,
            "only 8-bit 4:4:4 y4m clips are read; convert it with ffmpeg -pix_fmt yuv444p",
        ));
    }
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let size = FrameSize::new(side(decoder.get_width()), side(decoder.get_height()))
        .map_err(|e| Error::malformed(path, e.to_string()))?;
    let mut frames = Vec::new();
    loop {
        match decoder.read_frame() {
            Ok(frame) => {
                frames.push(from_planes(size, frame.get_y_plane(), frame.get_u_plane(), frame.get_v_plane()));
            }
            Err(y4m::Error::EOF) => return Ok(frames),
            Err(e) => return Err(bad(e)),
        }
    }
}

/// ITU-R BT.709 weights of red and blue in luma.
const RED: f32 = 0.2126;
const BLUE: f32 = 0.0722;

/// Limited-range BT.709 luma and chroma.
fn planes(frame: &Frame) -> [Vec<u8>; 3] {
    let mut planes = [(); 3].map(|()| Vec::with_capacity(frame.size().pixels()));
    for p in frame.pixels() {
        let [r, g, b] = [p[0], p[1], p[2]].map(|c| c.clamp(0.0, 1.0));
        let luma = RED * r + (1.0 - RED - BLUE) * g + BLUE * b;
        let (u, v) = ((b - luma) / (2.0 - 2.0 * BLUE), (r - luma) / (2.0 - 2.0 * RED));
        planes[0].push((16.0 + 219.0 * luma).round() as u8);
        planes[1].push((128.0 + 224.0 * u).round() as u8);
        planes[2].push((128.0 + 224.0 * v).round() as u8);
    }
    planes
}

fn from_planes(size: FrameSize, y: &[u8], u: &[u8], v: &[u8]) -> Frame {
    let pixels = y.iter().zip(u).zip(v).map(|((&y, &u), &v)| {
        let luma = (f32::from(y) - 16.0) / 219.0;
        let (u, v) = ((f32::from(u) - 128.0) / 224.0, (f32::from(v) - 128.0) / 224.0);
        let (r, b) = (luma + v * (2.0 - 2.0 * RED), luma + u * (2.0 - 2.0 * BLUE));
        let g = (luma - RED * r - BLUE * b) / (1.0 - RED - BLUE);
        [r.clamp(0.0, 1.0), g.clamp(0.0, 1.0), b.clamp(0.0, 1.0), 1.0]
    });
    Frame::from_pixels(size, pixels.collect()).expect("planes have the size of the frame")
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
