//! A stop of the whole program, which long work checks for.
//!
//! [`ask`] requests it once, for instance after a signal. Long work calls [`point`] at every row, tile, slab or frame.
//! After the request, [`point`] unwinds the stack up to the next [`catch`]. Destructors run as after an error, so
//! temporary files are removed. Programs that never ask are not affected.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Error: work was abandoned because a stop was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Stopped;

/// Asks all work of this process to stop: the program is about to end, or will [`withdraw`] the request.
pub fn ask() {
    ASKED.store(true, Ordering::Release);
}

/// Takes the request back, in programs that go on after their work has ended.
pub fn withdraw() {
    ASKED.store(false, Ordering::Release);
}

/// Whether a stop was asked for.
pub fn asked() -> bool {
    ASKED.load(Ordering::Acquire)
}

/// Flag of the stop request, for libraries that take a flag.
pub fn flag() -> &'static AtomicBool {
    &ASKED
}

/// Unwinds if a stop was asked for. The check is cheap enough for every row of a picture, but not for every pixel.
///
/// Call it only on threads whose panics are passed on. Rayon's pools do so.
#[inline]
pub fn point() {
    if ASKED.load(Ordering::Relaxed) {
        leave();
    }
}

/// Unwinds without calling the panic hook, so nothing is printed. A second panic while unwinding would abort the
/// process, so there is none then.
#[cold]
fn leave() {
    if !std::thread::panicking() {
        resume_unwind(Box::new(Stopped));
    }
}

/// Runs `work`, and returns also when it was abandoned at a [`point`]. The data that `work` was changing must not be
/// used then.
///
/// # Errors
/// [`Stopped`] if the work was abandoned. Other panics are passed on.
pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, Stopped> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|cause| if is_stop(&*cause) { Stopped } else { resume_unwind(cause) })
}

/// Whether `cause`, the payload of a caught panic, comes from a [`point`].
pub fn is_stop(cause: &(dyn Any + Send)) -> bool {
    cause.is::<Stopped>()
}
