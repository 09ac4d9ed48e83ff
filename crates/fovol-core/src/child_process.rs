//! Child processes that work for this one, such as ffmpeg.

use crate::stop;
use crate::temporaries;
use crate::unfinished::{self, Gate};
use std::io;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Child process that works for this one. It is killed when this value is dropped, or when this process is asked to
/// stop; see [`unfinished`].
#[derive(Debug)]
pub struct ChildProcess(Arc<Mutex<Child>>);

/// Longest pause between two checks whether the child has ended.
const LOOK: Duration = Duration::from_millis(10);

impl ChildProcess {
    /// Starts `command`. On Unix the child gets a process group of its own, so that Ctrl-C on a terminal reaches only
    /// this process, which then decides about its children.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        let gate = Gate::enter();
        let child = Arc::new(Mutex::new(command.spawn()?));
        gate.add_child(&child);
        Ok(Self(child))
    }

    /// Takes a pipe of the child, its input or its output, by the function `of`. To wait for the child's end use
    /// [`Self::wait`].
    pub fn take<T>(&mut self, of: impl FnOnce(&mut Child) -> Option<T>) -> Option<T> {
        of(&mut self.child())
    }

    /// Waits until the child has ended. Close its input first.
    ///
    /// # Errors
    /// Errors of the operating system. A stop that was asked for meanwhile, which kills the child.
    pub fn wait(&mut self) -> io::Result<ExitStatus> {
        let mut pause = Duration::from_micros(100);
        loop {
            let ended = self.child().try_wait()?;
            if let Some(status) = ended {
                temporaries::forget_writer(self.child().id());
                return Ok(status);
            }
            if stop::asked() {
                self.end();
                return Err(io::Error::other(stop::Stopped));
            }
            std::thread::sleep(pause);
            pause = LOOK.min(2 * pause);
        }
    }

    fn end(&mut self) {
        let mut child = self.child();
        temporaries::forget_writer(child.id());
        // A child that has ended already cannot be killed, which is no error here.
        let _ = child.kill();
        let _ = child.wait();
    }

    fn child(&self) -> MutexGuard<'_, Child> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        self.end();
        unfinished::forget_child(&self.0);
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::process::Stdio;
    use std::time::Instant;

    #[test]
    fn it_says_how_it_ended_and_ends_with_its_owner() {
        let mut quick = ChildProcess::start(Command::new("sh").args(["-c", "exit 3"])).unwrap();
        assert_eq!(quick.wait().unwrap().code(), Some(3));
        let mut slow = ChildProcess::start(Command::new("sleep").arg("60").stdin(Stdio::piped())).unwrap();
        assert!(slow.take(|child| child.stdin.take()).is_some());
        let started = Instant::now();
        drop(slow);
        assert!(started.elapsed() < Duration::from_secs(10));
    }
}
