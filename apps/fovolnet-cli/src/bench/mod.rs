//! Benchmarks of this machine.

pub mod compact;
#[cfg(feature = "gpu")]
mod gpu;
mod march;
mod march_model;
mod marching;
mod net;
mod pipeline;
#[cfg(feature = "gpu")]
mod record;
mod repeat;
mod subject;

use anyhow::Result;
use clap::Subcommand;

/// Measure this machine
#[derive(clap::Args)]
pub struct Bench {
    #[command(subcommand)]
    command: BenchCommand,
}

#[derive(Subcommand)]
enum BenchCommand {
    /// Marching every pixel: times, samples, samples per second
    March(march::MarchBench),
    /// Effective compression: time of sparse sampling compared with its share of pixels
    Compact(compact::CompactBench),
    /// Reconstruction networks: whole and layer by layer, against the peak of this machine
    Net(net::NetBench),
    /// Whole frames: mask, march, reconstruct
    Pipeline(pipeline::PipelineBench),
    /// A GPU in a few minutes: every way to march, then whole frames
    #[cfg(feature = "gpu")]
    Gpu(gpu::GpuBench),
}

impl Bench {
    pub fn run(self) -> Result<()> {
        match self.command {
            BenchCommand::March(bench) => bench.run(),
            BenchCommand::Compact(bench) => bench.run(),
            BenchCommand::Net(bench) => bench.run(),
            BenchCommand::Pipeline(bench) => bench.run(),
            #[cfg(feature = "gpu")]
            BenchCommand::Gpu(bench) => bench.run(),
        }
    }
}
