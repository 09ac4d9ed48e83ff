//! Measurements of this machine.

pub mod compact;
mod march;
mod marching;
mod net;
mod pipeline;
mod repeat;

use anyhow::Result;
use clap::Subcommand;
use fovolnet::RenderSettings;
use fovolnet::core::Integration;

/// Measure this machine
#[derive(clap::Args)]
pub struct Bench {
    #[command(subcommand)]
    command: BenchCommand,
}

#[derive(Subcommand)]
enum BenchCommand {
    /// Marching every pixel: times, samples, samples a second
    March(march::MarchBench),
    /// Effective compression: the time of sparse sampling against its share of pixels
    Compact(compact::CompactBench),
    /// Reconstruction networks: whole and layer by layer, against the peak of this machine
    Net(net::NetBench),
    /// Whole frames: mask, march, reconstruct
    Pipeline(pipeline::PipelineBench),
}

impl Bench {
    pub fn run(self) -> Result<()> {
        match self.command {
            BenchCommand::March(bench) => bench.run(),
            BenchCommand::Compact(bench) => bench.run(),
            BenchCommand::Net(bench) => bench.run(),
            BenchCommand::Pipeline(bench) => bench.run(),
        }
    }
}

/// `settings` with the path and the integration that measurements have always had, where none is named.
fn on_orbit(mut settings: RenderSettings) -> RenderSettings {
    if settings.camera.is_none() && settings.view.is_none() {
        settings.path.get_or_insert_with(|| "orbit".into());
    }
    settings.integration.get_or_insert(Integration::Plain);
    settings
}

/// Threads of our own, so that `--threads` holds for bare steps too; as many as there are cores for 0.
pub fn rayon_pool(threads: usize) -> Result<rayon::ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?)
}
