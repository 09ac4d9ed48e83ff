//! Beyond the paper: cost of a frame at other resolutions and of larger volumes.

use super::data_set::DataSet;
use super::evaluation::{Evaluation, FLY_THROUGH, SPARSE};
use super::methods::{warmed, with_light_ratio, with_network};
use super::plot::{self, Axes, Line};
use super::section::{Cell, Section};
use crate::interrupt;
use anyhow::Result;
use fovolnet::core::FrameSize;
use fovolnet::{OpenVolume, RenderSettings};
use std::time::Instant;

/// Factors on the width and height of the evaluation's frames: at 720p from 360p to 4K.
const SIZES: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];
/// Voxels along the sides of cubes. Cubes are left out if they are larger, relative to the frame, than 1024³ at 720p.
const SIDES: [u32; 5] = [64, 128, 256, 512, 1024];
const LARGEST: [u32; 2] = [1024, 720];
/// Number of measured frames, spread over the fly-through.
const FRAMES: u32 = 5;

/// Cost of a frame: median times in milliseconds.
struct Cost {
    full: f64,
    sparse: f64,
    network: f64,
    ratio: f64,
}

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Cost against resolution and volume size",
        &[
            "Medians of five frames of a fly-through around the procedural head: every pixel marched, and with (P_b, σ) = \
           (0.03, 0.02) and wnet-fast, which fills colours or, with a guide, light ratios. First frames of other sizes with the same volume, then cubes of other sides with the same \
           frame. The network costs what its frame has pixels, whatever the volume is.",
        ],
    );
    let FrameSize { width, height } = evaluation.size;
    let [side, rows] = LARGEST;
    let sides: Vec<u32> =
        SIDES.into_iter().filter(|&each| each * rows <= side * height.max(rows / 8)).collect();
    let middle = sides[sides.len().saturating_sub(3)];
    let data = head(middle)?;
    let opened = data.open()?;
    let scaled = |length: u32, part: f64| ((f64::from(length) * part) as u32).max(1);
    let sizes = SIZES.map(|part| FrameSize::new(scaled(width, part), scaled(height, part)));
    let sizes = sizes.into_iter().collect::<Result<Vec<_>, _>>()?;
    let costs =
        sizes.iter().map(|&size| cost(evaluation, (&data, &opened), size)).collect::<Result<Vec<_>>>()?;
    let pixels = sizes.iter().map(|size| size.pixels() as f64 / 1e6);
    let caption = format!("head of {middle}³ voxels");
    draw(&mut section, ("resolution", &caption), "million pixels", &pixels.zip(&costs).collect::<Vec<_>>())?;
    let cube = |&side: &u32| {
        let data = head(side)?;
        cost(evaluation, (&data, &data.open()?), evaluation.size)
    };
    let costs = sides.iter().map(cube).collect::<Result<Vec<_>>>()?;
    let sides = sides.iter().map(|&side| f64::from(side)).zip(&costs).collect::<Vec<_>>();
    draw(&mut section, ("volume", &format!("frames of {width}×{height}")), "voxels along each axis", &sides)?;
    Ok(section)
}

fn head(side: u32) -> Result<DataSet> {
    DataSet::parse(&format!("head:{side}"))
}

/// Measures frames of `size`.
fn cost(evaluation: &Evaluation, (data, opened): (&DataSet, &OpenVolume), size: FrameSize) -> Result<Cost> {
    let pipeline = |settings| warmed(opened, &RenderSettings { size, ..settings }, evaluation);
    let mut with_guide = pipeline(with_light_ratio(evaluation, data, SPARSE))?;
    let mut pipeline = pipeline(with_network(evaluation, data, SPARSE))?;
    let mut times: [Vec<f64>; 4] = Default::default();
    for number in 0..FRAMES {
        interrupt::check("this figure is not complete")?;
        let frame = number * FLY_THROUGH / FRAMES;
        let parts = pipeline.render(frame)?.timings;
        let ratio = with_guide.render(frame)?.timings.total;
        let started = Instant::now();
        drop(pipeline.reference(frame)?);
        let full = started.elapsed().as_secs_f64() * 1e3;
        times
            .iter_mut()
            .zip([full, parts.total, parts.reconstruct, ratio])
            .for_each(|(all, ms)| all.push(ms));
    }
    let [full, sparse, network, ratio] = times.map(|mut ms| {
        ms.sort_by(f64::total_cmp);
        ms[ms.len() / 2]
    });
    Ok(Cost { full, sparse, network, ratio })
}

/// Plots `costs` over the quantity `x`, and adds their table.
fn draw(section: &mut Section, (name, caption): (&str, &str), x: &str, costs: &[(f64, &Cost)]) -> Result<()> {
    let line = |name: &str, of: fn(&Cost) -> f64| Line {
        name: name.into(),
        points: costs.iter().map(|(at, cost)| [*at, of(cost)]).collect(),
    };
    let lines = [
        line("every pixel", |cost| cost.full),
        line("sparse and network", |cost| cost.sparse),
        line("network", |cost| cost.network),
        line("light ratio and network", |cost| cost.ratio),
    ];
    section.drawing(
        name,
        &format!("{caption}: ms a frame"),
        plot::lines(Axes { x, y: "ms" }, &lines, true, &[])?,
    );
    let row = |(at, cost): &(f64, &Cost)| {
        let Cost { full, sparse, network, ratio } = cost;
        [*at, *full, *sparse, *network, *ratio, full / sparse, full / ratio].map(Cell::from).to_vec()
    };
    let columns = [
        x,
        "every pixel ms",
        "sparse and network ms",
        "network ms",
        "light ratio ms",
        "speed-up",
        "of the light ratio",
    ];
    section.table(name, &columns, costs.iter().map(row).collect());
    Ok(())
}
