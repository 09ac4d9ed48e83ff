//! Table: just-objectionable differences.

use super::data_set::DataSet;
use super::evaluation::{Evaluation, SPARSE};
use super::methods::{self, COUNT, Comparison};
use super::section::{Cell, Section};
use crate::interrupt;
use anyhow::Result;
use fovolnet::Pipeline;
use fovolnet::core::Frame;
use fovolnet::metrics::{Display, FovVideoVdp};

/// Consecutive frames of the clip, and the frames per second at which it is shown.
const CLIP: u32 = 50;
const FPS: f64 = 30.0;
const INCOMPLETE: &str = "this table is not complete";

/// Rows of the paper's table: density, FoVolNet, DeepFovea.
const PAPER: [[f64; 3]; 4] = [[0.10, 9.35, 8.53], [0.07, 9.28, 8.47], [0.03, 8.86, 8.21], [0.01, 8.26, 7.51]];

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Just-objectionable differences",
        &[
            "JOD of FovVideoVDP 1.2 for clips of a fly-through, 30 frames a second on the display standard_4k, not foveated: 10 is \
           no difference, 9 one that three of four people see. Sampled at the same density everywhere (σ = 0).",
            "The paper's figures are of the chameleon, with another version of the metric; the metric sees the whole screen, so \
           that volumes which cover little of it get higher values.",
            methods::LEGEND,
        ],
    );
    let found =
        evaluation.data_sets.iter().map(|data| clips(evaluation, data)).collect::<Result<Vec<_>>>()?;
    let count = evaluation.data_sets.len() as f64;
    let mut rows = Vec::new();
    for (number, [density, fovolnet, deepfovea]) in PAPER.into_iter().enumerate() {
        let row = |name: &str, values: [f64; COUNT], paper: [Cell; 2]| {
            let named = [density.to_string().into(), name.into()];
            named.into_iter().chain(values.map(Cell::from)).chain(paper).collect::<Vec<_>>()
        };
        let mut means = [0.0; COUNT];
        for (data, found) in evaluation.data_sets.iter().zip(&found) {
            rows.push(row(&data.name, found[number], [(); 2].map(|()| "".into())));
            (0..COUNT).for_each(|method| means[method] += found[number][method] / count);
        }
        rows.push(row("mean", means, [fovolnet, deepfovea].map(Cell::from)));
    }
    let columns =
        [&["τ", "data set"], &methods::names()[..], &["paper: FoVolNet", "paper: DeepFovea"]].concat();
    section.table("jod", &columns, rows);
    Ok(section)
}

/// JOD of each method at each density of the paper.
fn clips(evaluation: &Evaluation, data: &DataSet) -> Result<[[f64; COUNT]; 4]> {
    let opened = data.open()?;
    let mut full = Pipeline::new(&opened, &evaluation.settings(data, SPARSE), &evaluation.speed)?;
    let mut references = Vec::new();
    for number in 0..CLIP.min(evaluation.frames) {
        interrupt::check(INCOMPLETE)?;
        references.push(full.reference(number)?);
    }
    let mut found = [[0.0; COUNT]; 4];
    for (found, [density, ..]) in found.iter_mut().zip(PAPER) {
        let settings = evaluation.settings(data, [density, 0.0]);
        *found = clip(Comparison::new(&opened, &settings, &evaluation.speed)?, &references)?;
    }
    Ok(found)
}

/// JOD of each method for a clip with the given `references`.
fn clip(mut comparison: Comparison, references: &[Frame]) -> Result<[f64; COUNT]> {
    let display = Display::named("standard_4k")?;
    let mut seen: Vec<FovVideoVdp> =
        (0..COUNT).map(|_| FovVideoVdp::video(&display, FPS)).collect::<Result<_, _>>()?;
    for (number, reference) in (0..).zip(references) {
        interrupt::check(INCOMPLETE)?;
        let made = comparison.render(number)?.frames;
        for (metric, frame) in seen.iter_mut().zip(&made) {
            metric.push(reference, frame, None)?;
        }
    }
    Ok(std::array::from_fn(|method| seen[method].jod().unwrap_or(f64::NAN)))
}
