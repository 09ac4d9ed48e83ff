//! Figure: effective compression.

use super::evaluation::{Evaluation, SPARSE};
use super::section::{Cell, Section};
use crate::bench::compact::{self, Row};
use anyhow::Result;

/// Number of repetitions of every measurement.
const REPEATS: usize = 3;
/// Rounds over all densities. One busy moment then spoils one of them.
const ROUNDS: usize = 3;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Effective compression",
        &[
            "How much faster a frame is than a full one when a share τ of its pixels is marched, without a fovea: 1/τ would be \
           ideal. Compacted lists of pixels, rejection within full frames, and positions drawn directly, of which some repeat \
           others and are lost. The paper reaches 10 at τ = 0.1 and about 25 at τ = 0.01.",
            "Figures are medians of three rounds. The spread is from the least to the most of them.",
        ],
    );
    let data = evaluation.shown("head");
    let settings = evaluation.settings(data, SPARSE);
    let opened = data.open()?;
    let rounds = (0..ROUNDS)
        .map(|_| compact::measured(&opened, &settings, &evaluation.speed, REPEATS).map(|(rows, _)| rows))
        .collect::<Result<Vec<_>>>()?;
    let middle = &rounds[middle_round(&rounds)];
    section.drawing("compression", &data.name, compact::plotted(middle)?);
    let columns =
        ["τ", "ideal", "compact", "spread", "reject", "spread", "direct", "spread", "direct loses, %"];
    let cells = middle.iter().enumerate().map(|(i, row)| {
        let mut cells: Vec<Cell> = vec![row.density.into(), (1.0 / row.density).into()];
        for of in [|row: &Row| row.compact_ms, |row: &Row| row.reject_ms, |row: &Row| row.direct_ms] {
            let faster = |round: &Vec<Row>| round[i].full_ms / of(&round[i]);
            let mut all: Vec<f64> = rounds.iter().map(faster).collect();
            all.sort_by(f64::total_cmp);
            cells.push(all[ROUNDS / 2].into());
            cells.push(format!("{:.3} to {:.3}", all[0], all[ROUNDS - 1]).into());
        }
        cells.push((100.0 * row.direct_lost).into());
        cells
    });
    section.table("compression", &columns, cells.collect());
    Ok(section)
}

/// Number of the round whose full frames took the middle time.
fn middle_round(rounds: &[Vec<Row>]) -> usize {
    let full = |round: &Vec<Row>| round.iter().map(|row| row.full_ms).sum::<f64>();
    let mut order: Vec<usize> = (0..rounds.len()).collect();
    order.sort_by(|a, b| full(&rounds[*a]).total_cmp(&full(&rounds[*b])));
    order[order.len() / 2]
}
