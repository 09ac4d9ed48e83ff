//! The temporary files of this process and the programs that write into them, for programs that end at once, where no destructor
//! removes them.
//!
//! They lie in memory that is there from the beginning: whoever finds no memory for anything else can still remove them.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

/// So many files are known at once, and names up to this length.
const FILES: usize = 32;
const LONGEST: usize = 1024;

const FREE: u8 = 0;
const CHANGING: u8 = 1;
const KNOWN: u8 = 2;

/// The name of a file, with a zero after it.
struct Name {
    state: AtomicU8,
    bytes: [AtomicU8; LONGEST],
}

static NAMES: [Name; FILES] =
    [const { Name { state: AtomicU8::new(FREE), bytes: [const { AtomicU8::new(0) }; LONGEST] } }; FILES];
/// Held while names are changed.
static CHANGES: Mutex<()> = Mutex::new(());
/// Whether [`remove_all`] has begun: names stay as they are from then on.
static ENDS: AtomicBool = AtomicBool::new(false);

/// Enters the temporary file at `path`, in the place of one that is gone: renamed or removed.
pub(crate) fn add(path: &Path) {
    let path = path.as_os_str().as_encoded_bytes();
    // Whoever panicked while names were changed left one that counts as changing, no more.
    let _changes = CHANGES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let is_free = |name: &&Name| !name.path().is_some_and(|bytes| exists(&bytes));
    if path.len() < LONGEST
        && let Some(name) = NAMES.iter().find(is_free)
    {
        name.set(path);
    }
}

/// The numbers of processes that may write into temporary files; 0 where there is none.
static WRITERS: [AtomicU32; FILES] = [const { AtomicU32::new(0) }; FILES];

/// Enters the process of number `id`, which writes into temporary files.
pub(crate) fn add_writer(id: u32) {
    let is_taken =
        |place: &&AtomicU32| place.compare_exchange(0, id, Ordering::SeqCst, Ordering::SeqCst).is_ok();
    // Where there is no place it is on its own.
    let _ = WRITERS.iter().find(is_taken);
}

/// Takes out the process of number `id`, before anybody waits for its end: later the number may be that of another one.
pub(crate) fn forget_writer(id: u32) {
    for place in &WRITERS {
        let _ = place.compare_exchange(id, 0, Ordering::SeqCst, Ordering::SeqCst);
    }
}

/// Ends every process that writes into temporary files, and removes those that are still there. Asks for no memory and takes no
/// lock, so that an allocator may call it; the program must end then.
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
        // Whoever removes files has either seen that this name changes, or is seen here.
        if !ENDS.load(Ordering::SeqCst) {
            let with_end = path.iter().chain(&[0]);
            self.bytes.iter().zip(with_end).for_each(|(to, &byte)| to.store(byte, Ordering::Relaxed));
            self.state.store(KNOWN, Ordering::SeqCst);
        }
    }

    /// The name with the zero after it, if there is one.
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
    // SAFETY: the name ends with a zero, and is there while the system reads it.
    unsafe { libc::access(path.as_ptr().cast(), libc::F_OK) == 0 }
}

#[cfg(unix)]
fn remove(path: &[u8; LONGEST]) {
    // Where it is gone there is nothing to remove.
    // SAFETY: as in `exists`.
    let _ = unsafe { libc::unlink(path.as_ptr().cast()) };
}

/// Ends the process of number `id`, which is a child of this one, and waits until it can write no more.
#[cfg(unix)]
fn end(id: u32) {
    let Ok(id) = libc::pid_t::try_from(id) else { return };
    // SAFETY: both take numbers; the pointer to where the status goes may be null. Nobody has waited for this child yet, so the
    // number is still its own.
    unsafe {
        libc::kill(id, libc::SIGKILL);
        libc::waitpid(id, std::ptr::null_mut(), 0);
    }
}

/// Elsewhere nobody ends without destructors.
#[cfg(not(unix))]
fn end(_: u32) {}

/// As above.
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
