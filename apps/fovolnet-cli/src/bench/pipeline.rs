use crate::console::{self, JsonOutput};
use crate::interrupt;
use anyhow::Result;
use fovolnet::core::FrameSize;
use fovolnet::{Machine, Pipeline, RenderSettings, SpeedSettings, Timings, VolumeSettings, open_volume};
use serde::Serialize;

/// Whole frames: mask, march, reconstruct
#[derive(clap::Args)]
pub struct PipelineBench {
    /// Volume file, folder of slices, or procedural volume
    #[arg(default_value = "head")]
    volume: String,
    #[command(flatten)]
    read: VolumeSettings,
    #[command(flatten)]
    settings: RenderSettings,
    #[command(flatten)]
    speed: SpeedSettings,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    volume: String,
    size: FrameSize,
    frames: usize,
    median_ms: Timings,
    machine: Machine,
}

/// Frames, unless said otherwise.
const FRAMES: u32 = 20;

impl PipelineBench {
    pub fn run(mut self) -> Result<()> {
        self.settings.frames.get_or_insert(FRAMES);
        let opened = open_volume(&self.volume, &self.read)?;
        let mut pipeline = Pipeline::new(&opened, &self.settings, &self.speed)?;
        console::warn(&pipeline);
        let numbers = self.settings.frame_numbers();
        pipeline.render(numbers.start)?;
        let mut all: Vec<Timings> = Vec::new();
        for i in numbers {
            interrupt::check("nothing was written")?;
            all.push(pipeline.render(i)?.timings);
        }
        let report = Report {
            volume: self.volume.clone(),
            size: pipeline.size(),
            frames: all.len(),
            median_ms: Timings {
                mask: median(&all, |t| t.mask),
                march: median(&all, |t| t.march),
                reconstruct: median(&all, |t| t.reconstruct),
                total: median(&all, |t| t.total),
            },
            machine: pipeline.machine(),
        };
        let t = report.median_ms;
        self.json.say(format!(
            "{} at {}, median of {} frames: mask {:.2} ms, march {:.2} ms, reconstruct {:.2} ms, total {:.2} ms",
            report.volume, report.size, report.frames, t.mask, t.march, t.reconstruct, t.total
        ))?;
        self.json.write(&report)
    }
}

fn median(all: &[Timings], of: impl Fn(&Timings) -> f64) -> f64 {
    let mut values: Vec<f64> = all.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
