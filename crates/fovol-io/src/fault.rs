//! Writes that fail where tests want it.

use std::cell::Cell;
use std::io;

thread_local! {
    /// How many bytes files of this thread take until the disk is full.
    static ROOM: Cell<usize> = const { Cell::new(usize::MAX) };
}

/// What `act` does where the disk has room for `bytes` bytes, in all files together.
pub(crate) fn after<T>(bytes: usize, act: impl FnOnce() -> T) -> T {
    ROOM.set(bytes);
    let result = act();
    ROOM.set(usize::MAX);
    result
}

/// How many of `bytes` bytes find room.
pub(crate) fn room(bytes: usize) -> io::Result<usize> {
    let left = ROOM.get();
    if left == usize::MAX || bytes == 0 {
        return Ok(bytes);
    }
    if left == 0 {
        return Err(io::ErrorKind::StorageFull.into());
    }
    let taken = bytes.min(left);
    ROOM.set(left - taken);
    Ok(taken)
}
