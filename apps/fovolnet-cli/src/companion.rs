//! The programs beside this one: built apart, started by subcommands of the same name.

use anyhow::{Context, Result, bail};
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A program of this project that is built apart.
pub struct Companion {
    /// Its file name, without `.exe`.
    pub name: &'static str,
    /// Where the repository builds it, from the repository's root: the folder of `release` and `debug`.
    pub built_in: &'static str,
    /// The command that builds it.
    pub build: &'static str,
}

/// A program beside this one ended with this exit status; it has said itself what was wrong.
#[derive(Debug, thiserror::Error)]
#[error("exit status {0}")]
pub struct Failed(pub u8);

impl Companion {
    /// Runs it with `arguments`; where that is possible this program becomes that one, else it waits for it.
    ///
    /// # Errors
    /// A program that is nowhere, that cannot be started, or that ends with a failure.
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

    /// Beside this program, in the build folders of the repository, or on the PATH.
    fn find(&self) -> Option<PathBuf> {
        let file = format!("{}{}", self.name, env::consts::EXE_SUFFIX);
        let this = env::current_exe().ok()?;
        let beside = this.parent().map(Path::to_owned);
        // This program lies in target/release of the repository.
        let built = this.ancestors().nth(3).map(|root| root.join(self.built_in));
        let built = built.into_iter().flat_map(|folder| ["release", "debug"].map(|kind| folder.join(kind)));
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = beside.into_iter().chain(built).chain(env::split_paths(&path));
        folders.map(|folder| folder.join(&file)).find(|program| program.is_file())
    }
}

/// Becomes the program: signals are its own from then on.
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
