//! Figure: average frame times. Table: relative speed-ups.

use super::data_set::DataSet;
use super::evaluation::{DENSE, Evaluation, SPARSE};
use super::methods::{in_flight, network_kind, warmed};
use super::plot::{self, Bars};
use super::section::{Cell, Section};
use super::vtk;
use crate::interrupt;
use anyhow::Result;
use fovolnet::{Density, Guide, Pipeline, RandomWeights, RenderSettings, WeightsChoice};
use std::time::Instant;

/// Measured networks. Their weights are random, since weights do not change the speed.
///
/// Those that begin with [`RATIO`] fill light ratios.
const NETWORKS: [&str; 4] = ["wnet-fast", "wnet-paper", "deepfovea-fvn", "ratio wnet-fast"];
const RATIO: &str = "ratio ";

/// Rows of the paper's table: data set, FoVolNet sparse and dense, DeepFovea sparse and dense.
const PAPER: [(&str, [f64; 4]); 7] = [
    ("vortices 1", [3.21, 2.40, 2.42, 1.98]),
    ("vortices 2", [3.80, 2.89, 2.88, 2.34]),
    ("skull", [3.12, 2.19, 2.45, 1.88]),
    ("mechanical hand", [2.66, 1.74, 2.23, 1.55]),
    ("chameleon", [3.22, 2.45, 3.05, 1.73]),
    ("supernova", [3.67, 2.09, 3.44, 2.08]),
    ("overall", [3.28, 2.29, 2.75, 1.93]),
];

/// Mean times for one data set, in milliseconds.
struct Average {
    name: String,
    full: f64,
    /// Times of the whole frame and of the network alone, for each network and setting.
    sparse: Vec<[f64; 2]>,
}

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Average frame times and speed-ups",
        &[
            "Fly-throughs with shadows; times are means over all their frames. The dark part of a bar is the network. Full frames \
           are this program's own; benchmarks/peers/vtk_march.py compares them with VTK, and --vtk FILE shows here what it found.",
            "Speed-ups are full frames against sparse ones with the network. The paper's were taken on a GPU with its own \
           renderer and volumes: the ratios can be compared, not the times.",
        ],
    );
    for (suffix, evaluation) in evaluation.on_each_device() {
        add_device(&mut section, &evaluation, suffix)?;
    }
    let row = |&(name, speedups): &(&str, [f64; 4])| {
        std::iter::once(name.into()).chain(speedups.map(Cell::from)).collect()
    };
    let columns = [
        "paper",
        "FoVolNet (0.03, 0.02)",
        "FoVolNet (0.07, 0.06)",
        "DeepFovea (0.03, 0.02)",
        "DeepFovea (0.07, 0.06)",
    ];
    section.table("speedups_paper", &columns, PAPER.iter().map(row).collect());
    if let Some(file) = &evaluation.vtk {
        vtk::add(&mut section, file)?;
    }
    Ok(section)
}

/// Adds the times of one device; file names end with `suffix`.
fn add_device(section: &mut Section, evaluation: &Evaluation, suffix: &str) -> Result<()> {
    let all =
        evaluation.data_sets.iter().map(|data| average(evaluation, data)).collect::<Result<Vec<_>>>()?;
    let names: Vec<String> = all.iter().map(|average| average.name.clone()).collect();
    let mut series =
        vec![Bars { name: "every pixel".into(), heights: all.iter().map(|a| [a.full; 2]).collect() }];
    let titles: Vec<String> =
        columns().map(|(network, [pb, sigma])| format!("{network} ({pb}, {sigma})")).collect();
    series.extend(titles.iter().enumerate().map(|(number, title)| Bars {
        name: title.clone(),
        heights: all.iter().map(|average| average.sparse[number]).collect(),
    }));
    let caption = format!("ms a frame on {}", evaluation.device());
    let bars = plot::bars("ms a frame", &names, &series)?;
    section.drawing(&format!("frame_times{suffix}"), &caption, bars);
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let columns = [&["data set", "full ms"], &titles[..]].concat();
    section.table(&format!("speedups{suffix}"), &columns, speedups(&all));
    Ok(())
}

/// All pairs of network and setting.
fn columns() -> impl Iterator<Item = (&'static str, [f64; 2])> {
    NETWORKS.into_iter().flat_map(|network| [SPARSE, DENSE].map(|setting| (network, setting)))
}

fn speedups(all: &[Average]) -> Vec<Vec<Cell>> {
    let ratios =
        |average: &Average| average.sparse.iter().map(|[total, _]| average.full / total).collect::<Vec<_>>();
    let mut rows: Vec<Vec<Cell>> = all
        .iter()
        .map(|average| {
            let own = [average.name.as_str().into(), average.full.into()];
            own.into_iter().chain(ratios(average).into_iter().map(Cell::from)).collect()
        })
        .collect();
    let mean =
        |number: usize| all.iter().map(|average| ratios(average)[number]).sum::<f64>() / all.len() as f64;
    let full = all.iter().map(|average| average.full).sum::<f64>() / all.len() as f64;
    let means = (0..columns().count()).map(|number| Cell::from(mean(number)));
    rows.push(["overall".into(), full.into()].into_iter().chain(means).collect());
    rows
}

fn average(evaluation: &Evaluation, data: &DataSet) -> Result<Average> {
    let opened = data.open()?;
    let mut full = Pipeline::new(&opened, &evaluation.settings(data, SPARSE), &evaluation.speed)?;
    let mut sparse = Vec::new();
    for (network, setting) in columns() {
        sparse.push((settings(evaluation, data, network, setting)?, [0.0; 2]));
    }
    let mut pipelines = sparse
        .iter()
        .map(|(settings, _)| warmed(&opened, settings, evaluation))
        .collect::<Result<Vec<_>>>()?;
    let mut full_ms = 0.0;
    let share = 1.0 / f64::from(evaluation.frames);
    let mut last = None;
    for frame in evaluation.flight() {
        interrupt::check("this figure is not complete")?;
        let started = Instant::now();
        drop(full.reference(frame)?);
        full_ms += started.elapsed().as_secs_f64() * 1e3 * share;
        for (pipeline, (_, sums)) in pipelines.iter_mut().zip(&mut sparse) {
            let times = in_flight(pipeline, frame, last)?.timings;
            sums[0] += times.total * share;
            sums[1] += times.reconstruct * share;
        }
        last = Some(frame);
    }
    let sparse = sparse.into_iter().map(|(_, times)| times).collect();
    Ok(Average { name: data.name.clone(), full: full_ms, sparse })
}

fn settings(
    evaluation: &Evaluation,
    data: &DataSet,
    network: &str,
    setting: [f64; 2],
) -> Result<RenderSettings> {
    let ratio = network.strip_prefix(RATIO);
    let network = ratio.unwrap_or(network);
    let weights: RandomWeights = network.parse().map_err(anyhow::Error::msg)?;
    let (guide, density) = match ratio {
        Some(_) => (Guide::Quarter, Density::Adaptive),
        None => (Guide::None, Density::Fixed),
    };
    Ok(RenderSettings {
        guide: guide.into(),
        density: density.into(),
        reconstruction: network_kind(network),
        weights: WeightsChoice::Random(weights),
        ..evaluation.settings(data, setting)
    })
}
