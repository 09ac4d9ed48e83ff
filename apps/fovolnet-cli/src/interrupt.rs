//! Ctrl-C asks for a stop; a second one stops at once.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens for Ctrl-C from now on.
pub fn install() {
    let listening = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            #[expect(
                clippy::disallowed_methods,
                reason = "the user insists; there is no main to return to from here"
            )]
            std::process::exit(1);
        }
    });
    // Without a handler Ctrl-C ends the program the hard way, which is no reason not to start.
    drop(listening);
}

/// Whether a stop was asked for.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// The switch itself, for work that watches it.
pub fn flag() -> &'static AtomicBool {
    &ASKED
}

/// An error that says what is complete, if a stop was asked for.
pub fn check(complete: &str) -> anyhow::Result<()> {
    anyhow::ensure!(!asked(), "interrupted; {complete}");
    Ok(())
}
