//! Output to the console: notes, warnings, progress and JSON reports.

use anyhow::{Context, Result};
use fovolnet::{OpenVolume, Pipeline};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Option for a JSON report.
#[derive(clap::Args, Clone, Default)]
pub struct JsonOutput {
    /// Write the figures as JSON (`-`: to standard output, alone)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl JsonOutput {
    /// Whether the JSON goes to standard output.
    pub fn on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// File of the JSON, if it goes to a file.
    pub fn file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|_| !self.on_stdout())
    }

    /// Writes `figures` as JSON, if requested.
    pub fn write(&self, figures: &impl Serialize) -> Result<()> {
        let Some(path) = &self.json else { return Ok(()) };
        let text = serde_json::to_string_pretty(figures).context("the figures cannot be written as JSON")?;
        let text = escaped(&text);
        if self.on_stdout() {
            writeln!(io::stdout(), "{text}")?;
        } else {
            fovolnet::io::atomic::write(path, |out| writeln!(out, "{text}"))?;
        }
        Ok(())
    }

    /// Prints `line` for people, unless the JSON goes to standard output.
    pub fn say(&self, line: impl AsRef<str>) -> Result<()> {
        if self.on_stdout() { Ok(()) } else { say(line) }
    }
}

/// Escapes control characters in the texts of `json`. JSON itself allows DEL and the C1 controls unescaped.
fn escaped(json: &str) -> String {
    json.chars().fold(String::with_capacity(json.len()), |mut text, c| {
        if c.is_control() && c != '\n' {
            text.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            text.push(c);
        }
        text
    })
}

/// Prints `line` to standard output, safe for terminals: see [`fovolnet::printable`].
///
/// # Errors
/// Errors of writing to standard output; see [`is_broken_pipe`].
pub fn say(line: impl AsRef<str>) -> Result<()> {
    writeln!(io::stdout(), "{}", fovolnet::printable(line.as_ref()))?;
    Ok(())
}

/// Prints a note of one line: an assumption, or something good to know.
pub fn note(text: impl AsRef<str>) {
    eprintln!("note: {}", fovolnet::printable_line(text.as_ref()));
}

/// Prints a warning of one line.
pub fn warning(text: impl AsRef<str>) {
    eprintln!("warning: {}", fovolnet::printable_line(text.as_ref()));
}

/// Prints remarks and notes on `volume`.
pub fn remark(volume: &OpenVolume) {
    for remark in volume.remarks() {
        warning(remark);
    }
    for note in volume.notes() {
        self::note(note);
    }
}

/// Prints `notes` on data that the file at `path` could not hold.
pub fn notes_of(path: &Path, notes: &[String]) {
    for text in notes {
        note(format!("{}: {text}", path.display()));
    }
}

/// Prints the notes of `pipeline`.
pub fn warn(pipeline: &Pipeline) {
    for note in pipeline.notes() {
        self::note(note);
    }
}

/// Progress display: a bar on a terminal, elsewhere a line at every tenth of the way.
pub struct Progress {
    bar: Option<ProgressBar>,
    what: &'static str,
    total: u64,
    done: u64,
}

impl Progress {
    /// Progress of `what` over `total` steps.
    pub fn new(what: &'static str, total: u64) -> Self {
        let bar = io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}")
                .expect("the template is sound");
            ProgressBar::new(total).with_style(style).with_message(what)
        });
        Self { bar, what, total, done: 0 }
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        self.to(self.done + 1);
    }

    /// Advances to `done` steps.
    pub fn to(&mut self, done: u64) {
        let tenth = |n: u64| (10 * n).checked_div(self.total).unwrap_or(0);
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        } else if tenth(done) > tenth(self.done) {
            eprintln!("{} {done}/{}", self.what, self.total);
        }
        self.done = done;
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Whether `error` means that the reader of standard output is gone.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}
