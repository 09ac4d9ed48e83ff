use super::recipe::{Attempt, Course, Recipe};
use super::{Clip, Scenery};
use crate::{Error, Result};
use fovol_core::{FrameSize, Pixel, SampleList, f16};
use fovolnet::guide::guide_pixel;
use fovolnet::render::scene::RayResult;
use fovolnet::{OpenDevice, OpenVolume, Rays};

/// Attempts at drawing a clip before the volume is given up.
const ATTEMPTS: u64 = 40;
/// Pixel stride along both axes of the test whether a clip shows anything.
const STRIDE: usize = 8;
/// Smallest fraction of pixels that show something in a useful clip.
const SHOWN: f64 = 0.25;
/// Smallest standard deviation of green in a useful clip.
const VARIED: f64 = 0.03;

/// Renders the clip of `recipe` on `device`. `volume` must be the recipe's volume.
///
/// # Errors
/// No attempt shows anything, or the device fails.
pub fn record(recipe: &Recipe, volume: &OpenVolume, device: &OpenDevice) -> Result<Clip> {
    for number in 0..ATTEMPTS {
        let attempt = recipe.attempt(volume, number)?;
        let mut rays = Rays::new(&attempt.scene, attempt.whole, device)?;
        if recipe.course != Course::Drawn || shows_something(recipe, &attempt, &mut rays)? {
            return film(recipe, volume, attempt, &mut rays);
        }
    }
    let problem =
        format!("{}: nothing can be seen in {ATTEMPTS} attempts; leave this volume out", recipe.source);
    Err(Error::Clip(problem))
}

fn film(recipe: &Recipe, volume: &OpenVolume, attempt: Attempt, rays: &mut Rays) -> Result<Clip> {
    let pixels = part(&attempt, recipe.side, 1);
    let scenery = Scenery {
        seed: recipe.seed,
        volume: volume.source.clone(),
        whole: attempt.whole,
        corner: attempt.corner,
        part: FrameSize::new(recipe.side, recipe.side)?,
        gpu: rays.gpu_name(),
        cameras: attempt.cameras,
    };
    let mut clip = Clip { frames: Vec::new(), guides: Vec::new(), inverse_distances: Vec::new(), scenery };
    for camera in &clip.scenery.cameras {
        let marched = rays.march(camera, &pixels)?;
        let number = |value: f32| f16::from_f32(value.clamp(0.0, 1.0));
        clip.frames.push(marched.iter().flat_map(|ray| ray.colour.map(number)).collect());
        clip.guides.push(marched.iter().flat_map(|ray| guide_pixel(ray).map(number)).collect());
        clip.inverse_distances.push(marched.iter().map(|ray| f16::from_f32(1.0 / ray.depth)).collect());
    }
    Ok(clip)
}

/// Every `stride`-th pixel of the crop along both axes.
fn part(attempt: &Attempt, side: u32, stride: usize) -> SampleList {
    let [left, top] = attempt.corner;
    let along = move |start: u32| (start..start + side).step_by(stride);
    let pixels = along(top).flat_map(|y| along(left).map(move |x| Pixel { x: x as u16, y: y as u16 }));
    SampleList::new(attempt.whole, pixels.collect())
}

/// Whether the first and the last frame show enough.
fn shows_something(recipe: &Recipe, attempt: &Attempt, rays: &mut Rays) -> Result<bool> {
    let pixels = part(attempt, recipe.side, STRIDE);
    for t in [0, recipe.length - 1] {
        if !is_something(&rays.march(&attempt.cameras[t], &pixels)?) {
            return Ok(false);
        }
    }
    Ok(true)
}

fn is_something(marched: &[RayResult]) -> bool {
    let count = marched.len() as f64;
    let shown = marched.iter().filter(|ray| ray.opacity > 0.02).count() as f64 / count;
    let mean = marched.iter().map(|ray| f64::from(ray.colour[1])).sum::<f64>() / count;
    let variance = marched.iter().map(|ray| (f64::from(ray.colour[1]) - mean).powi(2)).sum::<f64>() / count;
    shown > SHOWN && variance.sqrt() > VARIED
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::clips::VolumeSource;
    use fovolnet::Device;

    #[test]
    #[ignore = "needs an adapter: cargo test --release -- --ignored"]
    fn clips_of_a_gpu_are_those_of_the_processor() {
        let source = VolumeSource::parse("marschner-lobb:20:1").unwrap();
        let volume = source.open().unwrap();
        let recipe = Recipe::draw(5, &source).with_part(32, 3);
        let [cpu, gpu] = [Device::Cpu, Device::Gpu(None)]
            .map(|device| record(&recipe, &volume, &device.open().unwrap()).unwrap());
        assert!(cpu.scenery.gpu.is_none() && gpu.scenery.gpu.is_some());
        assert_eq!(cpu.scenery.cameras, gpu.scenery.cameras);
        let numbers = |clip: &Clip| [&clip.frames, &clip.guides].map(|frames| frames.concat()).concat();
        for (cpu, gpu) in numbers(&cpu).iter().zip(&numbers(&gpu)) {
            assert!((cpu.to_f32() - gpu.to_f32()).abs() <= 2.0 / 255.0, "{cpu} and {gpu}");
        }
    }
}
