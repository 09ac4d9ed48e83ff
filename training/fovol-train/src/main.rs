//! The command `fovolnet-train`.

mod bench_step;
mod calibrate;
mod fine_tune;
mod train;

use bench_step::BenchStep;
use calibrate::Calibrate;
use clap::{Parser, Subcommand};
use fovol_train::loss;
use fovol_train::terminal::say;
use std::path::{Path, PathBuf};
use train::Train;

/// Trains reconstruction networks.
#[derive(Parser)]
#[command(name = "fovolnet-train", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make clips and train a network on them
    Train(Train),
    /// Note the ranges of activations in a weights file, which int8 needs; training does so by itself
    Calibrate(Calibrate),
    /// Show what libtorch finds on this machine
    Check,
    /// Convert torchvision's weights of VGG into the file that perceptual losses read
    ConvertVgg {
        /// torchvision's vgg19-dcbb9e9d.pth, or vgg16-397923af.pth for LPIPS
        weights: PathBuf,
        /// The safetensors file to write
        output: PathBuf,
        /// The heads of LPIPS: weights/v0.1/vgg.pth of its source
        #[arg(long)]
        heads: Option<PathBuf>,
    },
    /// Measure a step of training
    #[command(hide = true)]
    BenchStep(BenchStep),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Train(train) => train.run()?,
        Command::Calibrate(calibrate) => calibrate.run()?,
        Command::Check => check(),
        Command::ConvertVgg { weights, output, heads } => convert_vgg(&weights, heads.as_deref(), &output)?,
        Command::BenchStep(bench) => bench.run()?,
    }
    Ok(())
}

fn check() {
    let cuda = match tch::Cuda::device_count() {
        0 => "no device".to_owned(),
        count => format!("{count} device(s), cuDNN {}", tch::Cuda::cudnn_is_available()),
    };
    say(format_args!("libtorch  {}", env!("FOVOLNET_LIBTORCH_VERSION")));
    say(format_args!("CUDA      {cuda}"));
    say(format_args!("oneDNN    {}", tch::utils::has_mkldnn()));
    say(format_args!("threads   {}", tch::get_num_threads()));
}

fn convert_vgg(weights: &Path, heads: Option<&Path>, output: &Path) -> anyhow::Result<()> {
    let found = loss::convert_vgg(weights, heads, output)?;
    let origin = if found.is_original { "torchvision's" } else { "not the file that torchvision has" };
    say(format_args!(
        "network   {}, {} tensors, {} numbers",
        found.depth.name(),
        found.tensors,
        found.numbers
    ));
    say(format_args!("SHA-256   {} ({origin})", found.sha256));
    if let Some(sha256) = found.heads_sha256 {
        say(format_args!("heads     {sha256}"));
    }
    say(format_args!("written   {}", output.display()));
    Ok(())
}
