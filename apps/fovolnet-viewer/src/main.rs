//! The `fovolnet-viewer` command.

use fovolnet::core::memory::ExitWhenExhausted;
use std::process::ExitCode;

/// Too little memory ends the window with one line; what was not saved is found again.
#[global_allocator]
static MEMORY: ExitWhenExhausted = ExitWhenExhausted;

fn main() -> ExitCode {
    ExitCode::from(fovolnet_viewer::run(std::env::args_os()))
}
