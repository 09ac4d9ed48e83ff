//! Table: just-objectionable differences.

use super::section::{Cell, Section};
use super::{DataSet, Evaluation};
use crate::interrupt;
use anyhow::Result;
use fovolnet::metrics::{Display, FovVideoVdp};
use fovolnet::net::Fill;
use fovolnet::{OpenVolume, Pipeline};

const METHODS: [&str; 3] = ["pull-push", "linear", "wnet-fast"];
/// Frames of the clip, which follow one another, and how many of them are shown a second.
const CLIP: u32 = 50;
const FPS: f64 = 30.0;

/// The paper's table: density, FoVolNet, DeepFovea.
const PAPER: [[f64; 3]; 4] = [[0.10, 9.35, 8.53], [0.07, 9.28, 8.47], [0.03, 8.86, 8.21], [0.01, 8.26, 7.51]];

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Just-objectionable differences",
        &[
            "JOD of FovVideoVDP 1.2 for clips of a fly-through, 30 frames a second on the display standard_4k, not foveated: 10 is \
           no difference, 9 one that three of four people see. Sampled at the same density everywhere (σ = 0).",
            "The paper's figures are of the chameleon, with another version of the metric; the metric sees the whole screen, so \
           that volumes which cover little of it get higher values.",
        ],
    );
    let mut rows = Vec::new();
    for [density, fovolnet, deepfovea] in PAPER {
        let mut sums = [0.0; 3];
        for data in &evaluation.data_sets {
            let found = clip(evaluation, data, &data.open()?, density)?;
            let named = [density.to_string().into(), data.name.as_str().into()];
            rows.push(
                named.into_iter().chain(found.map(Cell::from)).chain([(); 2].map(|()| "".into())).collect(),
            );
            (0..3).for_each(|method| sums[method] += found[method] / evaluation.data_sets.len() as f64);
        }
        let named = [density.to_string().into(), "mean".into()];
        rows.push(
            named
                .into_iter()
                .chain([sums[0], sums[1], sums[2], fovolnet, deepfovea].map(Cell::from))
                .collect(),
        );
    }
    let columns = [&["τ", "data set"], &METHODS[..], &["paper: FoVolNet", "paper: DeepFovea"]].concat();
    section.table("jod", &columns, rows);
    Ok(section)
}

/// The JOD of each method.
fn clip(evaluation: &Evaluation, data: &DataSet, opened: &OpenVolume, density: f64) -> Result<[f64; 3]> {
    let mut settings = evaluation.settings(data, [density, 0.0]);
    settings.reconstruct = Some("wnet".parse().map_err(anyhow::Error::msg)?);
    let mut pipeline = Pipeline::new(opened, &settings, &evaluation.speed)?;
    let display = Display::named("standard_4k")?;
    let mut seen: Vec<FovVideoVdp> =
        METHODS.iter().map(|_| FovVideoVdp::video(&display, FPS)).collect::<Result<_, _>>()?;
    for number in 0..CLIP.min(evaluation.frames) {
        interrupt::check("this table is not complete")?;
        let rendered = pipeline.render(number)?;
        let reference = pipeline.reference(number);
        let sparse = &rendered.sparse;
        let made = [Fill::PullPush.reconstruct(sparse), Fill::Linear.reconstruct(sparse), rendered.frame];
        for (metric, frame) in seen.iter_mut().zip(&made) {
            metric.push(&reference, frame, None)?;
        }
    }
    Ok([0, 1, 2].map(|method: usize| seen[method].jod().unwrap_or(f64::NAN)))
}
