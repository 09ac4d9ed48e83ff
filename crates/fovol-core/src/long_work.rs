//! Work of a part that takes long, told step by step to whoever listens.

use crate::stop;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// How far some work has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkProgress {
    /// What is being made.
    pub what: &'static str,
    /// Steps that are done, at most `total`. Threads may tell of steps in another order.
    pub done: u64,
    /// Steps in all.
    pub total: u64,
}

static LISTENER: OnceLock<fn(WorkProgress)> = OnceLock::new();

/// Has `listener` hear of all long work of this process from now on, on the threads that do it. For programs: only the first
/// listener is told.
pub fn listen_to_long_work(listener: fn(WorkProgress)) {
    let _ = LISTENER.set(listener);
}

/// Work of a known number of steps, which [`listen_to_long_work`] tells of and [`stop`] ends.
#[derive(Debug)]
pub struct LongWork {
    what: &'static str,
    done: AtomicU64,
    total: u64,
}

impl LongWork {
    /// `total` steps that make `what`.
    pub fn new(what: &'static str, total: u64) -> Self {
        let work = Self { what, done: AtomicU64::new(0), total };
        work.tell(0);
        work
    }

    /// One more step is done, on whichever thread. Leaves the work if a stop was asked for.
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
