//! Unix signals. A handler may do almost nothing, so it writes a byte to a pipe, and a thread reads it.

use libc::c_int;
use std::io::{self, IsTerminal, PipeReader, PipeWriter, Read};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicI32, Ordering};
use std::time::{Duration, Instant};

/// File descriptor to which the handler writes.
static WRITES_TO: AtomicI32 = AtomicI32::new(-1);

/// Signals of this process.
pub struct Signals {
    reader: PipeReader,
    /// Kept open, because the handler writes to it.
    _writer: PipeWriter,
}

impl Signals {
    /// Starts to receive every signal that ends a program.
    ///
    /// # Errors
    /// Errors of the operating system.
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

    /// Waits for the next signal; false if no more can come.
    pub fn wait(&mut self) -> bool {
        self.reader.read_exact(&mut [0]).is_ok()
    }

    /// Waits for the next signal, at most `patience`. Returns whether one came.
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

/// Writes `text` to standard error, over a progress bar that may stand there. Gives up if the terminal is not ready.
pub fn say(text: &str) {
    let line_start = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    let text = format!("{line_start}{text}");
    if is_ready(libc::STDERR_FILENO, libc::POLLOUT, Duration::ZERO) {
        // SAFETY: pointer and length are those of `text`. The lock of `io::stderr` is avoided, since its owner may be
        // stopped.
        unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
    }
}

/// Ends the process without an orderly exit, because other threads still use the memory that it would free.
pub fn exit(status: u8) -> ! {
    // SAFETY: any thread may call `_exit` at any time.
    unsafe { libc::_exit(status.into()) }
}

/// Whether `file` becomes ready for the poll events `what` within `patience`.
fn is_ready(file: c_int, what: libc::c_short, patience: Duration) -> bool {
    let mut asked = libc::pollfd { fd: file, events: what, revents: 0 };
    let patience = c_int::try_from(patience.as_millis()).unwrap_or(c_int::MAX);
    // SAFETY: the pointer leads to one `pollfd`, which outlives the call.
    unsafe { libc::poll(&raw mut asked, 1, patience) == 1 }
}

fn is_ignored(signal: c_int) -> io::Result<bool> {
    // SAFETY: all-zero bytes are a valid `sigaction`. Without a new action the call only writes to `found`.
    let (result, found) = unsafe {
        let mut found: libc::sigaction = std::mem::zeroed();
        (libc::sigaction(signal, std::ptr::null(), &raw mut found), found)
    };
    if result == 0 { Ok(found.sa_sigaction == libc::SIG_IGN) } else { Err(io::Error::last_os_error()) }
}

fn take(signal: c_int) -> io::Result<()> {
    // SAFETY: all-zero bytes are a valid `sigaction`. The handler calls async-signal-safe functions only.
    let result = unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = tell as extern "C" fn(c_int) as libc::sighandler_t;
        // System calls that the signal interrupts are restarted.
        action.sa_flags = libc::SA_RESTART;
        libc::sigemptyset(&raw mut action.sa_mask);
        libc::sigaction(signal, &raw const action, std::ptr::null_mut())
    };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// Signal handler.
extern "C" fn tell(_: c_int) {
    // SAFETY: `write` is async-signal-safe. It does not fail, so it keeps the `errno` of the interrupted thread: the
    // pipe stays open, and has room for more signals than anybody sends.
    unsafe { libc::write(WRITES_TO.load(Ordering::Relaxed), [0u8].as_ptr().cast(), 1) };
}
