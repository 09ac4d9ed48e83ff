//! Signals of Unix: a handler may do next to nothing, so it writes a byte into a pipe that a thread reads.

use libc::c_int;
use std::io::{self, IsTerminal, PipeReader, PipeWriter, Read};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicI32, Ordering};
use std::time::{Duration, Instant};

/// Where the handler writes to.
static WRITES_TO: AtomicI32 = AtomicI32::new(-1);

/// The signals of this process.
pub struct Signals {
    reader: PipeReader,
    /// Kept open: the handler writes to it.
    _writer: PipeWriter,
}

impl Signals {
    /// Has every signal that ends a program come to this.
    ///
    /// # Errors
    /// What the system said.
    pub fn listen() -> io::Result<Self> {
        let (reader, writer) = io::pipe()?;
        WRITES_TO.store(writer.as_raw_fd(), Ordering::Relaxed);
        for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
            if signal != libc::SIGHUP || !is_ignored(signal)? {
                take(signal)?;
            }
        }
        Ok(Self { reader, _writer: writer })
    }

    /// Waits for the next signal; false where none can come any more.
    pub fn wait(&mut self) -> bool {
        self.reader.read_exact(&mut [0]).is_ok()
    }

    /// Waits for the next signal, but not longer than `patience`: whether one came.
    pub fn wait_for(&mut self, patience: Duration) -> bool {
        let started = Instant::now();
        loop {
            let left = patience.saturating_sub(started.elapsed());
            let ready = is_ready(self.reader.as_raw_fd(), libc::POLLIN, left);
            if ready || left.is_zero() {
                return ready;
            }
        }
    }
}

/// Says `text` on standard error, in place of a bar that stands there; not where that would have to be waited for.
pub fn say(text: &str) {
    let line_start = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    let text = format!("{line_start}{text}");
    if is_ready(libc::STDERR_FILENO, libc::POLLOUT, Duration::ZERO) {
        // SAFETY: these bytes are there to be read. Not through the lock of `io::stderr`: who holds it may be stopped.
        unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
    }
}

/// Ends the process without anything that is done at an orderly end: other threads still use what that would take away.
pub fn exit(status: u8) -> ! {
    // SAFETY: it may be called at any time by any thread.
    unsafe { libc::_exit(status.into()) }
}

/// Whether `file` is ready for `what` within `patience`.
fn is_ready(file: c_int, what: libc::c_short, patience: Duration) -> bool {
    let mut asked = libc::pollfd { fd: file, events: what, revents: 0 };
    let patience = c_int::try_from(patience.as_millis()).unwrap_or(c_int::MAX);
    // SAFETY: it is one such struct, which lives longer than the call.
    unsafe { libc::poll(&raw mut asked, 1, patience) == 1 }
}

fn is_ignored(signal: c_int) -> io::Result<bool> {
    // SAFETY: the struct is numbers and pointers that may be zero, and with no new handler the call only writes to it.
    let (result, found) = unsafe {
        let mut found: libc::sigaction = std::mem::zeroed();
        (libc::sigaction(signal, std::ptr::null(), &raw mut found), found)
    };
    if result == 0 { Ok(found.sa_sigaction == libc::SIG_IGN) } else { Err(io::Error::last_os_error()) }
}

fn take(signal: c_int) -> io::Result<()> {
    // SAFETY: the struct is numbers and pointers that may be zero; the handler calls only what may be called there.
    let result = unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = tell as extern "C" fn(c_int) as libc::sighandler_t;
        // Calls of the system that a signal comes into go on.
        action.sa_flags = libc::SA_RESTART;
        libc::sigemptyset(&raw mut action.sa_mask);
        libc::sigaction(signal, &raw const action, std::ptr::null_mut())
    };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// The handler.
extern "C" fn tell(_: c_int) {
    // SAFETY: `write` may be called in handlers. It does not fail, so the error number of the thread that this comes into stays:
    // the pipe is open as long as the process, and has room for more signals than anybody sends.
    unsafe { libc::write(WRITES_TO.load(Ordering::Relaxed), [0u8].as_ptr().cast(), 1) };
}
