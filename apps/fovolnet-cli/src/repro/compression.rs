//! Figure: effective compression.

use super::evaluation::{Evaluation, SPARSE};
use super::section::Section;
use crate::bench::compact;
use anyhow::Result;

/// Number of repetitions of every measurement.
const REPEATS: usize = 5;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Effective compression",
        &[
            "How much faster a frame is than a full one when a share τ of its pixels is marched, without a fovea: 1/τ would be \
           ideal. Compacted lists of pixels, rejection within full frames, and positions drawn directly, of which some repeat \
           others and are lost. The paper reaches 10 at τ = 0.1 and about 25 at τ = 0.01.",
        ],
    );
    let data = evaluation.shown("head");
    let settings = evaluation.settings(data, SPARSE);
    let (rows, _) = compact::measured(&data.open()?, &settings, &evaluation.speed, REPEATS)?;
    section.drawing("compression", &data.name, compact::plotted(&rows)?);
    let columns = ["τ", "ideal", "compact", "reject", "direct", "direct loses, %"];
    let cells = rows.iter().map(|row| {
        let faster = [row.compact_ms, row.reject_ms, row.direct_ms].map(|ms| row.full_ms / ms);
        let [compact, reject, direct] = faster;
        [row.density, 1.0 / row.density, compact, reject, direct, 100.0 * row.direct_lost]
            .map(Into::into)
            .to_vec()
    });
    section.table("compression", &columns, cells.collect());
    Ok(section)
}
