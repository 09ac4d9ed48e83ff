//! Temporary files and child processes, which must not outlive this process.
//!
//! A thread that makes a temporary file holds the [`Gate`] until the file is registered here. A thread that renames one
//! to its final name holds the gate meanwhile. [`abandon`] takes the gate for good, kills the children and removes the
//! files. So every finished file either has its final name and is whole, or is gone.

use crate::temporaries;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

static GATE: Mutex<()> = Mutex::new(());

/// Exclusive right to make and rename temporary files; one thread holds it at a time.
#[derive(Debug)]
#[must_use]
pub struct Gate(#[expect(dead_code, reason = "it is held, not read")] MutexGuard<'static, ()>);

impl Gate {
    /// Waits for the gate; for ever once the process is ending.
    pub fn enter() -> Self {
        Self(GATE.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Registers the temporary file at `path`.
    pub fn add_file(&self, path: &Path) {
        temporaries::add(path);
        all().files.insert(path.to_owned());
    }

    pub(crate) fn add_child(&self, child: &Arc<Mutex<Child>>) {
        temporaries::add_writer(child.lock().unwrap_or_else(PoisonError::into_inner).id());
        all().children.push(Arc::clone(child));
    }
}

/// Removes the file at `path` from the registry, after it was renamed or deleted.
pub fn forget_file(path: &Path) {
    all().files.remove(path);
}

pub(crate) fn forget_child(child: &Arc<Mutex<Child>>) {
    all().children.retain(|other| !Arc::ptr_eq(other, child));
}

/// Temporary files and child processes of this process.
#[derive(Default)]
struct Unfinished {
    files: HashSet<PathBuf>,
    children: Vec<Arc<Mutex<Child>>>,
}

fn all() -> MutexGuard<'static, Unfinished> {
    static ALL: LazyLock<Mutex<Unfinished>> = LazyLock::new(Mutex::default);
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Longest wait for the end of a killed child.
const END_OF_CHILD: Duration = Duration::from_millis(100);

/// Kills every child process and removes every temporary file. While the returned gate lives, no thread makes or
/// renames another file, so keep it until the process has ended.
///
/// It waits up to `patience` for a thread that is renaming a file. If that takes longer, it removes nothing and returns
/// `None`.
pub fn abandon(patience: Duration) -> Option<Gate> {
    let gate = gate_within(patience)?;
    let all = all();
    // Kill the writers first, or they might make a file anew.
    all.children.iter().for_each(|child| end(child));
    for file in &all.files {
        // Errors are ignored: nothing else could remove the file at this point.
        let _ = fs::remove_file(file);
    }
    Some(gate)
}

fn gate_within(patience: Duration) -> Option<Gate> {
    let started = Instant::now();
    loop {
        match GATE.try_lock() {
            Ok(gate) => return Some(Gate(gate)),
            Err(TryLockError::Poisoned(gate)) => return Some(Gate(gate.into_inner())),
            Err(TryLockError::WouldBlock) if started.elapsed() >= patience => return None,
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

fn end(child: &Mutex<Child>) {
    let mut child = child.lock().unwrap_or_else(PoisonError::into_inner);
    // A child that has ended already cannot be killed, which is no error here.
    let _ = child.kill();
    let killed = Instant::now();
    while matches!(child.try_wait(), Ok(None)) && killed.elapsed() < END_OF_CHILD {
        std::thread::sleep(Duration::from_millis(1));
    }
}
