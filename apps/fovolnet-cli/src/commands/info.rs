use crate::console::JsonOutput;
use anyhow::{Result, bail};
use fovolnet::render::cpu::Simd;
use fovolnet::{Machine, VolumeSettings, open_volume};
use serde::Serialize;

/// Say what a volume file holds
#[derive(clap::Args)]
pub struct Info {
    /// Volume file, folder of slices, or procedural volume
    volume: Option<String>,
    /// Say what this machine can render with
    #[arg(long, conflicts_with = "volume")]
    devices: bool,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    format: String,
    dims: [usize; 3],
    dtype: String,
    components: usize,
    spacing: [f64; 3],
    min: f64,
    max: f64,
    mean: f64,
    non_finite: u64,
    range: [f64; 2],
    histogram: Vec<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation: Option<String>,
}

#[derive(Serialize)]
struct Devices {
    machine: Machine,
    simd: Vec<String>,
}

const BINS: usize = 64;

impl Info {
    pub fn run(self) -> Result<()> {
        if self.devices {
            return self.devices();
        }
        let Some(name) = &self.volume else { bail!("no volume is named; give a file, or --devices") };
        let volume = open_volume(name, &self.read)?.volume;
        let statistics = volume.statistics();
        let report = Report {
            format: volume.format().to_owned(),
            dims: volume.grid().dims(),
            dtype: volume.dtype().to_string(),
            components: volume.components(),
            spacing: volume.grid().spacing(),
            min: statistics.min,
            max: statistics.max,
            mean: statistics.mean,
            non_finite: statistics.non_finite,
            range: volume.range(),
            histogram: volume.histogram(BINS, volume.range()),
            orientation: volume.orientation().map(str::to_owned),
        };
        self.describe(name, &report)?;
        self.json.write(&report)
    }

    fn describe(&self, name: &str, r: &Report) -> Result<()> {
        let say = |line: String| self.json.say(line);
        let [x, y, z] = r.dims;
        say(name.to_owned())?;
        say(format!("  format      {}", r.format))?;
        say(format!("  dims        {x} x {y} x {z}"))?;
        say(format!(
            "  type        {}, {} component{}",
            r.dtype,
            r.components,
            if r.components == 1 { "" } else { "s" }
        ))?;
        say(format!("  spacing     {} x {} x {}", r.spacing[0], r.spacing[1], r.spacing[2]))?;
        say(format!("  values      {} to {}, mean {:.6}", r.min, r.max, r.mean))?;
        say(format!("  shown as    {} (0) to {} (1)", r.range[0], r.range[1]))?;
        if r.non_finite > 0 {
            say(format!("  not finite  {} values, shown as the lowest", r.non_finite))?;
        }
        if let Some(orientation) = &r.orientation {
            say(format!("  orientation {orientation}"))?;
        }
        say(format!("  histogram   {}", sparkline(&r.histogram)))
    }

    fn devices(&self) -> Result<()> {
        let available = Simd::available();
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let devices = Devices {
            machine: Machine::this(threads, Simd::best()),
            simd: available.iter().map(ToString::to_string).collect(),
        };
        self.json.say(format!(
            "cpu    {} ({threads} threads), instruction sets: {}",
            devices.machine.cpu,
            devices.simd.join(" ")
        ))?;
        self.json.write(&devices)
    }
}

/// Counts as bars of eighths, on a logarithmic scale.
fn sparkline(counts: &[u64]) -> String {
    const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let height = |count: u64| (count as f64 + 1.0).ln();
    let most = counts.iter().map(|&c| height(c)).fold(1e-9, f64::max);
    counts.iter().map(|&c| BARS[(height(c) / most * 8.0).ceil() as usize]).collect()
}
