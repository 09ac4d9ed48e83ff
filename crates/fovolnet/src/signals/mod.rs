//! Signals that end a program: INT (Ctrl-C), TERM and HUP.
//!
//! The first one asks all work to stop, see [`fovol_core::stop`]. What has not ended within [`PATIENCE`] is ended from here: on a
//! thread of its own that waits for nobody, so however long a part of the work takes the program ends within a second. A second
//! signal does so at once. No temporary file is left and no program that helps, see [`fovol_core::unfinished`].
//!
//! A program that was started with HUP ignored (`nohup`) goes on ignoring it.

#[cfg(not(unix))]
mod console_events;
#[cfg(unix)]
mod pipe;

#[cfg(not(unix))]
use console_events as system;
use fovol_core::{stop, unfinished};
#[cfg(unix)]
use pipe as system;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long work has to stop by itself.
pub const PATIENCE: Duration = Duration::from_millis(700);

/// How long a thread that is renaming a file may take for it, after [`PATIENCE`] and after a second signal.
const RENAMING: [Duration; 2] = [Duration::from_millis(2000), Duration::from_millis(200)];

/// The exit status of a program that was interrupted.
pub const INTERRUPTED: u8 = 1;

/// What is said where the work does not come to say anything itself.
const SAID: &str = "error: interrupted; files that have their names are complete\n";

/// Whether somebody has said that the program was interrupted.
static IS_SAID: AtomicBool = AtomicBool::new(false);

/// Listens to signals from now on. `on_stop` is called after the first one, on a thread of its own: to wake work that sleeps.
///
/// Where the system cannot listen, signals end the program the hard way, which is no reason not to start it.
pub fn listen(on_stop: impl FnOnce() + Send + 'static) {
    hear(move |signals| {
        stop::ask();
        on_stop();
        signals.wait_for(PATIENCE)
    });
}

/// As [`listen`], for a program that has work to save, however long that takes: the first signal only calls `on_stop`.
pub fn listen_patiently(on_stop: impl FnOnce() + Send + 'static) {
    hear(move |signals| {
        on_stop();
        signals.wait()
    });
}

/// Has `first` do what is to be done after the first signal and wait for the end; it says whether a second signal asks for that.
fn hear(first: impl FnOnce(&mut system::Signals) -> bool + Send + 'static) {
    let Ok(mut signals) = system::Signals::listen() else { return };
    let wait = move || {
        if signals.wait() {
            let is_second = first(&mut signals);
            end(RENAMING[usize::from(is_second)]);
        }
    };
    // A system without room for a thread starts no work either.
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// The program has said that it was interrupted: nothing more is said if it has to be ended.
pub fn said() {
    IS_SAID.store(true, Ordering::Relaxed);
}

/// For a program that ends although threads of it may still write files: none of theirs is left, and they make no more.
pub fn leave_nothing() {
    std::mem::forget(unfinished::abandon(RENAMING[0]));
}

/// Ends the process whatever its other threads do: nothing of them is left.
fn end(renaming: Duration) -> ! {
    let _gate = unfinished::abandon(renaming);
    #[cfg(feature = "gpu")]
    let _cache = fovol_gpu::abandon_cache();
    if !IS_SAID.load(Ordering::Relaxed) {
        system::say(SAID);
    }
    system::exit(INTERRUPTED)
}
