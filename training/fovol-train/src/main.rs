//! The command `fovolnet-train`.

use clap::{Parser, Subcommand};

/// Trains reconstruction networks.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Show what libtorch finds on this machine
    Check,
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Check => check(),
    }
    Ok(())
}

fn check() {
    println!("CUDA      {}", tch::Cuda::is_available());
    println!("threads   {}", tch::get_num_threads());
}
