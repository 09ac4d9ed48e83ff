//! Clips through an installed `ffmpeg`, which is trusted with nothing: what it wrote is read back.

use super::even_size::padded_to_even;
use super::{FrameRate, y4m_file};
use crate::{Error, Result};
use ffmpeg_sidecar::paths::ffmpeg_path;
use fovol_core::{ChildProcess, Frame, FrameSize};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::LazyLock;
use std::thread::JoinHandle;

/// Whether an `ffmpeg` can be started.
pub fn ffmpeg_installed() -> bool {
    let probe =
        Command::new(ffmpeg_path()).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    probe.is_ok_and(|status| status.success())
}

/// The option of the installed ffmpeg that sets how frame timestamps are handled: `-vsync` or `-fps_mode`.
///
/// Versions before 5.1 know only `-vsync`, versions from 9 on only `-fps_mode`.
fn timing_option() -> &'static str {
    static OPTION: LazyLock<&str> = LazyLock::new(|| {
        let said = Command::new(ffmpeg_path()).arg("-version").stdin(Stdio::null()).output();
        timing_option_of(
            &said.map_or_else(|_| String::new(), |said| String::from_utf8_lossy(&said.stdout).into()),
        )
    });
    *OPTION
}

/// The option for an ffmpeg that prints `said` as its version; builds without a number count as new.
fn timing_option_of(said: &str) -> &'static str {
    let version = said.split_whitespace().nth(2).unwrap_or_default().trim_start_matches('n');
    let mut numbers = version.split(['.', '-']).map_while(|part| part.parse::<u32>().ok());
    match (numbers.next(), numbers.next().unwrap_or(0)) {
        (Some(major), minor) if (major, minor) < (5, 1) => "-vsync",
        _ => "-fps_mode",
    }
}

/// Formats that store RGB colours instead of luma and subsampled chroma.
const OF_COLOURS: [&str; 2] = ["gif", "apng"];
/// Formats whose encoders lack constant quality (`-crf`) and take a quantiser instead.
const OF_QUANTISERS: [&str; 4] = ["avi", "ogv", "mpg", "wmv"];

fn ends_in(path: &Path, endings: &[&str]) -> bool {
    let found = path.extension().unwrap_or_default();
    endings.iter().any(|ending| found.eq_ignore_ascii_case(ending))
}

/// The size of a clip of frames of `size` in the file `path`: even where chroma has half the resolution.
fn clip_size(path: &Path, size: FrameSize) -> FrameSize {
    if ends_in(path, &OF_COLOURS) { size } else { padded_to_even(size) }
}

/// The ffmpeg arguments that encode the clip `path`.
fn encoding(path: &Path) -> Vec<&'static str> {
    if ends_in(path, &["apng"]) {
        return vec!["-plays", "0"];
    }
    if ends_in(path, &["gif"]) {
        return vec!["-vf", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1"];
    }
    let mut arguments = vec![
        "-vf",
        "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,format=yuv420p",
        "-colorspace",
        "bt709",
        "-color_primaries",
        "bt709",
        "-color_trc",
        "bt709",
        "-color_range",
        "tv",
    ];
    if ends_in(path, &OF_QUANTISERS) {
        arguments.extend(["-q:v", "3"]);
    } else if ends_in(path, &["webp"]) {
        arguments.extend(["-quality", "90", "-loop", "0"]);
    } else {
        arguments.extend(["-crf", "16"]);
    }
    if ends_in(path, &["mp4", "m4v", "mov"]) {
        arguments.extend(["-movflags", "+faststart"]);
    }
    // Without a word on it ffmpeg may take .m4v for a bare stream, which holds no times.
    if ends_in(path, &["m4v"]) {
        arguments.extend(["-f", "mp4"]);
    }
    arguments
}

/// An `ffmpeg` that encodes frames into a file.
pub(super) struct Writer {
    path: PathBuf,
    size: FrameSize,
    frames: usize,
    running: Running,
    input: Option<BufWriter<ChildStdin>>,
}

impl Writer {
    /// Begins a clip of frames of `size` in the file `to`.
    pub fn new(to: &Path, size: FrameSize, rate: FrameRate) -> io::Result<Self> {
        let size = clip_size(to, size);
        let mut command = Command::new(ffmpeg_path());
        command
            .args(["-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"])
            .args(["-s", &size.to_string(), "-r", &rate.to_string(), "-i", "-"])
            .args(encoding(to))
            .arg(to)
            .stdin(Stdio::piped())
            .stdout(Stdio::null());
        let mut running = Running::start(&mut command)?;
        let input = running
            .process
            .take(|child| child.stdin.take())
            .ok_or_else(|| io::Error::other("ffmpeg takes no input"))?;
        let input = Some(BufWriter::with_capacity(1 << 20, input));
        Ok(Self { path: to.to_owned(), size, frames: 0, running, input })
    }

    /// Appends `frame`; the last row and column are repeated where the clip is larger.
    pub fn push(&mut self, frame: &Frame) -> io::Result<()> {
        let bytes = padded(&frame.to_rgb8(), frame.size(), self.size);
        let Some(input) = &mut self.input else { return Err(io::ErrorKind::BrokenPipe.into()) };
        if input.write_all(&bytes).is_err() {
            return Err(self.failure());
        }
        self.frames += 1;
        Ok(())
    }

    /// Completes the file and reads it back: every frame must be there, in its size.
    pub fn finish(mut self) -> io::Result<()> {
        let flushed = self.input.take().is_none_or(|mut input| input.flush().is_ok());
        let status = self.running.process.wait()?;
        if !flushed || !status.success() {
            return Err(self.failure());
        }
        check(&self.path, self.frames, self.size)
    }

    /// The error of a failed encoder, with the last line of `ffmpeg`'s output.
    fn failure(&mut self) -> io::Error {
        drop(self.input.take());
        io::Error::other(format!("ffmpeg could not encode it{}", self.running.last_words()))
    }
}

/// `bytes` of RGB pixels of a frame of `from`, at the size `to`.
fn padded(bytes: &[u8], from: FrameSize, to: FrameSize) -> Vec<u8> {
    if from == to {
        return bytes.to_vec();
    }
    let mut out = Vec::with_capacity(3 * to.pixels());
    for y in 0..to.height.min(from.height + 1) {
        let start = 3 * y.min(from.height - 1) as usize * from.width as usize;
        let row = &bytes[start..start + 3 * from.width as usize];
        out.extend_from_slice(row);
        for _ in from.width..to.width {
            out.extend_from_slice(&row[row.len() - 3..]);
        }
    }
    out
}

/// Whether the clip at `path` holds `frames` frames of `size`.
fn check(path: &Path, frames: usize, size: FrameSize) -> io::Result<()> {
    let broken = |found: String| {
        io::Error::other(format!("the clip that ffmpeg wrote is broken: {found}; is the disk full?"))
    };
    if ends_in(path, &["webp"]) {
        // No ffmpeg reads animations of this kind.
        return match animated_webp_frames(&mut BufReader::new(File::open(path)?))? {
            // One frame is a picture without chunks of an animation.
            found if found == frames || (found == 0 && frames == 1) => Ok(()),
            found => Err(broken(format!("it holds {found} of {frames} frames"))),
        };
    }
    let Listing { text: listed, status, said } = list_frames(path)?;
    let found = count_listed(&listed);
    let has_size = listed.lines().any(|line| line == format!("#dimensions 0: {size}"));
    match () {
        () if !status.success() || !said.is_empty() => {
            Err(broken(format!("it cannot be read back{}", last_line(&said))))
        }
        () if found != frames => Err(broken(format!("it holds {found} of {frames} frames"))),
        () if frames > 0 && !has_size => Err(broken(format!("its frames are not of {size}"))),
        () => Ok(()),
    }
}

/// How many frames the animation in a RIFF file of WebP holds; an error where a chunk is cut off.
fn animated_webp_frames(from: &mut (impl Read + io::Seek)) -> io::Result<usize> {
    let length = from.seek(io::SeekFrom::End(0))?;
    let (mut at, mut frames) = (12, 0);
    while at < length {
        from.seek(io::SeekFrom::Start(at))?;
        let mut head = [0; 8];
        from.read_exact(&mut head)?;
        let size = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        frames += usize::from(&head[..4] == b"ANMF");
        at += 8 + size + size % 2;
    }
    if at == length { Ok(frames) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

/// An `ffmpeg` process that decodes the frames of a clip of any colour matrix, range and frame rate.
pub(super) struct Reader {
    path: PathBuf,
    running: Running,
    /// None once it has ended.
    frames: Option<y4m_file::Reader<BufReader<ChildStdout>>>,
}

impl Reader {
    /// Begins to read the clip at `path`.
    pub fn new(path: &Path) -> Result<Self> {
        let failed = |e| Error::io("read", path, e);
        let mut command = Command::new(ffmpeg_path());
        command.args(["-loglevel", "error", "-i"]).arg(path).args([
            "-map",
            "0:v:0",
            timing_option(),
            "passthrough",
        ]);
        let matrix =
            "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int+full_chroma_inp";
        command.args(["-vf", &format!("{matrix},format=yuv444p"), "-f", "yuv4mpegpipe", "-"]);
        let mut running =
            Running::start(command.stdin(Stdio::null()).stdout(Stdio::piped())).map_err(failed)?;
        let output = running
            .process
            .take(|child| child.stdout.take())
            .ok_or_else(|| failed(io::Error::other("ffmpeg says nothing")))?;
        let mut reader = Self { path: path.to_owned(), running, frames: None };
        match y4m_file::Reader::new(path, BufReader::with_capacity(1 << 20, output)) {
            Ok(frames) => reader.frames = Some(frames),
            Err(error) => return reader.ended(Err(error)),
        }
        Ok(reader)
    }

    /// The next frame; none at the end.
    pub fn next(&mut self) -> Result<Option<Frame>> {
        let Some(frames) = &mut self.frames else { return Ok(None) };
        let next = frames.next();
        if matches!(next, Ok(Some(_))) {
            return next;
        }
        self.frames = None;
        self.ended(next)
    }

    /// Waits for ffmpeg to end and returns `outcome`, or ffmpeg's error if it failed.
    ///
    /// ffmpeg does end, because nobody reads its output any more.
    fn ended<T>(&mut self, outcome: Result<T>) -> Result<T> {
        let status = self.running.process.wait().map_err(|e| Error::io("read", &self.path, e))?;
        if status.success() {
            return outcome;
        }
        Err(unreadable(&self.path, &self.running.last_words()))
    }
}

/// The error for a file at `path` that ffmpeg cannot read; `words` are ffmpeg's own, in brackets.
fn unreadable(path: &Path, words: &str) -> Error {
    Error::malformed(path, format!("ffmpeg cannot read it as a clip{words}; check the file"))
}

/// The number of frames of the clip at `path`. They are decoded, but their colours are not made.
pub(super) fn count_frames(path: &Path) -> Result<usize> {
    let listed = list_frames(path).map_err(|e| Error::io("read", path, e))?;
    if !listed.status.success() {
        return Err(unreadable(path, &last_line(&listed.said)));
    }
    Ok(count_listed(&listed.text))
}

/// Output of ffmpeg when it lists the frames of a clip.
struct Listing {
    /// One line per frame, after lines that begin with `#`.
    text: String,
    status: ExitStatus,
    /// The end of its errors.
    said: Vec<u8>,
}

/// Has ffmpeg list the frames of the clip at `path`.
fn list_frames(path: &Path) -> io::Result<Listing> {
    let mut command = Command::new(ffmpeg_path());
    command.args(["-loglevel", "error", "-i"]).arg(path);
    command.args(["-map", "0:v:0", timing_option(), "passthrough", "-f", "framecrc", "-"]);
    let mut running = Running::start(command.stdin(Stdio::null()).stdout(Stdio::piped()))?;
    let mut listed = Vec::new();
    let list = running.process.take(|child| child.stdout.take());
    list.map(|mut list| list.read_to_end(&mut listed)).transpose()?;
    let (status, said) = running.end()?;
    Ok(Listing { text: String::from_utf8_lossy(&listed).into_owned(), status, said })
}

fn count_listed(listed: &str) -> usize {
    listed.lines().filter(|line| !line.starts_with('#')).count()
}

/// A process whose errors are listened to, and which ends when nobody waits for it any more.
struct Running {
    process: ChildProcess,
    errors: Option<JoinHandle<Vec<u8>>>,
}

impl Running {
    fn start(command: &mut Command) -> io::Result<Self> {
        let mut process = ChildProcess::start(command.stderr(Stdio::piped()))?;
        let errors = process.take(|child| child.stderr.take());
        let errors = errors.map(|errors| std::thread::spawn(|| end_of(errors)));
        Ok(Self { process, errors })
    }

    /// How it ended, and the end of its errors.
    fn end(&mut self) -> io::Result<(ExitStatus, Vec<u8>)> {
        let status = self.process.wait()?;
        let said = self.errors.take().and_then(|errors| errors.join().ok());
        Ok((status, said.unwrap_or_default()))
    }

    /// The last line of the error output in brackets, once the process has ended; empty if it printed none.
    fn last_words(&mut self) -> String {
        // It ends by itself: its input is closed.
        self.end().map_or_else(|_| String::new(), |(_, said)| last_line(&said))
    }
}

/// The last bytes that come `from` a process, all of which are read so that it never waits.
fn end_of(mut from: ChildStderr) -> Vec<u8> {
    const KEPT: usize = 4096;
    let (mut end, mut chunk) = (Vec::new(), [0; KEPT]);
    while let Ok(count @ 1..) = from.read(&mut chunk) {
        end.extend_from_slice(&chunk[..count]);
        end.drain(..end.len().saturating_sub(KEPT));
    }
    end
}

/// The last line of `said` in brackets.
fn last_line(said: &[u8]) -> String {
    let said = String::from_utf8_lossy(said);
    let line = said.lines().rev().find(|line| !line.trim().is_empty());
    line.map_or_else(String::new, |line| format!(" ({})", line.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_repeats_the_last_row_and_column() {
        let size = |w, h| FrameSize::new(w, h).unwrap();
        let bytes = [1, 1, 1, 2, 2, 2, 3, 3, 3];
        let row = [1, 1, 1, 2, 2, 2, 3, 3, 3, 3, 3, 3];
        assert_eq!(padded(&bytes, size(3, 1), size(4, 2)), [row, row].concat());
        assert_eq!(padded(&bytes, size(3, 1), size(3, 1)), bytes);
    }

    #[test]
    fn versions_know_their_options() {
        for (version, option) in [
            ("ffmpeg version 4.4.2-0ubuntu0.22.04.1 Copyright", "-vsync"),
            ("ffmpeg version 5.0 Copyright", "-vsync"),
            ("ffmpeg version 5.1.6-0+deb12u1 Copyright", "-fps_mode"),
            ("ffmpeg version n9.0.2-17-g2a571b6068-20260930 Copyright", "-fps_mode"),
            ("ffmpeg version N-118000-g0000000000 Copyright", "-fps_mode"),
            ("", "-fps_mode"),
        ] {
            assert_eq!(timing_option_of(version), option, "{version}");
        }
    }

    #[test]
    fn chunks_that_are_cut_off_are_seen() {
        let mut file = b"RIFF\0\0\0\0WEBP".to_vec();
        file.extend(b"ANMF\x03\0\0\0abc\0ANMF\x02\0\0\0ab");
        assert_eq!(animated_webp_frames(&mut io::Cursor::new(&file)).unwrap(), 2);
        file.pop();
        assert!(animated_webp_frames(&mut io::Cursor::new(&file)).is_err());
    }
}
