//! Beyond the paper: cost and quality of every honest way to make a frame cheaper.

mod clip;
mod way;

use super::data_set::DataSet;
use super::evaluation::Evaluation;
use super::methods;
use super::plot::{self, Axes, Line};
use super::section::{Cell, Section};
use anyhow::Result;
use clip::{Clip, Found};
use fovolnet::OpenVolume;
use way::{PLANNER, Way};

/// A measure of frames: name, unit, and its value.
type Measure = (&'static str, &'static str, fn(&Found) -> f64);

const MEASURES: [Measure; 3] = [
    ("psnr", "PSNR, dB", |found| found.psnr),
    ("jod", "JOD", |found| found.jod),
    ("colour_jod", "JOD in colour", |found| found.colour_jod),
];

/// Ways with what was found of them.
type Measured = Vec<(Way, Found)>;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Quality against time",
        &[
            "Every way to make frames cheaper, at five settings each, over frames 9 to 16 of a fly-through: sparse frames and \
             light ratios, filled by several methods; every pixel of smaller frames, enlarged bicubically; every pixel with \
             longer steps; every pixel with cached shadows, at several sizes and steps. Up and left is better. Quality is \
             against every pixel at the step of ½ with shadow rays. JOD is FovVideoVDP's, JOD in colour is ColorVideoVDP's, \
             both for 30 frames a second on standard_4k. Ways that take longer than exact full frames are left out.",
            "Everything is measured twice: with light at rest, and with light that turns by 3 degrees a frame. What has to be \
             made anew for another light counts as part of the frame.",
            methods::LEGEND,
            "Sparse frames are sampled densely where the eye looks; PSNR and both JOD do not know that, and count the whole \
             screen alike. Times count all that makes a frame, its enlarging and the planner's measurements too. Each of the \
             planner's budgets is compared with the best other way that takes no longer.",
        ],
    );
    let data = evaluation.shown("head");
    let opened = data.open()?;
    for (suffix, light, moves) in [("", "light at rest", false), ("_moving", "moving light", true)] {
        let measured = measured(evaluation, data, &opened, moves)?;
        for (name, unit, of) in MEASURES {
            let axes = Axes { x: "ms a frame", y: unit };
            let caption = format!("{}, {light}: {unit} against time", data.name);
            let lines = lines(&measured, of);
            section.drawing(&format!("{name}{suffix}"), &caption, plot::lines(axes, &lines, false, &[])?);
        }
        let columns = ["way", "setting", "ms", "PSNR", "JOD", "JOD in colour"];
        section.table(&format!("alternatives{suffix}"), &columns, rows(&measured));
        let columns =
            ["budget", "ms", "measure", "planner", "best other in that time", "its value", "its ms"];
        section.table(&format!("planner{suffix}"), &columns, against_others(&measured));
    }
    Ok(section)
}

/// Every way with what was found of it, where light rests or `moves`.
fn measured(evaluation: &Evaluation, data: &DataSet, opened: &OpenVolume, moves: bool) -> Result<Measured> {
    let exact = way::exact(evaluation, data, moves);
    let clip = Clip::new(evaluation, opened, &exact)?;
    let full_ms = clip.run(&exact, f64::INFINITY)?.map_or(f64::INFINITY, |found| found.ms);
    let mut ways = way::ways(evaluation, data, moves)?;
    ways.extend(way::planned(evaluation, data, moves, full_ms));
    let mut measured = Vec::new();
    for way in ways {
        if let Some(found) = clip.run(&way, full_ms)? {
            measured.push((way, found));
        }
    }
    Ok(measured)
}

fn rows(measured: &Measured) -> Vec<Vec<Cell>> {
    let row = |(way, found): &(Way, Found)| -> Vec<Cell> {
        let named: [Cell; 2] = [way.family.into(), way.name.as_str().into()];
        let values = [found.ms, found.psnr, found.jod, found.colour_jod];
        named.into_iter().chain(values.map(Cell::from)).collect()
    };
    measured.iter().map(row).collect()
}

/// For every budget of the planner and every measure, the best other way that takes no longer.
fn against_others(measured: &Measured) -> Vec<Vec<Cell>> {
    let (planned, others): (Vec<_>, Vec<_>) = measured.iter().partition(|(way, _)| way.family == PLANNER);
    let mut rows = Vec::new();
    for (way, found) in planned {
        for (_, unit, of) in MEASURES {
            let in_time = others.iter().filter(|(_, other)| other.ms <= found.ms);
            let (name, value, ms) = match in_time.max_by(|a, b| of(&a.1).total_cmp(&of(&b.1))) {
                Some((other, best)) => (format!("{} {}", other.family, other.name), of(best), best.ms),
                None => ("none".to_owned(), f64::NAN, f64::NAN),
            };
            let mut row: Vec<Cell> = vec![way.name.as_str().into(), found.ms.into(), unit.into()];
            row.extend([of(found).into(), name.as_str().into(), value.into(), ms.into()]);
            rows.push(row);
        }
    }
    rows
}

/// Lines to plot, one for each family, from its cheapest setting to its dearest.
fn lines(measured: &Measured, of: fn(&Found) -> f64) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (way, found) in measured {
        let point = [found.ms, of(found)];
        match lines.iter_mut().find(|line| line.name == way.family) {
            Some(line) => line.points.push(point),
            None => lines.push(Line { name: way.family.into(), points: vec![point] }),
        }
    }
    lines.iter_mut().for_each(|line| line.points.sort_by(|a, b| a[0].total_cmp(&b[0])));
    lines
}
