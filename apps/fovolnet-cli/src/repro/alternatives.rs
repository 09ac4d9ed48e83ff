//! Beyond the paper: cost and quality of every honest way to make a frame cheaper.

use super::data_set::DataSet;
use super::evaluation::{Evaluation, SPARSE};
use super::methods::{self, METHODS, Method};
use super::plot::{self, Axes, Line};
use super::section::{Cell, Section};
use crate::interrupt;
use anyhow::Result;
use fovolnet::core::{Frame, FrameSize, ShadowMode};
use fovolnet::io::image;
use fovolnet::metrics::{ClipQuality, Display, FovVideoVdp};
use fovolnet::{Freedom, Guide, Limit, OpenVolume, Pipeline, PlannedPipeline, RenderSettings, Sampling};
use std::time::Instant;

/// Consecutive frames of the clip. The first ones are not judged, since networks have no history there.
const CLIP: u32 = 16;
const SETTLED: u32 = 8;
const FPS: f64 = 30.0;
/// Sampling densities P_b, each with a width σ of the fovea.
const SAMPLINGS: [[f64; 2]; 5] = [[0.01, 0.02], [0.03, 0.02], [0.07, 0.06], [0.15, 0.06], [0.30, 0.06]];
/// Marching steps in voxels; the full frame has ½.
const STEPS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Factors by which frames are smaller along each axis before they are enlarged.
const SMALLER: [u32; 3] = [2, 3, 4];
/// Parts of the size along each axis that frames with cached shadows have.
const CACHED: [[u32; 2]; 5] = [[1, 1], [3, 4], [1, 2], [1, 3], [1, 4]];

/// Budgets of the planner, as parts of the time of an exact full frame.
const BUDGETS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.8];
/// Name of the planner's frames.
const PLANNER: &str = "planner";

/// One way to make frames cheaper.
struct Way {
    family: &'static str,
    name: String,
    settings: RenderSettings,
    finish: Finish,
}

/// Last step of a way, after a frame was rendered.
#[derive(Clone, Copy)]
enum Finish {
    Nothing,
    /// It was rendered smaller.
    Enlarge,
    /// It was rendered smaller, and its cached shadows are made for this frame.
    Recast,
    /// Its light ratios are filled by the joint bilateral filter instead.
    Bilateral,
    /// A planner makes it within this number of milliseconds.
    Planned(f64),
}

impl Finish {
    fn of(method: Method) -> Self {
        if method.is_bilateral() { Self::Bilateral } else { Self::Nothing }
    }
}

/// Cost and quality of one way.
struct Found {
    ms: f64,
    psnr: f64,
    jod: f64,
}

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Quality against time",
        &[
            "Every way to make frames cheaper, at several settings, over frames 9 to 16 of a fly-through: sparse frames and light \
           ratios, filled by several methods; every pixel of smaller frames, enlarged bicubically; every pixel with longer \
           steps; every pixel of frames of several sizes with shadows from a cache, which is made once or, as where the light moves, for every frame. Up and left is better. Quality is against every pixel at the step of ½ with shadow rays, JOD of FovVideoVDP for 30 frames a second on standard_4k.",
            methods::LEGEND,
            "Sparse frames are sampled densely where the eye looks; PSNR and the JOD here do not know that, and count the whole \
           screen alike. To enlarge a frame is not counted, but for the planner, which counts its measurements, too. Its frames are compared with the best other way that takes no longer.",
        ],
    );
    let data = evaluation.shown("head");
    let opened = data.open()?;
    let mut base = Pipeline::new(&opened, &evaluation.settings(data, SPARSE), &evaluation.speed)?;
    let mut references = Vec::new();
    for frame in 0..CLIP {
        interrupt::check("this figure is not complete")?;
        references.push(base.reference(frame)?);
    }
    let mut ways = ways(evaluation, data)?;
    let mut found = Vec::new();
    for way in &ways {
        found.push(run(evaluation, &opened, way, &references)?);
    }
    let exact = RenderSettings { sampling: Sampling::Full, ..evaluation.settings(data, SPARSE) };
    let slowest = run_fixed(evaluation, &opened, (&exact, Finish::Nothing), &references)?.ms;
    for part in BUDGETS {
        let budget = slowest * part;
        let way = Way {
            family: PLANNER,
            name: format!("{budget:.0} ms"),
            settings: METHODS[methods::RATIO].settings(evaluation.settings(data, SPARSE)),
            finish: Finish::Planned(budget),
        };
        found.push(run(evaluation, &opened, &way, &references)?);
        ways.push(way);
    }
    type Of = fn(&Found) -> f64;
    let measures: [(&str, &str, Of); 2] = [("psnr", "PSNR, dB", |f| f.psnr), ("jod", "JOD", |f| f.jod)];
    for (name, unit, of) in measures {
        let lines = lines(&ways, &found, of);
        let axes = Axes { x: "ms a frame", y: unit };
        section.drawing(
            name,
            &format!("{}: {unit} against time", data.name),
            plot::lines(axes, &lines, false, &[])?,
        );
    }
    let row = |(way, found): (&Way, &Found)| -> Vec<Cell> {
        vec![
            way.family.into(),
            way.name.as_str().into(),
            found.ms.into(),
            found.psnr.into(),
            found.jod.into(),
        ]
    };
    let rows = ways.iter().zip(&found).map(row).collect();
    section.table("alternatives", &["way", "setting", "ms", "PSNR", "JOD"], rows);
    section.table(
        "planner",
        &["budget", "ms", "PSNR", "best other in that time", "its PSNR", "JOD", "its JOD"],
        against_others(&ways, &found),
    );
    Ok(section)
}

/// For every budget of the planner, the best other way that takes no longer.
fn against_others(ways: &[Way], found: &[Found]) -> Vec<Vec<Cell>> {
    let others = || ways.iter().zip(found).filter(|(way, _)| way.family != PLANNER);
    let row = |(way, planned): (&Way, &Found)| -> Vec<Cell> {
        let in_time = others().filter(|(_, other)| other.ms <= planned.ms);
        let (name, psnr, jod) = match in_time.max_by(|a, b| a.1.psnr.total_cmp(&b.1.psnr)) {
            Some((other, found)) => (format!("{} {}", other.family, other.name), found.psnr, found.jod),
            None => ("none".to_owned(), f64::NAN, f64::NAN),
        };
        vec![
            way.name.as_str().into(),
            planned.ms.into(),
            planned.psnr.into(),
            name.as_str().into(),
            psnr.into(),
            planned.jod.into(),
            jod.into(),
        ]
    };
    ways.iter().zip(found).filter(|(way, _)| way.family == PLANNER).map(row).collect()
}

/// Lines to plot, one for each family, from its cheapest setting to its dearest.
fn lines(ways: &[Way], found: &[Found], of: fn(&Found) -> f64) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (way, found) in ways.iter().zip(found) {
        let point = [found.ms, of(found)];
        match lines.iter_mut().find(|line| line.name == way.family) {
            Some(line) => line.points.push(point),
            None => lines.push(Line { name: way.family.into(), points: vec![point] }),
        }
    }
    lines.iter_mut().for_each(|line| line.points.sort_by(|a, b| a[0].total_cmp(&b[0])));
    lines
}

fn ways(evaluation: &Evaluation, data: &DataSet) -> Result<Vec<Way>> {
    let mut ways = Vec::new();
    for method in METHODS {
        for sampling in SAMPLINGS {
            let settings = method.settings(evaluation.settings(data, sampling));
            let name = format!("({}, {})", sampling[0], sampling[1]);
            ways.push(Way { family: method.name, name, settings, finish: Finish::of(method) });
        }
    }
    let full = RenderSettings { sampling: Sampling::Full, ..evaluation.settings(data, SPARSE) };
    for factor in SMALLER {
        let FrameSize { width, height } = evaluation.size;
        let size = FrameSize::new((width / factor).max(1), (height / factor).max(1))?;
        let settings = RenderSettings { size, ..full.clone() };
        ways.push(Way {
            family: "smaller frames",
            name: format!("1/{factor}"),
            settings,
            finish: Finish::Enlarge,
        });
    }
    for step in STEPS {
        let settings = RenderSettings { step, ..full.clone() };
        ways.push(Way {
            family: "longer steps",
            name: format!("step {step}"),
            settings,
            finish: Finish::Nothing,
        });
    }
    for (family, finish) in
        [("cached shadows", Finish::Enlarge), ("cached shadows, light moves", Finish::Recast)]
    {
        for part in CACHED {
            let size = FrameSize {
                width: (evaluation.size.width * part[0] / part[1]).max(1),
                height: (evaluation.size.height * part[0] / part[1]).max(1),
            };
            let settings = RenderSettings { size, shadows: ShadowMode::Cached, ..full.clone() };
            let name = format!("{}/{}", part[0], part[1]);
            ways.push(Way { family, name, settings, finish });
        }
    }
    let ratio = METHODS[methods::RATIO];
    for sampling in SAMPLINGS {
        let settings = ratio.settings(evaluation.settings(data, sampling));
        let settings = RenderSettings { guide: Guide::Cached.into(), ..settings };
        let name = format!("({}, {})", sampling[0], sampling[1]);
        ways.push(Way { family: "ratio wnet-fast, cached guide", name, settings, finish: Finish::Nothing });
    }
    Ok(ways)
}

fn run(evaluation: &Evaluation, opened: &OpenVolume, way: &Way, references: &[Frame]) -> Result<Found> {
    match way.finish {
        Finish::Planned(ms) => run_planned(evaluation, opened, (&way.settings, ms), references),
        finish => run_fixed(evaluation, opened, (&way.settings, finish), references),
    }
}

fn run_planned(
    evaluation: &Evaluation,
    opened: &OpenVolume,
    (settings, ms): (&RenderSettings, f64),
    references: &[Frame],
) -> Result<Found> {
    let asked = (settings, Freedom::ALL);
    let mut pipeline = PlannedPipeline::new(opened, asked, Limit::Time(ms), &evaluation.speed)?;
    let mut measured = Measured::new()?;
    for (number, reference) in (0..CLIP).zip(references) {
        interrupt::check("this figure is not complete")?;
        let (rendered, _) = pipeline.render(number)?;
        measured.push(number, rendered.timings.total, reference, &rendered.frame)?;
    }
    Ok(measured.found())
}

fn run_fixed(
    evaluation: &Evaluation,
    opened: &OpenVolume,
    (settings, finish): (&RenderSettings, Finish),
    references: &[Frame],
) -> Result<Found> {
    let mut pipeline = Pipeline::new(opened, settings, &evaluation.speed)?;
    if let Finish::Bilateral = finish {
        pipeline.keep_guide();
    }
    let background = settings.background.map(|value| value as f32);
    let mut measured = Measured::new()?;
    for (number, reference) in (0..CLIP).zip(references) {
        interrupt::check("this figure is not complete")?;
        let rendered = pipeline.render(number)?;
        let mut total = rendered.timings.total;
        let frame = match finish {
            Finish::Nothing | Finish::Planned(_) => rendered.frame,
            Finish::Enlarge => image::resized(&rendered.frame, evaluation.size),
            Finish::Recast => {
                total += pipeline.shadow_grid_ms();
                image::resized(&rendered.frame, evaluation.size)
            }
            Finish::Bilateral => {
                let started = Instant::now();
                let frame = methods::bilateral(&rendered, background);
                total += started.elapsed().as_secs_f64() * 1e3 - rendered.timings.reconstruct;
                frame
            }
        };
        measured.push(number, total, reference, &frame)?;
    }
    Ok(measured.found())
}

/// Times and quality of the frames that count.
struct Measured {
    ms: Vec<f64>,
    quality: ClipQuality,
    seen: FovVideoVdp,
}

impl Measured {
    fn new() -> Result<Self> {
        let seen = FovVideoVdp::video(&Display::named("standard_4k")?, FPS)?;
        Ok(Self { ms: Vec::new(), quality: ClipQuality::new().without_ms_ssim(), seen })
    }

    fn push(&mut self, number: u32, ms: f64, reference: &Frame, frame: &Frame) -> Result<()> {
        if number >= SETTLED {
            self.ms.push(ms);
            self.quality.push(reference, frame)?;
            self.seen.push(reference, frame, None)?;
        }
        Ok(())
    }

    fn found(mut self) -> Found {
        self.ms.sort_by(f64::total_cmp);
        let psnr = self.quality.summary().map_or(f64::NAN, |summary| summary.psnr);
        Found { ms: self.ms[self.ms.len() / 2], psnr, jod: self.seen.jod().unwrap_or(f64::NAN) }
    }
}
