//! Figure: times of the stages of each frame.

use super::evaluation::{Evaluation, SPARSE};
use super::methods::{in_flight, warmed, with_network};
use super::plot::{self, Axes, Line};
use super::section::{Cell, Section};
use crate::interrupt;
use crate::picture::{side_by_side, smaller};
use anyhow::Result;
use fovolnet::Timings;
use fovolnet::core::Frame;
use std::time::Instant;

/// Number of pictures above the times.
const THUMBNAILS: usize = 6;
const GAP: u32 = 4;

/// Times of one frame, in milliseconds.
struct Times {
    frame: u32,
    full: f64,
    parts: Timings,
}

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Frame times along a fly-through",
        &[
            "Every frame of a fly-through twice: with every pixel marched, and with (P_b, σ) = (0.03, 0.02) and wnet-fast. What \
           marching takes depends on how much of the screen the volume covers; the network takes the same time always.",
        ],
    );
    for (suffix, evaluation) in evaluation.on_each_device() {
        add_device(&mut section, &evaluation, suffix)?;
    }
    Ok(section)
}

/// Adds the times of one device; file names end with `suffix`.
fn add_device(section: &mut Section, evaluation: &Evaluation, suffix: &str) -> Result<()> {
    let data = evaluation.shown("vortices");
    let (times, pictures) = flight(evaluation, data)?;
    let shown: Vec<&Frame> = pictures.iter().collect();
    section.picture(
        &format!("thumbnails{suffix}"),
        &format!("{}, from the first frame to the last", data.name),
        side_by_side(&shown, GAP),
    );
    let line = |name: &str, of: fn(&Times) -> f64| Line {
        name: name.into(),
        points: times.iter().map(|t| [f64::from(t.frame), of(t)]).collect(),
    };
    let lines = [
        line("every pixel", |t| t.full),
        line("sparse and network", |t| t.parts.total),
        line("network", |t| t.parts.reconstruct),
        line("march", |t| t.parts.march),
        line("mask and compaction", |t| t.parts.mask),
    ];
    let axes = Axes { x: "frame", y: "ms" };
    section.drawing(
        &format!("frame_times{suffix}"),
        &format!("{}, ms a frame on {}", data.name, evaluation.device()),
        plot::lines(axes, &lines, true, &[])?,
    );
    let rows = times.iter().map(row).collect();
    section.data(
        &format!("frame_times{suffix}"),
        &["frame", "full", "total", "network", "march", "mask"],
        rows,
    );
    let spread = |of: fn(&Times) -> f64| {
        let (low, high) =
            times.iter().map(of).fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
        [low, times.iter().map(of).sum::<f64>() / times.len() as f64, high]
    };
    let [full, total] = [spread(|t| t.full), spread(|t| t.parts.total)];
    let summary = |name: &str, [low, mean, high]: [f64; 3]| {
        vec![name.into(), low.into(), mean.into(), high.into(), (high / low).into()]
    };
    let rows = vec![summary("every pixel", full), summary("sparse and network", total)];
    let columns = ["frames", "least ms", "mean ms", "most ms", "most / least"];
    section.table(&format!("summary{suffix}"), &columns, rows);
    Ok(())
}

fn row(times: &Times) -> Vec<Cell> {
    let parts = times.parts;
    [f64::from(times.frame), times.full, parts.total, parts.reconstruct, parts.march, parts.mask]
        .map(Cell::from)
        .to_vec()
}

/// Renders a fly-through; returns its times and small pictures.
fn flight(evaluation: &Evaluation, data: &super::DataSet) -> Result<(Vec<Times>, Vec<Frame>)> {
    let mut pipeline = warmed(&data.open()?, &with_network(evaluation, data, SPARSE), evaluation)?;
    let (mut times, mut pictures) = (Vec::new(), Vec::new());
    let every = (evaluation.frames as usize).div_ceil(THUMBNAILS);
    let mut last = None;
    for (number, frame) in evaluation.flight().enumerate() {
        interrupt::check("this figure is not complete")?;
        let parts = in_flight(&mut pipeline, frame, last)?.timings;
        last = Some(frame);
        let started = Instant::now();
        let reference = pipeline.reference(frame)?;
        times.push(Times { frame, full: started.elapsed().as_secs_f64() * 1e3, parts });
        if number % every == 0 {
            pictures.push(smaller(&reference, 6));
        }
    }
    Ok((times, pictures))
}
