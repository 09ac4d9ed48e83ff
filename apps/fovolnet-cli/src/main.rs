//! The `fovolnet` command.

use fovolnet::core::memory::ExitWhenExhausted;
use std::process::ExitCode;

/// Too little memory ends the program with one line.
#[global_allocator]
static MEMORY: ExitWhenExhausted = ExitWhenExhausted;

fn main() -> ExitCode {
    ExitCode::from(fovolnet_cli::run(std::env::args_os()))
}
