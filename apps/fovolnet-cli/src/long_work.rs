//! Progress display of long work inside a call, see [`fovolnet::core::LongWork`].

use crate::console::Progress;
use fovolnet::core::{WorkProgress, listen_to_long_work};
use std::sync::{Mutex, PoisonError, TryLockError};
use std::time::{Duration, Instant};

/// Work that takes less time gets no progress line.
const LONG: Duration = Duration::from_secs(1);

/// Work in progress.
struct Shown {
    what: &'static str,
    begun: Instant,
    /// Largest reported step; threads report their steps in any order.
    done: u64,
    /// Progress display, once the work takes long.
    progress: Option<Progress>,
}

/// Shows the progress of all long work from now on.
pub fn show() {
    listen_to_long_work(hear);
}

fn hear(heard: WorkProgress) {
    static SHOWN: Mutex<Option<Shown>> = Mutex::new(None);
    // Working threads do not wait for one that prints: a later report covers their steps. Only the last report must not
    // be lost.
    let mut shown = match SHOWN.try_lock() {
        Ok(shown) => shown,
        Err(TryLockError::WouldBlock) if heard.done < heard.total => return,
        Err(_) => SHOWN.lock().unwrap_or_else(PoisonError::into_inner),
    };
    tell(&mut shown, heard);
}

fn tell(shown: &mut Option<Shown>, WorkProgress { what, done, total }: WorkProgress) {
    if done >= total {
        // Another thread may still report an earlier step.
        *shown = None;
        return;
    }
    if done == 0 {
        *shown = Some(Shown { what, begun: Instant::now(), done: 0, progress: None });
    }
    let Some(shown) = shown.as_mut().filter(|shown| shown.what == what) else { return };
    shown.done = shown.done.max(done);
    if shown.begun.elapsed() >= LONG {
        shown.progress.get_or_insert_with(|| Progress::new(what, total)).to(shown.done);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_work_is_shown_and_its_end_takes_it_away() {
        let mut shown = None;
        let step = |done| WorkProgress { what: "shadows", done, total: 10 };
        let has_bar = |shown: &Option<Shown>| shown.as_ref().is_some_and(|shown| shown.progress.is_some());
        tell(&mut shown, step(3));
        assert!(shown.is_none(), "it was not begun");
        tell(&mut shown, step(0));
        tell(&mut shown, step(1));
        assert!(shown.is_some() && !has_bar(&shown));
        shown.as_mut().unwrap().begun -= LONG;
        tell(&mut shown, step(5));
        tell(&mut shown, step(4));
        assert!(has_bar(&shown) && shown.as_ref().unwrap().done == 5);
        tell(&mut shown, step(10));
        assert!(shown.is_none());
    }
}
