use crate::companion::Companion;
use anyhow::Result;
use std::ffi::OsString;

/// Program that opens windows. This program itself needs no display.
const VIEWER: Companion = Companion {
    name: "fovolnet-viewer",
    built_in: "target",
    build: "cargo build --release -p fovolnet-viewer",
};

#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct View {
    /// Arguments of `fovolnet-viewer`, a volume or a session first; --help shows them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

impl View {
    pub fn run(self) -> Result<()> {
        VIEWER.run(&self.arguments)
    }
}
