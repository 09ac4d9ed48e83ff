//! Keeps the worker threads of a pool spinning between the many short parallel parts of a frame.

use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Most threads kept spinning. More help little in parts this short, and they would compete for work.
const MOST: usize = 7;
/// Spin-loop hints between two attempts to find work.
const SPINS: usize = 16;

/// Runs `work` while the other threads of the current rayon pool keep spinning.
///
/// An idle worker sleeps after some 20 µs, and waking it takes about 50 µs on a virtual machine: as long as many a
/// part of a frame. A spinning worker takes part at once. Outside a pool this only runs `work`.
pub fn keep_workers_spinning<R>(work: impl FnOnce() -> R) -> R {
    let Some(here) = rayon::current_thread_index() else { return work() };
    let is_done = AtomicBool::new(false);
    rayon::in_place_scope(|scope| {
        // These jobs are older than all parallel parts of `work`, so other threads take them first. None of them ever
        // waits for a part of `work` that its own thread has begun.
        for _ in 1..rayon::current_num_threads().min(MOST + 1) {
            scope.spawn(|_| {
                while !is_done.load(Ordering::Acquire) && rayon::current_thread_index() != Some(here) {
                    if rayon::yield_now() != Some(Yield::Executed) {
                        (0..SPINS).for_each(|_| std::hint::spin_loop());
                    }
                }
            });
        }
        let _end = End(&is_done);
        work()
    })
}

/// Ends the spinning when dropped, also after a panic.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// Nested parallel sums, with pauses between them.
    fn sums(rounds: u64) -> u64 {
        let sum = |i: u64| (0..500u64).into_par_iter().map(|j| i ^ j).sum::<u64>();
        (0..rounds).map(|round| (0..50).into_par_iter().map(|i| sum(i + round)).sum::<u64>()).sum()
    }

    #[test]
    fn work_is_done_in_pools_of_any_size_and_outside() {
        let expected = sums(20);
        assert_eq!(keep_workers_spinning(|| sums(20)), expected);
        for threads in [1, 2, 3, 12] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(
                pool.install(|| keep_workers_spinning(
                    || sums(10) + keep_workers_spinning(|| sums(20)) - sums(10)
                )),
                expected
            );
        }
    }

    #[test]
    fn many_at_once_do_not_wait_for_one_another_for_ever() {
        let expected = sums(10);
        for threads in [2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            std::thread::scope(|scope| {
                for _ in 0..6 {
                    scope.spawn(|| {
                        for _ in 0..20 {
                            assert_eq!(
                                pool.install(|| keep_workers_spinning(|| keep_workers_spinning(|| sums(10)))),
                                expected
                            );
                        }
                    });
                }
            });
        }
    }

    #[test]
    fn failures_come_through() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let failing = || pool.install(|| keep_workers_spinning(|| panic!("as it should")));
        assert!(catch_unwind(AssertUnwindSafe(failing)).is_err());
    }
}
