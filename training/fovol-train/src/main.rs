//! The command `fovolnet-train`.

mod bench_step;

use bench_step::BenchStep;
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
    /// Measure a step of training
    #[command(hide = true)]
    BenchStep(BenchStep),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Check => check(),
        Command::BenchStep(bench) => bench.run()?,
    }
    Ok(())
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
