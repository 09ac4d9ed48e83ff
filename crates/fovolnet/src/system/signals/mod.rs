//! Signals that end a program: INT (Ctrl-C), TERM and HUP.
//!
//! The first signal asks all work to stop, see [`fovol_core::stop`]. A thread of its own ends the program if that takes
//! longer than [`PATIENCE`], so the program ends within a second, whatever it is doing. A second signal ends it at
//! once. No temporary file and no child process is left behind, see [`fovol_core::unfinished`].
//!
//! A program started with HUP ignored (`nohup`) keeps ignoring it.

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

/// Time for work to stop by itself.
pub const PATIENCE: Duration = Duration::from_millis(700);

/// Longest wait for a thread that is renaming a file: after [`PATIENCE`], and after a second signal.
const RENAMING: [Duration; 2] = [Duration::from_millis(2000), Duration::from_millis(200)];

/// Exit status of an interrupted program.
pub const INTERRUPTED: u8 = 1;

/// Message if the work itself does not report the interruption.
const SAID: &str = "error: interrupted; files that have their names are complete\n";

/// Whether the interruption has been reported.
static IS_SAID: AtomicBool = AtomicBool::new(false);

/// Listens to signals from now on. The first signal calls `on_stop` on a thread of its own, to wake work that sleeps.
///
/// If the system cannot listen, signals end the program the usual way. That is no reason not to start it.
pub fn listen(on_stop: impl FnOnce() + Send + 'static) {
    hear(move |signals| {
        stop::ask();
        on_stop();
        signals.wait_for(PATIENCE)
    });
}

/// Listens like [`listen`], for a program that must save its work, however long that takes: the first signal only calls
/// `on_stop`.
pub fn listen_patiently(on_stop: impl FnOnce() + Send + 'static) {
    hear(move |signals| {
        on_stop();
        signals.wait()
    });
}

/// Runs `first` after the first signal. `first` also waits for the end of the work; it returns whether a second signal
/// asks to end at once.
fn hear(first: impl FnOnce(&mut system::Signals) -> bool + Send + 'static) {
    let Ok(mut signals) = system::Signals::listen() else { return };
    let wait = move || {
        if signals.wait() {
            let is_second = first(&mut signals);
            end(RENAMING[usize::from(is_second)]);
        }
    };
    // If no thread can be started, the program cannot do its work either.
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// Notes that the program has reported the interruption, so that no second message follows.
pub fn said() {
    IS_SAID.store(true, Ordering::Relaxed);
}

/// Removes the files that other threads are writing, and makes sure that they start no more. Call it when a program
/// ends before its threads.
pub fn leave_nothing() {
    std::mem::forget(unfinished::abandon(RENAMING[0]));
}

/// Ends the process whatever its other threads do; none of their temporary files is left.
fn end(renaming: Duration) -> ! {
    let _gate = unfinished::abandon(renaming);
    #[cfg(feature = "gpu")]
    let _cache = fovol_gpu::abandon_cache();
    if !IS_SAID.load(Ordering::Relaxed) {
        system::say(SAID);
    }
    system::exit(INTERRUPTED)
}
