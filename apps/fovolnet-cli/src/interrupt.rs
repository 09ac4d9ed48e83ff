//! Reaction of a command to a signal that asks it to stop, see [`fovolnet::signals`].

use fovolnet::core::stop;

/// Listens to signals from now on.
pub fn install() {
    fovolnet::signals::listen(|| ());
}

/// Whether a signal has asked to stop.
pub fn asked() -> bool {
    stop::asked()
}

/// Returns an error with `complete`, the finished results, if a signal has asked to stop.
pub fn check(complete: &str) -> anyhow::Result<()> {
    if asked() { Err(error(complete)) } else { Ok(()) }
}

/// Error of an interrupted command; `complete` says which results are finished.
pub fn error(complete: &str) -> anyhow::Error {
    anyhow::anyhow!("interrupted; {complete}")
}

/// Runs `work` for one frame. `None` if a signal interrupted it, or came before it began.
///
/// # Errors
/// Errors of `work`.
pub fn unless_asked<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<Option<T>> {
    if asked() { Ok(None) } else { stop::catch(work).ok().transpose() }
}

/// Runs `work` for a whole command. An interruption is an error; files that were being written then do not get their
/// names.
pub fn leave<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    stop::catch(work).unwrap_or_else(|_| Err(error("files that have their names are complete")))
}
