//! Progress of work that takes long, reported step by step to one listener.

use crate::stop;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Progress of one piece of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkProgress {
    /// Name of the result, for a progress line.
    pub what: &'static str,
    /// Finished steps, at most `total`. Threads may report steps out of order.
    pub done: u64,
    /// Number of all steps.
    pub total: u64,
}

static LISTENER: OnceLock<fn(WorkProgress)> = OnceLock::new();

/// Calls `listener` for all long work of this process from now on, on the threads that do the work. Meant for programs:
/// only the first listener counts.
pub fn listen_to_long_work(listener: fn(WorkProgress)) {
    let _ = LISTENER.set(listener);
}

/// Work of a known number of steps. It reports to [`listen_to_long_work`], and [`stop`] can end it.
#[derive(Debug)]
pub struct LongWork {
    what: &'static str,
    done: AtomicU64,
    total: u64,
}

impl LongWork {
    /// Work of `total` steps that makes `what`.
    pub fn new(what: &'static str, total: u64) -> Self {
        let work = Self { what, done: AtomicU64::new(0), total };
        work.tell(0);
        work
    }

    /// Counts one more finished step, from any thread. Unwinds if a stop was asked for.
    pub fn step(&self) {
        stop::point();
        self.tell(self.done.fetch_add(1, Ordering::Relaxed) + 1);
    }

    fn tell(&self, done: u64) {
        if let Some(listener) = LISTENER.get() {
            listener(WorkProgress { what: self.what, done, total: self.total });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn the_listener_hears_of_every_step() {
        static HEARD: Mutex<Vec<WorkProgress>> = Mutex::new(Vec::new());
        listen_to_long_work(|progress| HEARD.lock().unwrap().push(progress));
        let work = LongWork::new("bread", 2);
        work.step();
        work.step();
        let told = |done| WorkProgress { what: "bread", done, total: 2 };
        assert_eq!(*HEARD.lock().unwrap(), [told(0), told(1), told(2)]);
    }
}
