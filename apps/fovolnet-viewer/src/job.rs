//! Background jobs with progress and cancellation.

use anyhow::{Result, bail};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Running background job.
#[derive(Debug)]
pub struct Job<T> {
    name: String,
    state: Arc<State>,
    result: Receiver<Result<T>>,
}

#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    /// Progress in millionths.
    done: AtomicU32,
}

/// Handle with which the work reports to its job.
#[derive(Debug, Clone)]
pub struct Handle(Arc<State>);

impl Handle {
    /// Reports that the fraction `share` of the work is done, 0 to 1.
    ///
    /// # Errors
    /// The job was cancelled.
    pub fn progress(&self, share: f64) -> Result<()> {
        self.0.done.store((share.clamp(0.0, 1.0) * 1e6) as u32, Ordering::Relaxed);
        if self.0.is_cancelled.load(Ordering::Relaxed) {
            bail!("cancelled");
        }
        Ok(())
    }
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work` on a new thread; calls `wake` when it ends.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start(
        name: impl Into<String>,
        wake: impl FnOnce() + Send + 'static,
        work: impl FnOnce(&Handle) -> Result<T> + Send + 'static,
    ) -> std::io::Result<Self> {
        let state = Arc::<State>::default();
        let handle = Handle(Arc::clone(&state));
        let (send, result) = channel();
        std::thread::Builder::new().name("job".into()).spawn(move || {
            let worked = catch_unwind(AssertUnwindSafe(|| work(&handle)));
            let worked = worked.unwrap_or_else(|_| Err(anyhow::anyhow!("it failed; please report how")));
            // The receiver may be gone.
            let _ = send.send(worked);
            wake();
        })?;
        Ok(Self { name: name.into(), state, result })
    }
}

impl<T> Job<T> {
    /// Name of the job.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Fraction of the work that is done, 0 to 1.
    pub fn done(&self) -> f32 {
        self.state.done.load(Ordering::Relaxed) as f32 * 1e-6
    }

    /// Requests cancellation.
    pub fn cancel(&self) {
        self.state.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether cancellation was requested.
    pub fn is_cancelled(&self) -> bool {
        self.state.is_cancelled.load(Ordering::Relaxed)
    }

    /// Takes the result, which can be taken once; `None` while the job is running.
    pub fn take(&self) -> Option<Result<T>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(anyhow::anyhow!("it ended without a word"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn wait<T>(job: &Job<T>) -> Result<T> {
        loop {
            if let Some(result) = job.take() {
                return result;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn work_is_done_apart() {
        let job = Job::start(
            "adding",
            || (),
            |handle| {
                handle.progress(0.5)?;
                Ok(1 + 1)
            },
        );
        let job = job.unwrap();
        assert_eq!(wait(&job).unwrap(), 2);
        assert!((job.done() - 0.5).abs() < 1e-6);
    }

    #[test]
    fn it_ends_when_asked_and_its_panics_are_errors() {
        let endless = |handle: &Handle| -> Result<()> {
            loop {
                handle.progress(0.1)?;
            }
        };
        let job = Job::start("waiting", || (), endless).unwrap();
        job.cancel();
        assert!(wait(&job).unwrap_err().to_string().contains("cancelled"));
        let job = Job::start("failing", || (), |_| -> Result<()> { panic!("no") }).unwrap();
        assert!(wait(&job).is_err());
    }
}
