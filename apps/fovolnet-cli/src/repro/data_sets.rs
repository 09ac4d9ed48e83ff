//! Table of the volumes of the evaluation.

use super::data_set::DataSet;
use super::evaluation::Evaluation;
use super::section::{Cell, Section};
use anyhow::Result;

/// The paper's Table 1.
const PAPER: [[&str; 3]; 6] = [
    ["skull", "256×256×256", "u8"],
    ["chameleon", "1024×1024×1080", "u8"],
    ["mechanical hand", "640×220×229", "f32"],
    ["vortices 1", "128×128×128", "f32"],
    ["vortices 2", "128×128×128", "f32"],
    ["supernova", "432×432×432", "f32"],
];

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Data sets",
        &[
            "The volumes of this evaluation. Procedural ones are made by the program and stand for what the paper used and \
           what cannot be had; their names say what they resemble. The second table is the paper's.",
        ],
    );
    let row = |data: &DataSet| -> Result<Vec<Cell>> {
        let opened = data.open()?;
        let volume = &opened.volume;
        let [x, y, z] = volume.grid().dims();
        let origin = if opened.procedural.is_some() { "procedural" } else { "file" };
        Ok(vec![
            data.name.as_str().into(),
            format!("{x}×{y}×{z}").into(),
            volume.dtype().to_string().into(),
            data.transfer.to_string().into(),
            origin.into(),
        ])
    };
    let rows = evaluation.data_sets.iter().map(row).collect::<Result<_>>()?;
    section.table("data_sets", &["data set", "voxels", "type", "transfer function", "origin"], rows);
    let rows = PAPER.iter().map(|row| row.map(Cell::from).to_vec()).collect();
    section.table("data_sets_paper", &["paper's data set", "voxels", "type"], rows);
    Ok(section)
}
