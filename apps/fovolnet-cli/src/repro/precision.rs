//! Figure: model precision.

use super::evaluation::{Evaluation, SPARSE};
use super::methods::{with_light_ratio, with_network};
use super::section::Section;
use crate::interrupt;
use crate::picture::{side_by_side, smaller, stacked};
use anyhow::Result;
use fovolnet::core::Frame;
use fovolnet::metrics::ClipQuality;
use fovolnet::{OpenVolume, Pipeline, RenderSettings};

const PRECISIONS: [&str; 4] = ["f32", "bf16", "mixed", "int8"];
/// Number of frames over which quality is measured.
const FRAMES: u32 = 16;
const GAP: u32 = 4;
/// Factor by which differences are amplified.
const ENLARGED: f32 = 8.0;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Model precision",
        &[
            "wnet-fast with its numbers stored and multiplied as f32, bf16, bytes in some layers (mixed) or in most of them (int8); \
           on this processor a precision that it cannot multiply faster becomes the next more exact one. Above the last frame, \
           below 8 times its difference from f32. PSNR is against the full frames, over 16 frames of a fly-through. \
           `ratio` is the same network filling light ratios with a guide.",
        ],
    );
    let data = evaluation.shown("head");
    let opened = data.open()?;
    let [colours, ratios] = [with_network, with_light_ratio].map(|of| of(evaluation, data, SPARSE));
    let runs = |settings: &RenderSettings| -> Result<Vec<Run>> {
        PRECISIONS.iter().map(|precision| run(evaluation, settings, &opened, precision)).collect()
    };
    let (runs, ratios) = (runs(&colours)?, runs(&ratios)?);
    let exact = &runs[0].last;
    let frames: Vec<&Frame> = runs.iter().map(|run| &run.last).collect();
    let differences: Vec<Frame> = frames.iter().map(|frame| difference(exact, frame)).collect();
    let differences: Vec<&Frame> = differences.iter().collect();
    let sheet = stacked(&[side_by_side(&frames, GAP), side_by_side(&differences, GAP)], GAP);
    let caption = format!("{}: {}", data.name, PRECISIONS.join(", "));
    section.picture("precision", &caption, smaller(&sheet, 2));
    let rows = PRECISIONS.iter().zip(runs.iter().zip(&ratios)).map(|(precision, (run, ratio))| {
        let of_ratio = [ratio.psnr.into(), ratio.ssim.into()];
        let row = [(*precision).into(), run.psnr.into(), run.ssim.into(), run.ms.into()];
        row.into_iter().chain(of_ratio).collect()
    });
    let columns = ["precision", "PSNR", "SSIM", "network ms", "ratio PSNR", "ratio SSIM"];
    section.table("precision", &columns, rows.collect());
    Ok(section)
}

struct Run {
    last: Frame,
    psnr: f64,
    ssim: Option<f64>,
    /// Shortest time of the network in milliseconds.
    ms: f64,
}

fn run(
    evaluation: &Evaluation,
    settings: &RenderSettings,
    opened: &OpenVolume,
    precision: &str,
) -> Result<Run> {
    let settings =
        RenderSettings { precision: precision.parse().map_err(anyhow::Error::msg)?, ..settings.clone() };
    let mut pipeline = Pipeline::new(opened, &settings, &evaluation.speed)?;
    let mut quality = ClipQuality::new().without_ms_ssim();
    let (mut last, mut ms) = (Frame::new(evaluation.size), f64::INFINITY);
    for frame in 0..FRAMES {
        interrupt::check("this figure is not complete")?;
        let rendered = pipeline.render(frame)?;
        quality.push(&pipeline.reference(frame)?, &rendered.frame)?;
        ms = ms.min(rendered.timings.reconstruct);
        last = rendered.frame;
    }
    let summary = quality.summary();
    let psnr = summary.as_ref().map_or(f64::NAN, |summary| summary.psnr);
    Ok(Run { last, psnr, ssim: summary.and_then(|summary| summary.ssim), ms })
}

fn difference(a: &Frame, b: &Frame) -> Frame {
    let mut out = Frame::new(a.size());
    for (to, (a, b)) in out.pixels_mut().iter_mut().zip(a.pixels().iter().zip(b.pixels())) {
        let enlarged = |c: usize| (ENLARGED * (a[c] - b[c]).abs()).min(1.0);
        *to = [enlarged(0), enlarged(1), enlarged(2), 1.0];
    }
    out
}
