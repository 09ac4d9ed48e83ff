use crate::companion::Companion;
use anyhow::Result;
use std::ffi::OsString;

/// What opens windows; this program itself needs no display.
const VIEWER: Companion = Companion {
    name: "fovolnet-viewer",
    built_in: "target",
    build: "cargo build --release -p fovolnet-viewer",
};

#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct View {
    /// What `fovolnet-viewer` takes, a volume or a session first; --help shows it
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

impl View {
    pub fn run(self) -> Result<()> {
        VIEWER.run(&self.arguments)
    }
}
