//! A stop concerns the whole process, so this file holds one test: a program that works, is asked to stop, and stops.

use fovol_core::stop::{self, Stopped};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

const ROWS: usize = 100_000;

/// Counts its drops.
struct Dropped<'a>(&'a AtomicUsize);

impl Drop for Dropped<'_> {
    fn drop(&mut self) {
        // A `point` while unwinding must not panic again.
        if std::thread::panicking() {
            stop::point();
        }
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn work_is_left_where_it_looks_and_drops_what_it_holds() {
    let [rows, dropped] = [(); 2].map(|()| AtomicUsize::new(0));
    let work = |asked_at: usize| {
        let _held = Dropped(&dropped);
        (0..ROWS).into_par_iter().for_each(|_| {
            stop::point();
            if rows.fetch_add(1, Ordering::Relaxed) == asked_at {
                stop::ask();
            }
        });
        7
    };
    assert_eq!(stop::catch(|| work(usize::MAX)), Ok(7));
    assert_eq!(rows.swap(0, Ordering::Relaxed), ROWS);
    assert!(!stop::asked());

    assert_eq!(stop::catch(|| work(10)), Err(Stopped));
    assert!(stop::asked());
    assert!(rows.load(Ordering::Relaxed) < 100, "{rows:?} rows after the stop");
    assert_eq!(dropped.load(Ordering::Relaxed), 2);

    let panic = std::panic::catch_unwind(|| stop::catch(|| panic!("of a bug, as it should")));
    assert_eq!(panic.unwrap_err().downcast_ref::<&str>(), Some(&"of a bug, as it should"));
}
