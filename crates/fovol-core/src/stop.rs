//! A stop of the whole program, which long work looks for.
//!
//! Somebody asks for it once ([`ask`]), after a signal for instance. Work that may take long calls [`point`] at every row, tile,
//! slab or frame: there it is left at once, through whatever lies above it, up to the next [`catch`]. What it holds is dropped on
//! the way as after an error, so temporary files are removed. A program that never asks never notices any of this.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Work was left because a stop was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Stopped;

/// Asks all work of this process to stop. There is no way back: the program is about to end.
pub fn ask() {
    ASKED.store(true, Ordering::Release);
}

/// Whether a stop was asked for.
pub fn asked() -> bool {
    ASKED.load(Ordering::Acquire)
}

/// The switch itself, for work that takes one.
pub fn flag() -> &'static AtomicBool {
    &ASKED
}

/// Leaves the work here if a stop was asked for. Costs next to nothing where none was: good for every row of a picture, not for
/// every pixel.
///
/// Must not be called on a thread whose panics nobody passes on; threads of rayon's pools pass theirs on.
#[inline]
pub fn point() {
    if ASKED.load(Ordering::Relaxed) {
        leave();
    }
}

/// No panic of a bug: no hook is told, nothing is printed. Within a drop on the way out it would end the process, so not there.
#[cold]
fn leave() {
    if !std::thread::panicking() {
        resume_unwind(Box::new(Stopped));
    }
}

/// Does `work`, and comes back from it also where it was left at a [`point`]. What `work` was changing is not to be used then.
///
/// # Errors
/// It was left. Any other panic goes on.
pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, Stopped> {
    catch_unwind(AssertUnwindSafe(work))
        .map_err(|cause| if is_stop(&*cause) { Stopped } else { resume_unwind(cause) })
}

/// Whether `cause`, which a caught panic brought along, is that of work that was left at a [`point`].
pub fn is_stop(cause: &(dyn Any + Send)) -> bool {
    cause.is::<Stopped>()
}
