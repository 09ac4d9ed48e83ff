use super::subject::Subject;
use crate::console::{self, JsonOutput};
use crate::interrupt;
use crate::outputs;
use anyhow::Result;
#[cfg(feature = "gpu")]
use fovolnet::Viewpoint;
use fovolnet::core::FrameSize;
use fovolnet::{Machine, Pipeline, Timings};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;

/// Whole frames: mask, march, reconstruct; on a GPU as the viewer shows them, without going through the host
#[derive(clap::Args)]
pub struct PipelineBench {
    #[command(flatten)]
    subject: Subject,
    #[command(flatten)]
    json: JsonOutput,
}

#[derive(Serialize)]
struct Report {
    volume: String,
    size: FrameSize,
    frames: usize,
    /// Whether frames stayed on the device, with two in progress at once.
    stays_on_device: bool,
    frames_per_second: f64,
    median_ms: Timings,
    /// Times of the finer stages.
    stages_median_ms: BTreeMap<&'static str, f64>,
    machine: Machine,
}

/// Default number of frames.
const FRAMES: u32 = 20;

impl PipelineBench {
    pub fn run(self) -> Result<()> {
        let opened = self.subject.open()?;
        outputs::check(self.json.file())?;
        outputs::have_folders(self.json.file())?;
        let settings = self.subject.settings(Some(FRAMES))?;
        let mut pipeline = Pipeline::new(&opened, &settings, self.subject.speed())?;
        console::warn(&pipeline);
        let numbers = settings.frame_numbers();
        pipeline.render(numbers.start)?;
        let started = Instant::now();
        let displayed = displayed(&mut pipeline, numbers.clone())?;
        let stays_on_device = displayed.is_some();
        let all = displayed.map_or_else(|| rendered(&mut pipeline, numbers), Ok)?;
        let seconds = started.elapsed().as_secs_f64();
        let t = Timings::reduced(&all, median);
        let report = Report {
            volume: self.subject.name(),
            size: pipeline.size(),
            frames: all.len(),
            stays_on_device,
            frames_per_second: all.len() as f64 / seconds,
            median_ms: t,
            stages_median_ms: t.finer().into(),
            machine: pipeline.machine(),
        };
        self.json.say(format!(
            "{} at {}, median of {} frames: {}, total {:.2} ms; {:.1} frames a second{}",
            report.volume,
            report.size,
            report.frames,
            t.finer().map(|(stage, ms)| format!("{stage} {ms:.2} ms")).join(", "),
            t.total,
            report.frames_per_second,
            if stays_on_device { " that stay on the device" } else { "" },
        ))?;
        self.json.write(&report)
    }
}

/// Renders the frames `numbers`, and returns their times.
fn rendered(pipeline: &mut Pipeline, numbers: Range<u32>) -> Result<Vec<Timings>> {
    let timed = |i| {
        interrupt::check("nothing was written")?;
        Ok(pipeline.render(i)?.timings)
    };
    numbers.map(timed).collect()
}

/// Renders the frames `numbers` to pictures on the device, and returns their times. `None` if frames do not stay there.
#[cfg(feature = "gpu")]
fn displayed(pipeline: &mut Pipeline, numbers: Range<u32>) -> Result<Option<Vec<Timings>>> {
    let mut all = Vec::new();
    for i in numbers {
        interrupt::check("nothing was written")?;
        let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
        let Some(frame) = pipeline.display_from(i, &viewpoint)? else { return Ok(None) };
        all.extend(frame.done);
    }
    all.extend(pipeline.finish_display()?);
    Ok(Some(all.into_iter().map(|done| done.timings).collect()))
}

/// Median of the milliseconds of frames 1 to `count` that stay on the device; `None` if frames do not stay there.
#[cfg(feature = "gpu")]
pub fn displayed_median_ms(pipeline: &mut Pipeline, count: u32) -> Result<Option<f64>> {
    pipeline.render(0)?;
    let all = displayed(pipeline, 1..count + 1)?;
    Ok(all.map(|all| median(&mut all.iter().map(|timings| timings.total).collect::<Vec<_>>())))
}

#[cfg(not(feature = "gpu"))]
fn displayed(_: &mut Pipeline, _: Range<u32>) -> Result<Option<Vec<Timings>>> {
    Ok(None)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
