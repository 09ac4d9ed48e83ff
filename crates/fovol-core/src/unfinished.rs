//! What must not outlive this process unfinished: temporary files, and the programs that help it.
//!
//! Whoever makes one holds the [`Gate`] until it is entered here, and whoever gives a file its name holds it meanwhile. [`abandon`]
//! takes the gate for good, ends those programs and removes those files. So a file that is complete is either renamed before, and
//! whole under its name, or gone: never in between.

use crate::temporaries;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

static GATE: Mutex<()> = Mutex::new(());

/// The right to make temporary files and to rename them, which one thread has at a time.
#[derive(Debug)]
#[must_use]
pub struct Gate(#[expect(dead_code, reason = "it is held, not read")] MutexGuard<'static, ()>);

impl Gate {
    /// Waits for it; for ever once the process is ending.
    pub fn enter() -> Self {
        Self(GATE.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Enters the temporary file at `path`.
    pub fn add_file(&self, path: &Path) {
        temporaries::add(path);
        all().files.insert(path.to_owned());
    }

    pub(crate) fn add_helper(&self, child: &Arc<Mutex<Child>>) {
        temporaries::add_writer(child.lock().unwrap_or_else(PoisonError::into_inner).id());
        all().helpers.push(Arc::clone(child));
    }
}

/// Takes out the file at `path`: it has another name now, or is gone.
pub fn forget_file(path: &Path) {
    all().files.remove(path);
}

pub(crate) fn forget_helper(child: &Arc<Mutex<Child>>) {
    all().helpers.retain(|other| !Arc::ptr_eq(other, child));
}

/// Temporary files and programs that this process has now.
#[derive(Default)]
struct Unfinished {
    files: HashSet<PathBuf>,
    helpers: Vec<Arc<Mutex<Child>>>,
}

fn all() -> MutexGuard<'static, Unfinished> {
    static ALL: LazyLock<Mutex<Unfinished>> = LazyLock::new(Mutex::default);
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How long a program that was killed may take to be gone.
const END_OF_HELPER: Duration = Duration::from_millis(100);

/// Ends every program that helps this one and removes every temporary file. As long as the gate that comes back lives no thread
/// makes or renames another: keep it until the process has ended.
///
/// Waits for a thread that is renaming a file, up to `patience`; on a disk that takes longer nothing is removed, and `None` comes
/// back.
pub fn abandon(patience: Duration) -> Option<Gate> {
    let gate = gate_within(patience)?;
    let all = all();
    // First those who write, or they might make a file anew.
    all.helpers.iter().for_each(|child| end(child));
    for file in &all.files {
        // Where it cannot be removed nobody is left who could.
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
    // One that has ended already needs no end.
    let _ = child.kill();
    let killed = Instant::now();
    while matches!(child.try_wait(), Ok(None)) && killed.elapsed() < END_OF_HELPER {
        std::thread::sleep(Duration::from_millis(1));
    }
}
