//! A gate before the queue of a device: submissions pass it one at a time, unless it is held shut.

use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A gate that is open while nobody holds it shut.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    holders: Mutex<usize>,
    opened: Condvar,
}

impl Gate {
    /// Runs `work` once the gate is open. Holders that come meanwhile wait until `work` has ended.
    pub(crate) fn pass<T>(&self, work: impl FnOnce() -> T) -> T {
        let holders = self.holders();
        let _open =
            self.opened.wait_while(holders, |holders| *holders > 0).unwrap_or_else(PoisonError::into_inner);
        work()
    }

    fn holders(&self) -> MutexGuard<'_, usize> {
        self.holders.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Holds the gate of a device shut while it lives: submissions of all threads wait.
#[must_use = "it ends when it is dropped"]
pub struct Pause(Arc<Gate>);

impl Pause {
    pub(crate) fn of(gate: &Arc<Gate>) -> Self {
        *gate.holders() += 1;
        Self(Arc::clone(gate))
    }
}

impl Drop for Pause {
    fn drop(&mut self) {
        *self.0.holders() -= 1;
        self.0.opened.notify_all();
    }
}

impl fmt::Debug for Pause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pause").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::{RecvTimeoutError, channel};
    use std::thread;
    use std::time::Duration;

    #[test]
    fn whoever_comes_to_a_gate_that_is_held_waits_for_the_last_holder() {
        let gate = Arc::new(Gate::default());
        let (first, second) = (Pause::of(&gate), Pause::of(&gate));
        let (say, said) = channel();
        let passing = {
            let gate = Arc::clone(&gate);
            thread::spawn(move || gate.pass(|| say.send(()).unwrap()))
        };
        drop(first);
        assert_eq!(said.recv_timeout(Duration::from_millis(50)), Err(RecvTimeoutError::Timeout));
        drop(second);
        said.recv_timeout(Duration::from_secs(60)).unwrap();
        passing.join().unwrap();
    }

    #[test]
    fn nobody_passes_while_it_is_held() {
        let gate = Arc::new(Gate::default());
        let passed = Arc::new(AtomicUsize::new(0));
        let passing: Vec<_> = (0..3)
            .map(|_| {
                let (gate, passed) = (Arc::clone(&gate), Arc::clone(&passed));
                thread::spawn(move || {
                    for _ in 0..2000 {
                        gate.pass(|| passed.fetch_add(1, Ordering::SeqCst));
                    }
                })
            })
            .collect();
        for _ in 0..200 {
            let _pause = Pause::of(&gate);
            let before = passed.load(Ordering::SeqCst);
            thread::yield_now();
            assert_eq!(passed.load(Ordering::SeqCst), before);
        }
        for thread in passing {
            thread.join().unwrap();
        }
        assert_eq!(passed.load(Ordering::SeqCst), 6000);
    }
}
