//! Companion programs, which are built separately and started by subcommands of the same name.

use anyhow::{Context, Result, bail};
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Program of this project that is built separately.
pub struct Companion {
    /// File name, without `.exe`.
    pub name: &'static str,
    /// Folder with `release` and `debug` where the repository builds it, relative to the repository's root.
    pub built_in: &'static str,
    /// Command that builds it.
    pub build: &'static str,
}

/// Error: a companion program ended with this exit status. It has reported the problem itself.
#[derive(Debug, thiserror::Error)]
#[error("exit status {0}")]
pub struct Failed(pub u8);

impl Companion {
    /// Runs the program with `arguments`. On Unix it replaces this process, elsewhere this process waits for it.
    ///
    /// # Errors
    /// A program that is not found, cannot be started, or fails.
    pub fn run(&self, arguments: &[OsString]) -> Result<()> {
        let Some(program) = self.find() else {
            bail!(
                "{} is not built, and `fovolnet` needs it for this; build it with `{}`",
                self.name,
                self.build
            );
        };
        run(Command::new(&program).args(arguments))
            .with_context(|| format!("cannot start {}", program.display()))
    }

    /// Looks for the program beside this one, in the build folders of the repository, and on the PATH.
    fn find(&self) -> Option<PathBuf> {
        let file = format!("{}{}", self.name, env::consts::EXE_SUFFIX);
        let this = env::current_exe().ok()?;
        let beside = this.parent().map(Path::to_owned);
        // If this program was built in the repository, it lies in target/release.
        let built = this.ancestors().nth(3).map(|root| root.join(self.built_in));
        let built = built.into_iter().flat_map(|folder| ["release", "debug"].map(|kind| folder.join(kind)));
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = beside.into_iter().chain(built).chain(env::split_paths(&path));
        folders.map(|folder| folder.join(&file)).find(|program| program.is_file())
    }
}

/// Replaces this process by the program, which then receives all signals.
#[cfg(unix)]
fn run(program: &mut Command) -> Result<()> {
    Err(std::os::unix::process::CommandExt::exec(program).into())
}

/// Starts the program and waits for it.
#[cfg(not(unix))]
fn run(program: &mut Command) -> Result<()> {
    match program.status()?.code() {
        Some(0) => Ok(()),
        Some(code) => Err(Failed(u8::try_from(code).unwrap_or(1)).into()),
        None => bail!("it was stopped by a signal"),
    }
}
