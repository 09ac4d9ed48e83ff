use super::recipe::{Attempt, Course, Recipe};
use super::{Clip, Scenery};
use crate::{Error, Result};
use fovol_core::{Camera, FrameSize, Pixel, SampleList, f16};
use fovolnet::OpenVolume;
use fovolnet::render::cpu::march::Marched;
use fovolnet::render::cpu::{RenderOptions, Renderer};

/// How often a clip that shows next to nothing is drawn again.
const ATTEMPTS: u64 = 40;
/// Every so many pixels along both axes one is looked at to see whether a clip shows anything.
const STRIDE: usize = 8;
/// A clip has to show something at this share of its pixels,
const SHOWN: f64 = 0.25;
/// and to vary by this much: the standard deviation of its green.
const VARIED: f64 = 0.03;

/// Renders the clip of `recipe`; `volume` is the one it names.
///
/// # Errors
/// A volume of which no attempt shows anything.
pub fn record(recipe: &Recipe, volume: &OpenVolume) -> Result<Clip> {
    for number in 0..ATTEMPTS {
        let attempt = recipe.attempt(volume, number)?;
        let renderer = Renderer::new(&attempt.scene, RenderOptions::default())?;
        let shows = recipe.course != Course::Drawn
            || [0, recipe.length - 1].into_iter().all(|t| {
                let pixels = part(&attempt, recipe.side, STRIDE);
                shows_something(&march(&renderer, &attempt.cameras[t], attempt.whole, pixels))
            });
        if shows {
            return film(recipe, volume, attempt, &renderer);
        }
    }
    let problem =
        format!("{}: nothing can be seen in {ATTEMPTS} attempts; leave this volume out", recipe.source);
    Err(Error::Clip(problem))
}

fn film(recipe: &Recipe, volume: &OpenVolume, attempt: Attempt, renderer: &Renderer) -> Result<Clip> {
    let pixels = part(&attempt, recipe.side, 1);
    let (frames, inverse_distances) = attempt
        .cameras
        .iter()
        .map(|camera| {
            let marched = march(renderer, camera, attempt.whole, pixels.clone());
            let colours =
                marched.iter().flat_map(|ray| ray.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8));
            let distances = marched.iter().map(|ray| f16::from_f32(1.0 / ray.depth));
            (colours.collect(), distances.collect())
        })
        .unzip();
    let scenery = Scenery {
        seed: recipe.seed,
        volume: volume.source.clone(),
        whole: attempt.whole,
        corner: attempt.corner,
        part: FrameSize::new(recipe.side, recipe.side)?,
        cameras: attempt.cameras,
    };
    Ok(Clip { scenery, frames, inverse_distances })
}

/// Every `stride`-th pixel of the part.
fn part(attempt: &Attempt, side: u32, stride: usize) -> Vec<Pixel> {
    let [left, top] = attempt.corner;
    let along = move |start: u32| (start..start + side).step_by(stride);
    along(top).flat_map(|y| along(left).map(move |x| Pixel { x: x as u16, y: y as u16 })).collect()
}

fn march(renderer: &Renderer, camera: &Camera, whole: FrameSize, pixels: Vec<Pixel>) -> Vec<Marched> {
    renderer.march_list(camera, &SampleList::new(whole, pixels)).0
}

fn shows_something(marched: &[Marched]) -> bool {
    let count = marched.len() as f64;
    let shown = marched.iter().filter(|ray| ray.opacity > 0.02).count() as f64 / count;
    let mean = marched.iter().map(|ray| f64::from(ray.colour[1])).sum::<f64>() / count;
    let variance = marched.iter().map(|ray| (f64::from(ray.colour[1]) - mean).powi(2)).sum::<f64>() / count;
    shown > SHOWN && variance.sqrt() > VARIED
}
