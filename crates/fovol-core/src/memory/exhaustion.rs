//! Exit of a program that runs out of memory: one line of error and status 1 instead of an abort.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};

/// System allocator that ends the program with one line and status 1 when memory runs out, where Rust would abort.
/// Requests of this module ([`super::zeroed`] and its like) return an error instead.
///
/// The program ends inside the failed allocation, without unwinding. Clean-up goes into [`before_exit`].
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
    /// Number of calls in progress on this thread that can handle a failed allocation.
    static FALLIBLE: Cell<u32> = const { Cell::new(0) };
}

/// Runs `ask`, which allocates and handles failure itself.
pub(super) fn fallible<T>(ask: impl FnOnce() -> T) -> T {
    let add = |by: i32| {
        // Thread-locals are gone at the end of a thread. The count is not needed then.
        let _ = FALLIBLE.try_with(|count| count.set(count.get().wrapping_add_signed(by)));
    };
    add(1);
    // `ask` only allocates, so it cannot panic and leave the count wrong.
    let outcome = ask();
    add(-1);
    outcome
}

// SAFETY: every call is passed on unchanged to the system allocator, and null means failure there too.
unsafe impl GlobalAlloc for ExitWhenExhausted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of this function, which is that of the system allocator.
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

/// Runs `allocate` for `size` bytes and returns its pointer. Ends the program if the pointer is null, except inside
/// [`fallible`].
#[inline(always)]
fn checked(size: usize, allocate: impl FnOnce() -> *mut u8) -> *mut u8 {
    let memory = if is_refused(size) { std::ptr::null_mut() } else { allocate() };
    if memory.is_null() && FALLIBLE.try_with(Cell::get) == Ok(0) {
        exhausted(size);
    }
    memory
}

/// Smallest size in bytes of the allocations that [`refuse_allocation`] counts; above all sizes when none is to be
/// refused.
static COUNTED: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Number of counted allocations that still succeed.
static GRANTED: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Makes the `nth` allocation (from 1) of `bytes` or more fail, once. Tests use it to see how a program runs out of
/// memory.
pub fn refuse_allocation(nth: usize, bytes: usize) {
    GRANTED.store(nth.wrapping_sub(1), Ordering::SeqCst);
    COUNTED.store(bytes, Ordering::SeqCst);
}

/// Whether this allocation of `size` bytes is the one to refuse.
#[inline(always)]
fn is_refused(size: usize) -> bool {
    size >= COUNTED.load(Ordering::Relaxed) && GRANTED.fetch_sub(1, Ordering::Relaxed) == 0
}

/// Clean-up before the program ends, a function of type `fn()`; null if none.
static BEFORE_EXIT: AtomicPtr<()> = AtomicPtr::new(std::ptr::null_mut());

/// Sets the function that [`ExitWhenExhausted`] and [`exit_with`] call before they end the program. It must not
/// allocate or wait for other threads, like a signal handler.
pub fn before_exit(clean_up: fn()) {
    BEFORE_EXIT.store(clean_up as *mut (), Ordering::Release);
}

/// Reports that `size` bytes could not be allocated, and ends the program.
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

/// Writes `number` in decimal to `digits` without allocating.
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

/// Writes the parts of `line` to standard error and ends the program with status 1. It never allocates. If several
/// threads call it, only the first one writes.
#[cfg(unix)]
pub fn exit_with(line: &[&[u8]]) -> ! {
    static ENDS: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
    if ENDS.swap(true, Ordering::SeqCst) {
        loop {
            // SAFETY: `pause` takes nothing and only waits for a signal; no signal makes this function return.
            unsafe { libc::pause() };
        }
    }
    let clean_up = BEFORE_EXIT.load(Ordering::Acquire);
    if !clean_up.is_null() {
        // SAFETY: `before_exit` stored a `fn()` in this pointer.
        let clean_up: fn() = unsafe { std::mem::transmute(clean_up) };
        clean_up();
    }
    // SAFETY: `isatty` takes a number. A progress line may stand on the terminal and is erased first.
    if unsafe { libc::isatty(2) } == 1 {
        write(b"\r\x1b[2K");
    }
    line.iter().for_each(|part| write(part));
    write(b"\n");
    // SAFETY: `_exit` ends the process at once, without destructors. Nothing else may run here.
    unsafe { libc::_exit(1) }
}

/// Writes the parts of `line` to standard error and ends the program with status 1.
#[cfg(not(unix))]
pub fn exit_with(line: &[&[u8]]) -> ! {
    eprintln!("{}", String::from_utf8_lossy(&line.concat()));
    std::process::abort()
}

/// Writes `text` to standard error; errors are ignored.
#[cfg(unix)]
fn write(text: &[u8]) {
    // SAFETY: the pointer and length are those of `text`, which outlives the call.
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
