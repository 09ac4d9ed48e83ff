//! Registry of this process's temporary files, and of the child processes that write to them. It serves programs that
//! end at once, where no destructor removes the files.
//!
//! The registry is static memory, so the files can be removed even when no memory is left.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

/// Largest number of registered files, and of registered children.
const FILES: usize = 32;
/// Largest size of a path in bytes, with its final zero.
const LONGEST: usize = 1024;

const FREE: u8 = 0;
const CHANGING: u8 = 1;
const KNOWN: u8 = 2;

/// Path of a file, with a final zero byte.
struct Name {
    state: AtomicU8,
    bytes: [AtomicU8; LONGEST],
}

static NAMES: [Name; FILES] =
    [const { Name { state: AtomicU8::new(FREE), bytes: [const { AtomicU8::new(0) }; LONGEST] } }; FILES];
/// Locked while paths are changed.
static CHANGES: Mutex<()> = Mutex::new(());
/// Whether [`remove_all`] has begun. Paths no longer change from then on.
static ENDS: AtomicBool = AtomicBool::new(false);

/// Registers the temporary file at `path`, in the place of one that was renamed or removed.
pub(crate) fn add(path: &Path) {
    let path = path.as_os_str().as_encoded_bytes();
    // A thread that panicked meanwhile left at most one entry marked as changing.
    let _changes = CHANGES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let is_free = |name: &&Name| !name.path().is_some_and(|bytes| exists(&bytes));
    if path.len() < LONGEST
        && let Some(name) = NAMES.iter().find(is_free)
    {
        name.set(path);
    }
}

/// Process numbers of children that may write to temporary files; 0 for a free place.
static WRITERS: [AtomicU32; FILES] = [const { AtomicU32::new(0) }; FILES];

/// Registers the child process `id`, which writes to temporary files.
pub(crate) fn add_writer(id: u32) {
    let is_taken =
        |place: &&AtomicU32| place.compare_exchange(0, id, Ordering::SeqCst, Ordering::SeqCst).is_ok();
    // Without a free place the child is not registered, and [`remove_all`] will not kill it.
    let _ = WRITERS.iter().find(is_taken);
}

/// Removes the child process `id` from the registry. Call it before waiting for the child, since the number may be
/// reused afterwards.
pub(crate) fn forget_writer(id: u32) {
    for place in &WRITERS {
        let _ = place.compare_exchange(id, 0, Ordering::SeqCst, Ordering::SeqCst);
    }
}

/// Kills every registered child and removes every registered file that still exists. It allocates nothing and takes no
/// lock, so an allocator may call it. The program must end afterwards.
pub fn remove_all() {
    ENDS.store(true, Ordering::SeqCst);
    WRITERS.iter().map(|place| place.swap(0, Ordering::SeqCst)).filter(|&id| id != 0).for_each(end);
    for bytes in NAMES.iter().filter_map(Name::path) {
        remove(&bytes);
    }
}

impl Name {
    fn set(&self, path: &[u8]) {
        self.state.store(CHANGING, Ordering::SeqCst);
        // `remove_all` sets `ENDS` before it reads the states. So it sees that this path changes, or this thread sees
        // `ENDS`.
        if !ENDS.load(Ordering::SeqCst) {
            let with_end = path.iter().chain(&[0]);
            self.bytes.iter().zip(with_end).for_each(|(to, &byte)| to.store(byte, Ordering::Relaxed));
            self.state.store(KNOWN, Ordering::SeqCst);
        }
    }

    /// The path with its final zero, if there is one.
    fn path(&self) -> Option<[u8; LONGEST]> {
        if self.state.load(Ordering::SeqCst) != KNOWN {
            return None;
        }
        let mut bytes = [0; LONGEST];
        self.bytes.iter().zip(&mut bytes).for_each(|(byte, to)| *to = byte.load(Ordering::Relaxed));
        Some(bytes)
    }
}

#[cfg(unix)]
fn exists(path: &[u8; LONGEST]) -> bool {
    // SAFETY: the path ends with a zero byte and outlives the call.
    unsafe { libc::access(path.as_ptr().cast(), libc::F_OK) == 0 }
}

#[cfg(unix)]
fn remove(path: &[u8; LONGEST]) {
    // A file that is gone already needs no removal.
    // SAFETY: as in `exists`.
    let _ = unsafe { libc::unlink(path.as_ptr().cast()) };
}

/// Kills the child process `id` and waits until it can write no more.
#[cfg(unix)]
fn end(id: u32) {
    let Ok(id) = libc::pid_t::try_from(id) else { return };
    // SAFETY: both calls take numbers, and the pointer to the status may be null. The child has not been waited for, so
    // its number is not reused yet.
    unsafe {
        libc::kill(id, libc::SIGKILL);
        libc::waitpid(id, std::ptr::null_mut(), 0);
    }
}

/// Does nothing: on systems other than Unix programs end with destructors.
#[cfg(not(unix))]
fn end(_: u32) {}

/// Always false: on systems other than Unix no file needs this registry.
#[cfg(not(unix))]
fn exists(_: &[u8; LONGEST]) -> bool {
    false
}

#[cfg(not(unix))]
fn remove(_: &[u8; LONGEST]) {}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn places_of_files_that_are_gone_are_used_again() {
        let folder = tempfile::tempdir().unwrap();
        let known = |name: &str| {
            let path = folder.path().join(name);
            let found = |bytes: [u8; LONGEST]| bytes.starts_with(path.as_os_str().as_encoded_bytes());
            NAMES.iter().filter_map(Name::path).any(found)
        };
        let clip = folder.path().join("clip");
        std::fs::write(&clip, "").unwrap();
        add(&clip);
        for i in 0..2 * FILES {
            let frame = folder.path().join(format!("frame{i}"));
            std::fs::write(&frame, "").unwrap();
            add(&frame);
            assert!(known("clip") && known(&format!("frame{i}")), "{i}");
            std::fs::remove_file(&frame).unwrap();
        }
    }
}
