//! What a program does that finds no memory: it says so in one line and ends.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};

/// The system's allocator for programs that are to end with one line and status 1 where there is no memory, instead of being
/// aborted. Where this module asks for memory itself it returns an error.
///
/// The program ends from wherever the memory was asked for: nothing is unwound. What is to be done nevertheless is said by
/// [`before_exit`].
///
/// ```
/// use fovol_core::memory::ExitWhenExhausted;
///
/// #[global_allocator]
/// static MEMORY: ExitWhenExhausted = ExitWhenExhausted;
/// # fn main() {}
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct ExitWhenExhausted;

thread_local! {
    /// How many of the calls under way on this thread can do without the memory that they ask for.
    static FALLIBLE: Cell<u32> = const { Cell::new(0) };
}

/// Runs `ask`, which asks for memory and can do without it.
pub(super) fn fallible<T>(ask: impl FnOnce() -> T) -> T {
    let add = |by: i32| {
        // At the end of a thread nothing of this can be asked for any more.
        let _ = FALLIBLE.try_with(|count| count.set(count.get().wrapping_add_signed(by)));
    };
    add(1);
    // It cannot panic: it asks for memory, and no more.
    let outcome = ask();
    add(-1);
    outcome
}

// SAFETY: every call is passed on to the system's allocator as it is; null stands for failure there too.
unsafe impl GlobalAlloc for ExitWhenExhausted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise is that of this call.
        checked(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        checked(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        checked(size, || unsafe { System.realloc(memory, layout, size) })
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// What `allocate` gives of `size` bytes. Where that is nothing and nobody can do without it the program ends here.
#[inline(always)]
fn checked(size: usize, allocate: impl FnOnce() -> *mut u8) -> *mut u8 {
    let memory = if is_refused(size) { std::ptr::null_mut() } else { allocate() };
    if memory.is_null() && FALLIBLE.try_with(Cell::get) == Ok(0) {
        exhausted(size);
    }
    memory
}

/// Allocations of at least so many bytes are counted; all fall below it where none is to be refused.
static COUNTED: AtomicUsize = AtomicUsize::new(usize::MAX);
/// How many more of them are granted.
static GRANTED: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Has the allocation of number `nth`, from 1 on, among those of `bytes` or more be refused, once: for tests of what happens then.
pub fn refuse_allocation(nth: usize, bytes: usize) {
    GRANTED.store(nth.wrapping_sub(1), Ordering::SeqCst);
    COUNTED.store(bytes, Ordering::SeqCst);
}

/// Whether an allocation of `size` bytes is the one that is to be refused.
#[inline(always)]
fn is_refused(size: usize) -> bool {
    size >= COUNTED.load(Ordering::Relaxed) && GRANTED.fetch_sub(1, Ordering::Relaxed) == 0
}

/// What is done before the program ends; a function of type `fn()`.
static BEFORE_EXIT: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());

/// Has [`ExitWhenExhausted`] and [`exit_with`] call `clean_up` before they end the program. It must not allocate, nor wait for
/// other threads: it may do what a signal handler may.
pub fn before_exit(clean_up: fn()) {
    BEFORE_EXIT.store(clean_up as *mut (), Ordering::Release);
}

/// Says that `size` bytes could not be had, and ends the program.
#[cold]
#[inline(never)]
fn exhausted(size: usize) {
    if cfg!(unix) {
        let mut digits = [0; 20];
        exit_with(&[
            b"error: out of memory: ",
            decimal(size, &mut digits),
            b" bytes could not be had; --downsample, a smaller --size, fewer frames or fewer --threads need less, and \
              `ulimit -v` may set a limit",
        ]);
    }
}

/// `number` in digits.
fn decimal(mut number: usize, digits: &mut [u8; 20]) -> &[u8] {
    let mut first = digits.len();
    loop {
        first -= 1;
        digits[first] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            return &digits[first..];
        }
    }
}

/// Writes `line` to standard error, in parts, and ends the program with status 1, without allocating. Where several threads
/// want to do so only the first one does.
#[cfg(unix)]
pub fn exit_with(line: &[&[u8]]) -> ! {
    static ENDS: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
    if ENDS.swap(true, Ordering::SeqCst) {
        loop {
            // SAFETY: it waits for a signal, of which none returns from here.
            unsafe { libc::pause() };
        }
    }
    let clean_up = BEFORE_EXIT.load(Ordering::Acquire);
    if !clean_up.is_null() {
        // SAFETY: it was made of a `fn()` by `before_exit`.
        let clean_up: fn() = unsafe { std::mem::transmute(clean_up) };
        clean_up();
    }
    // SAFETY: it takes a number. A line of progress may stand on the terminal.
    if unsafe { libc::isatty(2) } == 1 {
        write(b"\r\x1b[2K");
    }
    line.iter().for_each(|part| write(part));
    write(b"\n");
    // SAFETY: it ends the process at once, which is meant: nothing more may run here.
    unsafe { libc::_exit(1) }
}

/// Writes `line` to standard error, in parts, and ends the program.
#[cfg(not(unix))]
pub fn exit_with(line: &[&[u8]]) -> ! {
    eprintln!("{}", String::from_utf8_lossy(&line.concat()));
    std::process::abort()
}

/// Writes `text` to standard error, as far as that goes.
#[cfg(unix)]
fn write(text: &[u8]) {
    // SAFETY: the text is there while the system reads it.
    let _ = unsafe { libc::write(2, text.as_ptr().cast(), text.len()) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_all_their_digits() {
        for number in [0, 7, 10, 16_777_216, usize::MAX] {
            assert_eq!(decimal(number, &mut [0; 20]), number.to_string().as_bytes());
        }
    }

    #[test]
    fn the_allocation_of_the_number_is_refused_once() {
        refuse_allocation(3, 1 << 40);
        let refused: Vec<bool> = [1 << 40, 5, 1 << 41, 1 << 40, 1 << 40].map(is_refused).into();
        refuse_allocation(0, usize::MAX);
        assert_eq!(refused, [false, false, false, true, false]);
    }

    #[test]
    fn who_can_do_without_memory_is_told() {
        let refused = checked(1 << 50, || std::ptr::NonNull::dangling().as_ptr());
        assert!(!refused.is_null());
        assert!(fallible(|| checked(1 << 50, std::ptr::null_mut)).is_null());
        assert_eq!(FALLIBLE.with(Cell::get), 0);
    }
}
