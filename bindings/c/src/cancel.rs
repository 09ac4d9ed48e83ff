//! Cancelling: the library has one stop flag for the whole process, so all calls in progress end together.

use fovolnet::core::stop;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Long calls in progress.
struct Calls {
    running: usize,
    is_ending: bool,
}

static CALLS: Mutex<Calls> = Mutex::new(Calls { running: 0, is_ending: false });
static ENDED: Condvar = Condvar::new();

fn calls() -> MutexGuard<'static, Calls> {
    CALLS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends all calls that are at work in this moment, on any thread: they return FOVOLNET_CANCELLED within milliseconds. Calls that
/// begin later wait until those have ended, and then do their work. Objects stay usable; a renderer that was cancelled prepares
/// its volume again, and a network forgets earlier frames. Does nothing if no call is at work. Any thread may call it, but no
/// signal handler may.
#[unsafe(no_mangle)]
pub extern "C" fn fovolnet_cancel() {
    let mut calls = calls();
    if calls.running > 0 {
        calls.is_ending = true;
        stop::ask();
    }
}

/// One long call in progress.
pub struct Running(());

impl Running {
    /// Begins a call, after all calls that are being cancelled have ended.
    pub fn begin() -> Self {
        let calls = calls();
        let mut calls =
            ENDED.wait_while(calls, |calls| calls.is_ending).unwrap_or_else(PoisonError::into_inner);
        calls.running += 1;
        Self(())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let mut calls = calls();
        calls.running -= 1;
        if calls.running == 0 && calls.is_ending {
            calls.is_ending = false;
            stop::withdraw();
            ENDED.notify_all();
        }
    }
}
