//! What is said, and where.

use anyhow::{Context, Result};
use fovolnet::{OpenVolume, Pipeline};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Where figures go besides the console.
#[derive(clap::Args, Clone, Default)]
pub struct JsonOutput {
    /// Write the figures as JSON (`-`: to standard output, alone)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl JsonOutput {
    /// Whether standard output belongs to the JSON.
    pub fn on_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// The file that the JSON goes to, if to one.
    pub fn file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|_| !self.on_stdout())
    }

    /// Writes `figures` where they were asked for.
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

    /// Prints `line` for people, unless standard output belongs to the JSON.
    pub fn say(&self, line: impl AsRef<str>) -> Result<()> {
        if self.on_stdout() { Ok(()) } else { say(line) }
    }
}

/// `json` with control characters in its texts as JSON escapes: DEL and C1 ones may stand there as they are otherwise.
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

/// Prints `line` for people, safely: see [`fovolnet::printable`].
///
/// # Errors
/// Standard output that cannot be written to; see [`is_broken_pipe`].
pub fn say(line: impl AsRef<str>) -> Result<()> {
    writeln!(io::stdout(), "{}", fovolnet::printable(line.as_ref()))?;
    Ok(())
}

/// Prints a note of one line: what was assumed, or is good to know.
pub fn note(text: impl AsRef<str>) {
    eprintln!("note: {}", fovolnet::printable_line(text.as_ref()));
}

/// Prints a warning of one line.
pub fn warning(text: impl AsRef<str>) {
    eprintln!("warning: {}", fovolnet::printable_line(text.as_ref()));
}

/// Prints what whoever asked for `volume` should know about it.
pub fn remark(volume: &OpenVolume) {
    for remark in volume.remarks() {
        warning(remark);
    }
    for note in volume.notes() {
        self::note(note);
    }
}

/// Prints what the file at `path` could not hold.
pub fn notes_of(path: &Path, notes: &[String]) {
    for text in notes {
        note(format!("{}: {text}", path.display()));
    }
}

/// Prints what whoever asked for `pipeline` should know about it.
pub fn warn(pipeline: &Pipeline) {
    for note in pipeline.notes() {
        self::note(note);
    }
}

/// A bar on a terminal; elsewhere a plain line at every tenth of the way.
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

    /// One step is done.
    pub fn step(&mut self) {
        self.to(self.done + 1);
    }

    /// `done` steps are done.
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

/// Whether `error` is that nobody reads our standard output any more.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}
