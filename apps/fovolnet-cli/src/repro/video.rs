//! The supplemental video: fly-throughs with all methods side by side.

use super::data_set::DataSet;
use super::evaluation::{Evaluation, SPARSE};
use super::methods::{Compared, Comparison};
use super::section::Section;
use crate::interrupt;
use crate::picture::{side_by_side, stacked};
use anyhow::Result;
use fovolnet::core::{Frame, FrameSize};
use fovolnet::io::atomic;
use fovolnet::io::video::{self, VideoWriter};
use std::path::Path;

/// Frames per second.
const RATE: u32 = 25;
/// Pixels between the pictures.
const GAP: u32 = 4;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Fly-throughs side by side",
        &[
            "The supplemental video: every frame of the fly-through of each data set at (P_b, σ) = (0.03, 0.02). Above: every \
           pixel marched, the samples, and linear interpolation of them. In the middle: deepfovea-fvn, wnet-paper, and wnet-fast. \
           Below: the light ratio, filled by the joint bilateral filter, by wnet-paper, and by wnet-fast.",
        ],
    );
    let folder = evaluation.output.join("video");
    atomic::make_folder(&folder)?;
    for data in &evaluation.data_sets {
        let (name, still) = film(evaluation, data, &folder)?;
        section.picture(&data.name, &format!("{}: the frame in the middle", data.name), still);
        section.film(&name, &format!("{}: the whole, {RATE} frames a second", data.name));
    }
    Ok(section)
}

/// Writes the fly-through of `data` to `folder`. Returns the name of the file and the middle frame.
fn film(evaluation: &Evaluation, data: &DataSet, folder: &Path) -> Result<(String, Frame)> {
    let settings = evaluation.settings(data, SPARSE);
    let mut comparison = Comparison::new(&data.open()?, &settings, &evaluation.speed)?;
    let FrameSize { width, height } = evaluation.size;
    let whole = FrameSize::new(3 * width + 2 * GAP, 3 * height + 2 * GAP)?;
    let file = folder.join(format!("{}.{}", data.name, video::best_extension()));
    let mut film = VideoWriter::create(&file, whole, RATE)?;
    let mut middle = None;
    // Render every frame: skipped frames would be motion that the viewer does not see.
    for number in 0..evaluation.frames {
        interrupt::check("this film is not complete")?;
        let shown = sheet(&mut comparison, number)?;
        film.push(&shown)?;
        if number == evaluation.frames / 2 {
            middle = Some(shown);
        }
    }
    let path = film.finish()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((name, middle.expect("fly-throughs have two frames or more")))
}

/// Arranges one frame: full, samples and linear interpolation above, then networks that fill colours, then light ratios.
fn sheet(comparison: &mut Comparison, number: u32) -> Result<Frame> {
    let reference = comparison.reference(number)?;
    let Compared { sparse, frames } = comparison.render(number)?;
    let [_, linear, own, paper, deepfovea, own_ratio, paper_ratio, _, bilateral] = &frames;
    let rows = [[&reference, &sparse, linear], [deepfovea, paper, own], [bilateral, paper_ratio, own_ratio]];
    Ok(stacked(&rows.map(|row| side_by_side(&row, GAP)), GAP))
}
