//! The command `fovolnet`, for programs that carry it.

// Printing would panic once the reader of the output is gone; see `console::say`.
#![deny(clippy::print_stdout)]

mod bench;
mod commands;
mod companion;
mod console;
mod frame_files;
mod frame_maker;
mod frame_sequence;
mod frame_source;
mod instruction_set;
mod interrupt;
mod label;
mod long_work;
mod memory_limits;
mod outputs;
mod picture;
mod picture_arguments;
mod repro;
mod second_file;
mod sparse_sequence;
mod thread_pool;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::{OsStr, OsString};
use std::io::{self, Write};

/// Foveated sparse volume rendering with reconstruction.
#[derive(Parser)]
#[command(name = "fovolnet", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    simd: instruction_set::InstructionSet,
}

#[derive(Subcommand)]
enum Command {
    /// Render a short foveated fly-through of a built-in volume, with pictures of every stage
    Demo(commands::demo::Demo),
    /// Say what a volume file holds
    Info(commands::info::Info),
    /// Convert between volume formats
    Convert(commands::convert::Convert),
    /// List, make and download volumes
    Data(commands::data::Data),
    /// Make and check the noise that chooses pixels
    Noise(commands::noise::NoiseArgs),
    /// Write the sample map of one frame
    Mask(commands::mask::Mask),
    /// Render frames of a volume
    Render(commands::render::Render),
    /// Fill sparse frames of any renderer
    Reconstruct(commands::reconstruct::Reconstruct),
    /// Train a network on clips of volumes
    Train(commands::train::Train),
    /// Write a network for other programs
    Export(commands::export::Export),
    /// Compare two folders of frames, two clips, or two pictures
    Metrics(commands::metrics::Metrics),
    /// Measure this machine
    Bench(bench::Bench),
    /// Make the tables and figures of the paper's evaluation
    Repro(repro::Repro),
    /// Look at a volume in a window
    View(commands::view::View),
}

/// Silences Mesa's device-select layer, which complains if there is no desktop to ask for the preferred GPU.
fn quieten_drivers() {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this runs first in the program, so no other thread can read the environment.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// Turns exceeding the file size limit (`ulimit -f`) into a write error. By default the signal would end the program
/// and leave half a file behind.
fn outlive_file_limits() {
    #[cfg(unix)]
    // SAFETY: ignoring a signal needs no handler and is allowed at any time.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Runs the command with `arguments`, the first of which is the program, and returns the exit status.
///
/// It is meant for a process of its own: it listens to signals, and changes the limits of the process.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    quieten_drivers();
    outlive_file_limits();
    fovolnet::keep_freed_memory();
    memory_limits::outlive();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return usage(&error, &arguments),
    };
    if let Err(problem) = cli.simd.choose() {
        return usage(&Cli::command().error(ErrorKind::InvalidValue, problem), &arguments);
    }
    interrupt::install();
    long_work::show();
    fovolnet::io::atomic::keep_inputs();
    let result = interrupt::leave(|| match cli.command {
        Command::Demo(args) => args.run(),
        Command::Info(args) => args.run(),
        Command::Convert(args) => args.run(),
        Command::Data(args) => args.run(),
        Command::Noise(args) => args.run(),
        Command::Mask(args) => args.run(),
        Command::Render(args) => args.run(),
        Command::Reconstruct(args) => args.run(),
        Command::Train(args) => args.run(),
        Command::Export(args) => args.run(),
        Command::Metrics(args) => args.run(),
        Command::Bench(args) => args.run(),
        Command::Repro(args) => args.run(),
        Command::View(args) => args.run(),
    });
    if interrupt::asked() {
        fovolnet::signals::said();
    }
    match result {
        Ok(()) => 0,
        // The reader of the output has closed it, which is no error.
        Err(error) if console::is_broken_pipe(&error) => 0,
        Err(error) if error.is::<companion::Failed>() => {
            error.downcast_ref::<companion::Failed>().map_or(1, |failed| failed.0)
        }
        Err(error) => {
            eprintln!("error: {}", fovolnet::one_line(error.as_ref()));
            if is_usage(&error) { 2 } else { 1 }
        }
    }
}

/// Whether `error` comes from contradictory arguments.
fn is_usage(error: &anyhow::Error) -> bool {
    use fovolnet::Error::{Contradiction, Io};
    use fovolnet::io::Error::IsInput;
    matches!(error.downcast_ref(), Some(Contradiction(_) | Io(IsInput { .. })))
        || matches!(error.downcast_ref(), Some(IsInput { .. }))
}

/// Prints help and version unchanged to standard output. Wrong usage gets a line of error, and a command without
/// arguments gets the help.
fn usage(error: &clap::Error, arguments: &[OsString]) -> u8 {
    if !error.use_stderr() {
        // The reader may have closed the output.
        let _ = write!(io::stdout(), "{error}");
        return 0;
    }
    let text = error.to_string();
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        eprint!("{text}");
        return 2;
    }
    let what = fovolnet::usage_line(error);
    eprintln!("error: {what}; see `{} --help`", named_command(arguments.iter().skip(1)));
    2
}

/// Command and subcommands that `arguments` name, as `fovolnet data get`.
fn named_command(arguments: impl Iterator<Item = impl AsRef<OsStr>>) -> String {
    let mut command = Cli::command();
    let mut words = command.get_name().to_owned();
    for argument in arguments {
        let Some(named) = command.find_subcommand(argument.as_ref()).cloned() else { break };
        words += &format!(" {}", named.get_name());
        command = named;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_named_with_their_subcommands() {
        for (line, named) in [
            ("render head --backgroud 1,1,1", "fovolnet render"),
            ("data get --x", "fovolnet data get"),
            ("rendr render", "fovolnet"),
            ("", "fovolnet"),
        ] {
            assert_eq!(named_command(line.split_whitespace().map(OsString::from)), named, "{line}");
        }
    }
}
