//! Ctrl-C and similar events on systems without Unix signals.

use std::io;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Events that end this process.
pub struct Signals(Receiver<()>);

impl Signals {
    /// Starts to receive every event that ends a program.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn listen() -> io::Result<Self> {
        let (send, events) = channel();
        let tell = move || {
            // The receiver may be gone.
            let _ = send.send(());
        };
        ctrlc::set_handler(tell).map_err(io::Error::other)?;
        Ok(Self(events))
    }

    /// Waits for the next event; false if no more can come.
    pub fn wait(&mut self) -> bool {
        self.0.recv().is_ok()
    }

    /// Waits for the next event, at most `patience`. Returns whether one came.
    pub fn wait_for(&mut self, patience: Duration) -> bool {
        self.0.recv_timeout(patience).is_ok()
    }
}

/// Writes `text` to standard error.
pub fn say(text: &str) {
    eprint!("{text}");
}

/// Ends the process.
#[expect(clippy::disallowed_methods, reason = "there is no main to return to from the thread of signals")]
pub fn exit(status: u8) -> ! {
    std::process::exit(status.into())
}
