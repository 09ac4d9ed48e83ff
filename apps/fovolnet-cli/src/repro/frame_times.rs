//! Figure: times of the stages of each frame.

use super::evaluation::{Evaluation, SPARSE};
use super::methods::{in_flight, warmed, with_light_ratio, with_network};
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
    /// Whole frame with the light ratio.
    ratio: f64,
}

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Frame times along a fly-through",
        &[
            "Every frame of a fly-through three times: with every pixel marched, and with (P_b, σ) = (0.03, 0.02) and wnet-fast \
           that fills colours or, with a guide, light ratios. What marching takes depends on how much of the screen the volume covers; \
           the network takes the same time always.",
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
        line("light ratio and network", |t| t.ratio),
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
        &["frame", "full", "total", "network", "march", "mask", "light ratio"],
        rows,
    );
    let rows = vec![
        summary("every pixel", times.iter().map(|t| t.full)),
        summary("sparse and network", times.iter().map(|t| t.parts.total)),
        summary("light ratio and network", times.iter().map(|t| t.ratio)),
    ];
    let columns = ["frames", "least ms", "mean ms", "95 % below", "99 % below", "most ms", "most / least"];
    section.table(&format!("summary{suffix}"), &columns, rows);
    Ok(())
}

/// Row of the summary: times of all frames.
fn summary(name: &str, times: impl Iterator<Item = f64>) -> Vec<Cell> {
    let mut sorted: Vec<f64> = times.collect();
    sorted.sort_by(f64::total_cmp);
    let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
    let [least, most] = [percentile(&sorted, 0.0), percentile(&sorted, 1.0)];
    let numbers = [least, mean, percentile(&sorted, 0.95), percentile(&sorted, 0.99), most, most / least];
    std::iter::once(name.into()).chain(numbers.map(Cell::from)).collect()
}

/// Smallest of the `sorted` numbers that is not exceeded by the given part of them.
fn percentile(sorted: &[f64], part: f64) -> f64 {
    let place = (part * sorted.len() as f64).ceil() as usize;
    sorted[place.clamp(1, sorted.len()) - 1]
}

fn row(times: &Times) -> Vec<Cell> {
    let parts = times.parts;
    [f64::from(times.frame), times.full, parts.total, parts.reconstruct, parts.march, parts.mask, times.ratio]
        .map(Cell::from)
        .to_vec()
}

/// Renders a fly-through; returns its times and small pictures.
fn flight(evaluation: &Evaluation, data: &super::DataSet) -> Result<(Vec<Times>, Vec<Frame>)> {
    let opened = data.open()?;
    let mut pipeline = warmed(&opened, &with_network(evaluation, data, SPARSE), evaluation)?;
    let mut with_guide = warmed(&opened, &with_light_ratio(evaluation, data, SPARSE), evaluation)?;
    let (mut times, mut pictures) = (Vec::new(), Vec::new());
    let every = (evaluation.frames as usize).div_ceil(THUMBNAILS);
    let mut last = None;
    for (number, frame) in evaluation.flight().enumerate() {
        interrupt::check("this figure is not complete")?;
        let parts = in_flight(&mut pipeline, frame, last)?.timings;
        let ratio = in_flight(&mut with_guide, frame, last)?.timings.total;
        last = Some(frame);
        let started = Instant::now();
        let reference = pipeline.reference(frame)?;
        times.push(Times { frame, full: started.elapsed().as_secs_f64() * 1e3, parts, ratio });
        if number % every == 0 {
            pictures.push(smaller(&reference, 6));
        }
    }
    Ok((times, pictures))
}

#[cfg(test)]
mod tests {
    use super::percentile;

    #[test]
    fn percentiles_are_numbers_of_the_list() {
        let sorted: Vec<f64> = (1..=200).map(f64::from).collect();
        let found = [0.0, 0.5, 0.95, 0.99, 1.0].map(|part| percentile(&sorted, part));
        assert_eq!(found, [1.0, 100.0, 190.0, 198.0, 200.0]);
        assert_eq!(percentile(&[3.0], 0.95), 3.0);
    }
}
