use crate::companion::Companion;
use anyhow::Result;
use std::ffi::OsString;

/// Program that trains networks.
const TRAINER: Companion = Companion {
    name: "fovolnet-train",
    built_in: "training/target",
    build: ". training/environment && cargo build --release --manifest-path training/Cargo.toml",
};

#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Train {
    /// Arguments of `fovolnet-train train`; --help shows them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

impl Train {
    pub fn run(self) -> Result<()> {
        let arguments: Vec<OsString> = std::iter::once("train".into()).chain(self.arguments).collect();
        TRAINER.run(&arguments)
    }
}
