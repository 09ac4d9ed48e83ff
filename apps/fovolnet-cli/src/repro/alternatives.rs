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
use fovolnet::{Guide, OpenVolume, Pipeline, RenderSettings, Sampling};
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
           screen alike. To enlarge a frame is not counted: it takes a few milliseconds where it is done well.",
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
    let ways = ways(evaluation, data)?;
    let mut found = Vec::new();
    for way in &ways {
        found.push(run(evaluation, &opened, way, &references)?);
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
    Ok(section)
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
    let mut pipeline = Pipeline::new(opened, &way.settings, &evaluation.speed)?;
    if let Finish::Bilateral = way.finish {
        pipeline.keep_guide();
    }
    let background = way.settings.background.map(|value| value as f32);
    let mut quality = ClipQuality::new().without_ms_ssim();
    let mut seen = FovVideoVdp::video(&Display::named("standard_4k")?, FPS)?;
    let mut ms = Vec::new();
    for (number, reference) in (0..CLIP).zip(references) {
        interrupt::check("this figure is not complete")?;
        let rendered = pipeline.render(number)?;
        let mut total = rendered.timings.total;
        let frame = match way.finish {
            Finish::Nothing => rendered.frame,
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
        if number >= SETTLED {
            ms.push(total);
            quality.push(reference, &frame)?;
            seen.push(reference, &frame, None)?;
        }
    }
    ms.sort_by(f64::total_cmp);
    let psnr = quality.summary().map_or(f64::NAN, |summary| summary.psnr);
    Ok(Found { ms: ms[ms.len() / 2], psnr, jod: seen.jod().unwrap_or(f64::NAN) })
}
