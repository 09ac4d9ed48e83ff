//! Output to the terminal.

use std::fmt::Display;
use std::io::{self, Write};

/// Writes a line to standard output. A closed pipe, as after `| head`, is ignored, since it should not end a long
/// run.
pub fn say(line: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{line}");
}
