//! The command `fovolnet-train`.

use clap::{Parser, Subcommand};

/// Trains reconstruction networks.
#[derive(Parser)]
#[command(name = "fovolnet-train", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Show what libtorch finds on this machine
    Check,
}

fn main() {
    match Arguments::parse().command {
        Command::Check => check(),
    }
}

fn check() {
    let cuda = match tch::Cuda::device_count() {
        0 => "no device".to_owned(),
        count => format!("{count} device(s), cuDNN {}", tch::Cuda::cudnn_is_available()),
    };
    println!("libtorch  {}", env!("FOVOLNET_LIBTORCH_VERSION"));
    println!("CUDA      {cuda}");
    println!("oneDNN    {}", tch::utils::has_mkldnn());
    println!("threads   {}", tch::get_num_threads());
}
