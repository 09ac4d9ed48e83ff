//! Work without the interpreter's lock that Ctrl-C ends.

use crate::errors::interrupted;
use fovolnet::core::stop;
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often the interpreter is asked for signals.
const PERIOD: Duration = Duration::from_millis(50);

/// Runs `work` on a thread of its own, without the interpreter's lock.
///
/// # Errors
/// `KeyboardInterrupt`, or what another signal raises. What `work` was changing must not be used then.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
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
