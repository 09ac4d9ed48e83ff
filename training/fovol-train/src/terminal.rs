//! What programs say.

use std::fmt::Display;
use std::io::{self, Write};

/// Writes a line to standard output. Where nobody reads that any more, as after `| head`, it is lost: no reason to end what
/// takes hours.
pub fn say(line: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{line}");
}
