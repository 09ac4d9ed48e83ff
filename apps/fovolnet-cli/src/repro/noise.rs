//! Figure: noise patterns.

use super::plot::{self, Axes, Line};
use super::section::Section;
use crate::picture::{grey, larger, side_by_side, stacked};
use anyhow::Result;
use fovolnet::core::{Frame, FrameSize};
use fovolnet::render::noise::{Noise, NoiseKind, NoiseSize, statistics};

/// Kinds of noise in the paper's figure.
const KINDS: [NoiseKind; 3] = [NoiseKind::Uniform, NoiseKind::Blue, NoiseKind::Stbn];
/// Number of averaged frames.
const AVERAGED: u32 = 8;
/// Screen pixels along each axis for one pixel of the pattern.
const SCALE: u32 = 2;
const GAP: u32 = 6;

pub fn section() -> Result<Section> {
    let mut section = Section::new(
        "Noise patterns",
        &[
            "Uniform, blue and spatio-temporal blue noise (STBN): one frame above, the mean of eight frames below. The mean \
           of uniform and of blue noise stays uneven, as their frames know nothing of each other; that of STBN is flatter, \
           so that samples of few frames cover the screen.",
            "The spectra say the same: power 1 is white noise. Blue noise has little at low frequencies in space, STBN in \
           time too. The paper uses the STBN of Wolfe et al.; this program carries its own.",
        ],
    );
    let tiles = |of: fn(&Noise) -> Frame| KINDS.map(|kind| of(&Noise::new(kind, 0)));
    let row = |frames: [Frame; 3]| side_by_side(&frames.each_ref(), GAP);
    let picture =
        stacked(&[row(tiles(|noise| mean(noise, 1))), row(tiles(|noise| mean(noise, AVERAGED)))], GAP);
    section.picture("noise", "uniform, blue, STBN; above one frame, below the mean of eight", picture);
    let spectra = KINDS.map(|kind| (kind.to_string(), statistics::spectra(&values(kind), NoiseSize::STBN)));
    type Of = fn(&statistics::Spectra) -> &Vec<[f64; 2]>;
    let domains: [(&str, &str, Of); 2] =
        [("space", "cycles a pixel", |s| &s.spatial), ("time", "cycles a frame", |s| &s.temporal)];
    for (name, x, of) in domains {
        let curves: Vec<Line> = spectra
            .iter()
            .map(|(kind, spectra)| Line { name: kind.clone(), points: of(spectra).clone() })
            .collect();
        let file = format!("spectra_{name}");
        let axes = Axes { x, y: "power, white noise = 1" };
        section.drawing(&file, &format!("in {name}"), plot::lines(axes, &curves, true, &[])?);
        let points = |line: &Line| {
            let row = |&[f, p]: &[f64; 2]| vec![line.name.as_str().into(), f.into(), p.into()];
            line.points.iter().map(row).collect::<Vec<_>>()
        };
        let rows = curves.iter().flat_map(points).collect();
        section.data(&file, &["noise", "frequency", "power"], rows);
    }
    Ok(section)
}

/// Thresholds of all frames of a kind of noise, 0…1.
fn values(kind: NoiseKind) -> Vec<f64> {
    let noise = Noise::new(kind, 0);
    let NoiseSize { width, height, frames } = NoiseSize::STBN;
    let mut values = Vec::with_capacity(NoiseSize::STBN.len());
    for t in 0..frames as u32 {
        let frame = noise.frame(t);
        let levels = f64::from(frame.levels());
        let pixels = (0..height as u32).flat_map(|y| (0..width as u32).map(move |x| (x, y)));
        values.extend(pixels.map(|(x, y)| (f64::from(frame.rank(x, y)) + 0.5) / levels));
    }
    values
}

/// Mean of the first `count` frames of `noise`, as a grey picture.
fn mean(noise: &Noise, count: u32) -> Frame {
    let side = NoiseSize::STBN.width as u32;
    let frames: Vec<_> = (0..count).map(|t| noise.frame(t)).collect();
    let value = |x: u32, y: u32| {
        let of = frames.iter().map(|frame| (frame.rank(x, y) as f32 + 0.5) / frame.levels() as f32);
        of.sum::<f32>() / count as f32
    };
    let size = FrameSize::new(side, side).expect("tiles are small");
    larger(&grey(size, value), SCALE)
}
