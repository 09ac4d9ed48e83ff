//! Ctrl-C and its like where signals are not those of Unix.

use std::io;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// The events that end this process.
pub struct Signals(Receiver<()>);

impl Signals {
    /// Has every event that ends a program come to this.
    ///
    /// # Errors
    /// What the system said.
    pub fn listen() -> io::Result<Self> {
        let (send, events) = channel();
        let tell = move || {
            // Nobody may listen any more.
            let _ = send.send(());
        };
        ctrlc::set_handler(tell).map_err(io::Error::other)?;
        Ok(Self(events))
    }

    /// Waits for the next event; false where none can come any more.
    pub fn wait(&mut self) -> bool {
        self.0.recv().is_ok()
    }

    /// Waits for the next event, but not longer than `patience`: whether one came.
    pub fn wait_for(&mut self, patience: Duration) -> bool {
        self.0.recv_timeout(patience).is_ok()
    }
}

/// Says `text` on standard error.
pub fn say(text: &str) {
    eprint!("{text}");
}

/// Ends the process.
#[expect(clippy::disallowed_methods, reason = "there is no main to return to from the thread of signals")]
pub fn exit(status: u8) -> ! {
    std::process::exit(status.into())
}
