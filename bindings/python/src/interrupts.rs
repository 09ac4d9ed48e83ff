//! Work without the interpreter's lock that Ctrl-C ends.

use crate::errors::{interrupted, wrong};
use fovolnet::core::stop;
use pyo3::prelude::*;
use std::process;
use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often the interpreter is asked for signals.
const PERIOD: Duration = Duration::from_millis(50);

/// The process that first worked, whose threads no fork of it has.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Checks that this process is no fork of one that has worked.
pub fn check_process() -> PyResult<()> {
    if *PROCESS.get_or_init(process::id) == process::id() {
        return Ok(());
    }
    Err(wrong(
        "this process was forked after fovolnet had started threads, which a fork does not have; start processes with \
         multiprocessing.set_start_method(\"spawn\")",
    ))
}

/// Runs `work` on a thread of its own, without the interpreter's lock.
///
/// # Errors
/// `KeyboardInterrupt`, or what another signal raises. What `work` was changing must not be used then. A process that was
/// forked after work had begun.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    check_process()?;
    py.detach(|| {
        std::thread::scope(|scope| {
            let (done, wait) = channel();
            let worker = scope.spawn(move || {
                let result = stop::catch(work);
                // The receiver waits until it hears this.
                let _ = done.send(());
                result
            });
            let mut raised = None;
            while let Err(RecvTimeoutError::Timeout) = wait.recv_timeout(PERIOD) {
                if raised.is_none()
                    && let Err(error) = Python::attach(|py| py.check_signals())
                {
                    raised = Some(error);
                    stop::ask();
                }
            }
            let result = worker.join();
            if raised.is_some() {
                stop::withdraw();
            }
            match (raised, result) {
                (Some(error), _) => Err(error),
                (None, Ok(Ok(value))) => Ok(value),
                (None, Ok(Err(stop::Stopped))) => Err(interrupted()),
                (None, Err(panic)) => std::panic::resume_unwind(panic),
            }
        })
    })
}
