use super::count::{Count, WARP};
use super::gpu_model::GpuModel;
use super::pool::PoolStrategy;
use super::rays;
use super::replay::Replay;
use fovol_core::{Camera, FrameSize, Pixel};
use rayon::prelude::*;
use std::collections::BinaryHeap;

/// How threads share the work, as the model knows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// A thread for each ray.
    Rays,
    /// A workgroup for some rays.
    Pool {
        /// Its rays.
        rays: usize,
        /// Its threads.
        threads: usize,
        /// Places of the queue for each ray.
        queue: usize,
    },
}

/// Order of the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Row by row.
    Raster,
    /// In tiles of 32 by 32 pixels, row by row in each, as the device packs lists.
    Tiles,
    /// In squares of 8 by 8 pixels, as frames with every pixel are marched.
    Squares,
}

/// Cost of marching the rays of some pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarchCost {
    /// Most dependent steps of a ray, or of a workgroup.
    pub longest_chain: u64,
    /// Steps that warps take.
    pub warp_steps: u64,
    /// Share of the lanes that are busy in shadow rays, 0…1.
    pub busy_lanes: f64,
    /// Texture loads of a step of a shadow ray.
    pub loads_per_shadow_step: f64,
    /// Milliseconds on the GPU: the busiest place of a warp, or the texture units if these take longer.
    pub ms: f64,
}

/// Cost of marching `pixels` of a frame of `size` seen by `camera`, in this `order`, shared out by `work`. Shadow rays know
/// their samples beforehand with `columns`.
pub fn cost(
    (replay, gpu): (&Replay, &GpuModel),
    (camera, size): (&Camera, FrameSize),
    (pixels, order): (&[Pixel], Order),
    (work, columns): (Work, bool),
) -> MarchCost {
    let mut pixels = pixels.to_vec();
    pixels.sort_by_key(|pixel| key(*pixel, order));
    let basis = camera.rays(size);
    let segments: Vec<_> =
        pixels.par_iter().map(|pixel| replay.segment(&basis.ray(pixel.x.into(), pixel.y.into()))).collect();
    let (rays, warps) = match work {
        Work::Rays => (WARP, 1),
        Work::Pool { rays, threads, .. } => (rays, threads.div_ceil(WARP)),
    };
    let counts: Vec<Count> = segments
        .par_chunks(rays)
        .map(|segments| {
            let steps: Vec<_> = segments.iter().map(|segment| replay.follow(segment, columns)).collect();
            match work {
                Work::Rays => rays::count(&steps, gpu),
                Work::Pool { threads, queue, .. } => {
                    let pool = PoolStrategy { rays, threads, queue };
                    pool.count(replay, (segments, &steps), gpu)
                }
            }
        })
        .collect();
    summed(&counts, warps, gpu)
}

fn key(pixel: Pixel, order: Order) -> [u16; 4] {
    let Pixel { x, y } = pixel;
    match order {
        Order::Raster => [y, x, 0, 0],
        Order::Tiles => [y / 32, x / 32, y, x],
        Order::Squares => [y / 8, x / 8, y, x],
    }
}

fn summed(counts: &[Count], warps: usize, gpu: &GpuModel) -> MarchCost {
    let sum = |of: fn(&Count) -> u64| counts.iter().map(of).sum::<u64>();
    let per = |a: u64, b: u64| if b > 0 { a as f64 / b as f64 } else { 0.0 };
    let places = (gpu.multiprocessors * gpu.warps) as usize / warps;
    let textures = sum(|count| count.loads) as f64 * gpu.load / f64::from(gpu.multiprocessors);
    MarchCost {
        longest_chain: counts.iter().map(|count| count.chain).max().unwrap_or(0),
        warp_steps: sum(|count| count.warp_steps),
        busy_lanes: per(sum(|count| count.lane_steps), WARP as u64 * sum(|count| count.shadow_warp_steps)),
        loads_per_shadow_step: per(sum(|count| count.shadow_loads), sum(|count| count.lane_steps)),
        ms: gpu.ms(makespan(counts, places.max(1)).max(textures)),
    }
}

/// Cycles until all of `counts` are done, if each in turn takes the first of `places` that is free.
fn makespan(counts: &[Count], places: usize) -> f64 {
    let mut busy: BinaryHeap<std::cmp::Reverse<u64>> = vec![std::cmp::Reverse(0); places].into();
    let mut last = 0;
    for count in counts {
        let std::cmp::Reverse(free) = busy.pop().unwrap_or_default();
        let until = free + count.cycles as u64;
        last = last.max(until);
        busy.push(std::cmp::Reverse(until));
    }
    last as f64
}
