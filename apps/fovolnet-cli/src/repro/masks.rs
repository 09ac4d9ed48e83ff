//! Figure: sampling masks.

use super::evaluation::{DENSE, Evaluation, SPARSE};
use super::section::Section;
use crate::picture::{grey, side_by_side};
use anyhow::Result;
use fovolnet::Pipeline;
use fovolnet::render::cpu::mask;
use fovolnet::render::noise::{Noise, NoiseKind};

const GAP: u32 = 6;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Sampling masks",
        &[
            "Where rays are marched: noise below a density that falls from 1 at the gaze to P_b, with a standard deviation of σ \
           image widths. Left the density, in the middle the mask, right what is sampled.",
        ],
    );
    let data = evaluation.shown("head");
    let opened = data.open()?;
    let mut rows = Vec::new();
    for (name, sampling) in [("sparse", SPARSE), ("dense", DENSE)] {
        let mut pipeline = Pipeline::new(&opened, &evaluation.settings(data, sampling), &evaluation.speed)?;
        let rendered = pipeline.render(0)?;
        let fovea = pipeline.fovea(0);
        let density = grey(evaluation.size, |x, y| fovea.density_at(x, y, evaluation.size) as f32);
        let mask = mask(&fovea, evaluation.size, &Noise::new(NoiseKind::Stbn, 0), 0);
        let chosen = grey(evaluation.size, |x, y| f32::from(u8::from(mask.contains(x, y))));
        let caption = format!("{}, (P_b, σ) = ({}, {})", data.name, sampling[0], sampling[1]);
        section.picture(name, &caption, side_by_side(&[&density, &chosen, &rendered.samples_picture()], GAP));
        rows.push(vec![
            sampling[0].to_string().into(),
            sampling[1].to_string().into(),
            (rendered.samples as f64).into(),
            rendered.mask.density().into(),
            fovea.expected_density(evaluation.size).into(),
            (1.0 / rendered.mask.density()).into(),
        ]);
    }
    let columns = ["P_b", "σ", "samples", "density", "expected density", "compression"];
    section.table("masks", &columns, rows);
    Ok(section)
}
