/// Errors on the way from settings to a picture. Each message is one line that says what is wrong, where, and how to
/// mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Reading or writing a file.
    #[error(transparent)]
    Io(#[from] fovol_io::Error),
    /// Invalid number or extent.
    #[error(transparent)]
    Core(#[from] fovol_core::Error),
    /// Invalid procedural volume.
    #[error(transparent)]
    Procedural(#[from] fovol_io::procedural::Error),
    /// Frames that cannot be compared.
    #[error(transparent)]
    Metrics(#[from] fovol_metrics::Error),
    /// Invalid network or weights.
    #[error(transparent)]
    Network(#[from] fovol_net::Error),
    /// Failure of a GPU.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] fovol_gpu::GpuError),
    /// Invalid setting; the message gives reason and remedy.
    #[error("{0}")]
    Setting(String),
    /// Settings that exclude each other.
    #[error("{0}")]
    Contradiction(String),
}

/// Result with the errors of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Whether a GPU failed, so that the CPU may still work.
    pub fn is_of_gpu(&self) -> bool {
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(_) | Self::Network(fovol_net::Error::Gpu(_)) => true,
            _ => false,
        }
    }
}

#[cfg(feature = "gpu")]
impl From<fovol_render::gpu::Error> for Error {
    fn from(error: fovol_render::gpu::Error) -> Self {
        use fovol_render::gpu::Error::{Gpu, Scene};
        match error {
            Scene(error) => error.into(),
            Gpu(error) => error.into(),
            other => Self::Setting(other.to_string()),
        }
    }
}

/// Escapes control characters in `text` except line ends and tabs, so that a terminal may show it.
///
/// Names and contents of files may hold sequences that recolour or retitle a terminal, or that reverse the direction of
/// text.
pub fn printable(text: &str) -> String {
    let is_harmful = |c: char| {
        let turns_text = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns_text || (c.is_control() && c != '\n' && c != '\t')
    };
    text.chars().fold(String::with_capacity(text.len()), |mut shown, c| {
        if is_harmful(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
        shown
    })
}

/// Most characters of a line for a terminal.
const LONGEST_LINE: usize = 1000;
/// Characters kept at the end of a shortened line. Messages say there how to mend the problem.
const KEPT_END: usize = 400;

/// Makes `text` one line that a terminal may show, see [`printable`]. The middle of a long line is left out.
pub fn printable_line(text: &str) -> String {
    shortened(&printable(&text.split_whitespace().collect::<Vec<_>>().join(" ")))
}

/// Keeps only the beginning and the end of a `line` with more than [`LONGEST_LINE`] characters.
fn shortened(line: &str) -> String {
    let count = line.chars().count();
    if count <= LONGEST_LINE {
        return line.to_owned();
    }
    let begin: String = line.chars().take(LONGEST_LINE - KEPT_END - 3).collect();
    let end: String = line.chars().skip(count - KEPT_END).collect();
    format!("{begin} … {end}")
}

/// Number that the system's message of a missing file ends in; its words say as much.
const NUMBER_OF_MISSING: &str = " (os error 2)";

/// Joins `error` and its causes to one line. Each message appears once, since many errors repeat their cause.
///
/// The line is safe to show on a terminal, see [`printable`].
pub fn one_line(error: &(dyn std::error::Error + 'static)) -> String {
    let causes = std::iter::successors(Some(error), |error| error.source());
    let mut line = String::new();
    for text in causes.map(|cause| cause.to_string().replace(NUMBER_OF_MISSING, "")) {
        if !line.contains(&text) {
            if !line.is_empty() {
                line.push_str(": ");
            }
            line.push_str(&text);
        }
    }
    printable_line(&line)
}

/// Message of the command-line error `error` as one line that a terminal may show, see [`printable`].
#[cfg(feature = "clap")]
pub fn usage_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines = text.lines().take_while(|line| !line.starts_with("Usage:")).map(str::trim);
    let said = lines.collect::<Vec<_>>().join(" ");
    let said = said.trim().trim_start_matches("error: ").split("For more information").next();
    printable_line(&format!("{}{}", said.unwrap_or_default().trim_end(), advice(error)))
}

/// Advice for flags that exclude each other.
#[cfg(feature = "clap")]
fn advice(error: &clap::Error) -> &'static str {
    let is_conflict = error.kind() == clap::error::ErrorKind::ArgumentConflict;
    match is_conflict && error.to_string().contains("'--camera ") {
        true => "; a --camera stands still: leave it out, or move it with keyframes (--path FILE.toml)",
        false => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[derive(Debug, thiserror::Error)]
    #[error("the picture is\nmissing")]
    struct Missing(#[source] Error);

    #[test]
    fn terminals_are_safe_from_text() {
        assert_eq!(
            printable("é\t1\n\x1b[31m\u{9b}2J\u{202e}\x7f"),
            "é\t1\n\\u{1b}[31m\\u{9b}2J\\u{202e}\\u{7f}"
        );
        assert_eq!(printable_line("a\r\nb \x07 c"), "a b \\u{7} c");
    }

    #[test]
    fn long_lines_keep_their_beginning_and_their_end() {
        let line = printable_line(&format!("cannot read {}; check the path", "é\x1b".repeat(3000)));
        assert_eq!(line.chars().count(), LONGEST_LINE);
        assert!(line.starts_with("cannot read é") && line.ends_with("; check the path"), "{line}");
        let whole = "x".repeat(LONGEST_LINE);
        assert_eq!(printable_line(&whole), whole);
    }

    #[test]
    fn causes_are_said_once() {
        let refused = std::io::Error::other("no disk");
        let error = Missing(fovol_io::Error::io("read", Path::new("a.raw"), refused).into());
        let line = one_line(&error);
        assert!(line.starts_with("the picture is missing: cannot read a.raw: no disk"), "{line}");
        assert_eq!(line.matches("no disk").count(), 1, "{line}");
    }

    #[test]
    fn missing_files_have_no_number() {
        let path = Path::new("no/such.nii");
        let missing = std::fs::read(path).unwrap_err();
        let line = one_line(&fovol_io::Error::io("read", path, missing));
        assert!(
            line.starts_with("cannot read no/such.nii: ") && line.ends_with("; check the path"),
            "{line}"
        );
        assert!(!line.contains("os error"), "{line}");
    }
}
