//! What a command does when a signal asks it to stop, see [`fovolnet::signals`].

use fovolnet::core::stop;

/// Listens to signals from now on.
pub fn install() {
    fovolnet::signals::listen(|| ());
}

/// Whether a stop was asked for.
pub fn asked() -> bool {
    stop::asked()
}

/// An error that says what is complete, if a stop was asked for.
pub fn check(complete: &str) -> anyhow::Result<()> {
    if asked() { Err(error(complete)) } else { Ok(()) }
}

/// The error of a command that was stopped, with what is complete.
pub fn error(complete: &str) -> anyhow::Error {
    anyhow::anyhow!("interrupted; {complete}")
}

/// Does the work of a frame; nothing where it was left in the middle, or is not to begin.
///
/// # Errors
/// Those of `work`.
pub fn unless_asked<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<Option<T>> {
    if asked() { Ok(None) } else { stop::catch(work).ok().transpose() }
}

/// Does the work of a command. Where it is left in the middle it is an error: nothing that it was writing has its name.
pub fn leave<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    stop::catch(work).unwrap_or_else(|_| Err(error("files that have their names are complete")))
}
