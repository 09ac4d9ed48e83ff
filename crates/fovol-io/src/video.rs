//! Clips in and out: y4m by itself, everything else through an installed `ffmpeg`.

use crate::{Error, Result, atomic};
use ffmpeg_sidecar::command::FfmpegCommand;
use ffmpeg_sidecar::paths::ffmpeg_path;
use fovol_core::{Frame, FrameSize};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use tempfile::{NamedTempFile, TempPath};

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
    /// Names that end in `.y4m` need nothing else. For all other names `ffmpeg` is used where it is
    /// installed; where it is not, the clip becomes a `.y4m` beside the wanted name ([`Self::path`] says so).
    ///
    /// # Errors
    /// What the system said.
    pub fn create(path: &Path, size: FrameSize, fps: u32) -> Result<Self> {
        let is_y4m = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("y4m"));
        let through_ffmpeg = !is_y4m && ffmpeg_installed();
        let path = if through_ffmpeg { path.to_owned() } else { path.with_extension("y4m") };
        let failed = |e| Error::io("write", &path, e);
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let extension = path.extension().map(|e| format!(".{}", e.display())).unwrap_or_default();
        let (file, temporary) = tempfile::Builder::new()
            .prefix(".fovolnet-")
            .suffix(&extension)
            .tempfile_in(folder)
            .map(NamedTempFile::into_parts)
            .map_err(failed)?;
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
