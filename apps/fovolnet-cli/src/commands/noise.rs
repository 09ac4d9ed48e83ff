use crate::console::{self, JsonOutput};
use crate::outputs;
use anyhow::{Context, Result, bail};
use clap::Subcommand;
use fovolnet::core::input;
use fovolnet::core::memory::Estimate;
use fovolnet::io::{Error, atomic};
use fovolnet::render::noise::{NoiseSize, STBN_SEED, bytes_of_making_ranks, encode_ranks, ranks, statistics};
use npyz::WriterBuilder;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

/// Make and check the noise that chooses pixels
#[derive(clap::Args)]
pub struct NoiseArgs {
    #[command(subcommand)]
    command: NoiseCommand,
}

#[derive(Subcommand)]
enum NoiseCommand {
    /// Make spatio-temporal blue noise: ranks of axes t, y, x
    Make {
        /// File to write: .npy (u32), or .ranks (the packed form that the program carries)
        output: PathBuf,
        /// Edge of the tile in pixels, 16 to 256
        #[arg(long, value_name = "N", default_value_t = 128)]
        size: usize,
        /// Number of frames, 1 to 256
        #[arg(long, value_name = "N", default_value_t = 64)]
        frames: usize,
        /// Seed; the default makes the noise that the program carries
        #[arg(long, value_name = "N", default_value_t = STBN_SEED)]
        seed: u64,
    },
    /// Check the spectra and statistics of noise
    Check {
        /// Ranks as .npy, u32, axes t, y, x
        input: PathBuf,
        #[command(flatten)]
        json: JsonOutput,
    },
}

impl NoiseArgs {
    pub fn run(self) -> Result<()> {
        match self.command {
            NoiseCommand::Make { output, size, frames, seed } => make(&output, size, frames, seed),
            NoiseCommand::Check { input, json } => check(&input, &json),
        }
    }
}

fn make(output: &Path, side: usize, frames: usize, seed: u64) -> Result<()> {
    let size = NoiseSize::new(side, side, frames).map_err(anyhow::Error::msg)?;
    Estimate::new(format!("making {frames}x{side}x{side} ranks"))
        .with("energies", bytes_of_making_ranks(size))
        .check("a smaller --size or fewer --frames need less")?;
    let extension = output.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match extension {
        "npy" => {
            let ranks = ranks(size, seed);
            atomic::write(output, |out| {
                let shape = [frames as u64, side as u64, side as u64];
                let mut writer =
                    npyz::WriteOptions::new().default_dtype().shape(&shape).writer(out).begin_nd()?;
                writer.extend(&ranks)?;
                writer.finish()
            })?;
        }
        "ranks" if size.len() > 1 << 20 => {
            bail!("the packed form keeps 20 bits a rank, too few for this size; write .npy")
        }
        "ranks" => {
            let bytes = encode_ranks(&ranks(size, seed));
            atomic::write(output, |out| out.write_all(&bytes))?;
        }
        _ => bail!("{}: noise is written as .npy or .ranks; choose one of these names", output.display()),
    }
    console::say(format!("wrote {frames}x{side}x{side} ranks to {}", output.display()))
}

fn check(input: &Path, json: &JsonOutput) -> Result<()> {
    let (ranks, size) = read(input)?;
    outputs::check(json.file())?;
    let report = statistics::check(&ranks, size);
    for line in &report.checks {
        let verdict = if line.passed { "ok  " } else { "FAIL" };
        json.say(format!("{verdict} {:<44} {:>12.6}  {}", line.name, line.value, line.limit))?;
    }
    json.write(&report)?;
    let failed = report.checks.iter().filter(|c| !c.passed).count();
    if failed > 0 {
        bail!("{}: {failed} checks failed; make it again with `fovolnet noise make`", input.display());
    }
    Ok(())
}

fn read(path: &Path) -> Result<(Vec<u32>, NoiseSize)> {
    let file = input::open(path).map_err(|e| Error::io("read", path, e))?;
    let bad = || {
        format!(
            "{}: it is not a .npy file of u32 [t][y][x]; make one with `fovolnet noise make`",
            path.display()
        )
    };
    let npy = npyz::NpyFile::new(BufReader::new(file)).with_context(bad)?;
    let [frames, height, width] = <[u64; 3]>::try_from(npy.shape()).map_err(|_| anyhow::anyhow!(bad()))?;
    let side = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let size = NoiseSize::new(side(width), side(height), side(frames))
        .map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?;
    if npy.order() != npyz::Order::C {
        bail!("{}: its axes are in Fortran order; save it with numpy.ascontiguousarray", path.display());
    }
    let ranks = npy.into_vec::<u32>().with_context(bad)?;
    Ok((ranks, size))
}
