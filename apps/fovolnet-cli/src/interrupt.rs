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
    anyhow::ensure!(!asked(), "interrupted; {complete}");
    Ok(())
}

/// Does the work of a command. Where it is left in the middle it is an error: nothing that it was writing has its name.
pub fn leave<T>(work: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    stop::catch(work).unwrap_or_else(|_| anyhow::bail!("interrupted; files that have their names are complete"))
}
