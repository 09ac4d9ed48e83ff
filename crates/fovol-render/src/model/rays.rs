//! A thread for each ray.

use super::count::Count;
use super::gpu_model::GpuModel;
use super::ray_steps::{RaySteps, ShadowSteps, Step};

/// Counts of a warp whose lanes follow `rays`.
pub fn count(rays: &[RaySteps], gpu: &GpuModel) -> Count {
    let mut count = Count { chain: rays.iter().map(RaySteps::chain).max().unwrap_or(0), ..Count::default() };
    let longest = rays.iter().map(|ray| ray.steps.len()).max().unwrap_or(0);
    for i in 0..longest {
        let steps = rays.iter().filter_map(|ray| ray.steps.get(i)).map(|(step, _)| *step);
        step(&mut count, steps.fold(Step::default(), Step::or), gpu);
        let shadows: Vec<_> = rays.iter().filter_map(|ray| ray.shadow(i)).collect();
        shadow_steps(&mut count, &shadows, gpu);
    }
    count
}

/// Adds shadow rays that lanes of a warp follow together.
fn shadow_steps(count: &mut Count, shadows: &[&ShadowSteps], gpu: &GpuModel) {
    let longest = shadows.iter().map(|shadow| shadow.steps.len()).max().unwrap_or(0);
    count.shadow_loads += shadows.iter().map(|shadow| shadow.words).sum::<u64>();
    for j in 0..longest {
        let mut all = Step::default();
        for one in shadows.iter().filter_map(|shadow| shadow.steps.get(j)) {
            all = all.or(*one);
            count.lane_steps += 1;
            count.shadow_loads += one.loads();
        }
        step(count, all, gpu);
        count.shadow_warp_steps += 1;
    }
}

/// Adds a step of a warp.
pub fn step(count: &mut Count, taken: Step, gpu: &GpuModel) {
    count.warp_steps += 1;
    count.loads += taken.loads();
    let look = if taken.looks { gpu.look } else { 0.0 };
    let sample = if taken.samples { gpu.sample } else { 0.0 };
    count.cycles += gpu.step + look + sample;
}
