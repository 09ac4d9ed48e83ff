//! Workgroups that follow rays together; as shaders/pool.wgsl.

use super::count::{Count, WARP};
use super::gpu_model::GpuModel;
use super::ray_steps::{RaySteps, ShadowSteps, Step};
use super::rays;
use super::replay::{Replay, inverse_of};
use crate::scene::Segment;

/// Rays, threads, and places of the queue for each ray of a workgroup.
pub struct PoolStrategy {
    pub rays: usize,
    pub threads: usize,
    pub queue: usize,
}

/// Cycles of the barriers of a stretch, and of a round.
const STRETCH: f64 = 300.0;
const ROUND: f64 = 200.0;
/// Cycles of one sample where a thread queues or adds the samples of its ray.
const ONE_BY_ONE: f64 = 8.0;

/// State of a ray.
struct State {
    /// Number of its next sample.
    number: u32,
    /// Its next lit sample that is not queued yet.
    lit: usize,
    queued: usize,
}

impl PoolStrategy {
    /// Counts of a workgroup whose rays have these segments and steps.
    pub fn count(
        &self,
        replay: &Replay,
        (segments, steps): (&[Segment], &[RaySteps]),
        gpu: &GpuModel,
    ) -> Count {
        let mut count = Count::default();
        let mut states: Vec<State> = steps.iter().map(|_| State { number: 0, lit: 0, queued: 0 }).collect();
        loop {
            let mut queue = Vec::new();
            let mut goes_on;
            loop {
                self.stretch(&mut count, gpu);
                for ((state, ray), segment) in states.iter_mut().zip(steps).zip(segments) {
                    self.take(state, ray, segment, replay);
                }
                let left = || states.iter().zip(steps).filter(|(state, ray)| state.number < ray.end);
                goes_on = left().next().is_some();
                let lanes = self.threads / self.rays;
                if !goes_on || left().any(|(state, _)| state.queued + lanes > self.queue) {
                    break;
                }
            }
            for (state, ray) in states.iter_mut().zip(steps) {
                let queued = &ray.lit[state.lit - state.queued..state.lit];
                queue.extend(queued.iter().map(|lit| &lit.shadow));
                state.queued = 0;
            }
            self.light(&mut count, &queue, gpu);
            if !goes_on {
                return count;
            }
        }
    }

    /// Every warp takes a step, then one thread of each ray walks over its entries.
    fn stretch(&self, count: &mut Count, gpu: &GpuModel) {
        let before = count.cycles;
        for _ in 0..self.threads.div_ceil(WARP) {
            rays::step(count, Step { looks: true, samples: true }, gpu);
        }
        let walk = ONE_BY_ONE * (self.threads / self.rays) as f64;
        // Warps take their steps side by side.
        count.cycles = before + gpu.step + gpu.look + gpu.sample + STRETCH + walk;
        count.chain += 1;
    }

    /// Moves a ray by a stretch.
    fn take(&self, state: &mut State, ray: &RaySteps, segment: &Segment, replay: &Replay) {
        if state.number >= ray.end {
            return;
        }
        let lanes = (self.threads / self.rays) as u32;
        let after = state.number + lanes;
        let found = ray.lit[state.lit..].iter().take_while(|lit| lit.number < after).count();
        state.lit += found;
        state.queued += found;
        let ahead = replay.ahead(segment.position(after - 1), inverse_of(segment.delta));
        state.number = if ahead.is_empty { after.saturating_add(ahead.steps as u32 - 1) } else { after };
    }

    /// Every lane follows a queued shadow ray step by step, and takes the next one when it is done.
    fn light(&self, count: &mut Count, queue: &[&ShadowSteps], gpu: &GpuModel) {
        let mut next = queue.iter();
        let mut lanes: Vec<&[Step]> = vec![&[]; self.threads];
        let mut cycles = vec![0.0; self.threads.div_ceil(WARP)];
        loop {
            let mut goes_on = false;
            for (warp, cycles) in lanes.chunks_mut(WARP).zip(&mut cycles) {
                let mut taken = Count::default();
                let mut all = None;
                for lane in warp {
                    while lane.is_empty()
                        && let Some(shadow) = next.next()
                    {
                        taken.shadow_loads += shadow.words;
                        *lane = &shadow.steps;
                    }
                    if let Some((first, rest)) = lane.split_first() {
                        all = Some(all.unwrap_or(Step::default()).or(*first));
                        taken.lane_steps += 1;
                        taken.shadow_loads += first.loads();
                        *lane = rest;
                    }
                }
                if let Some(all) = all {
                    rays::step(&mut taken, all, gpu);
                    taken.shadow_warp_steps = 1;
                    goes_on = true;
                }
                *cycles += taken.cycles;
                count.add(&taken);
            }
            if !goes_on {
                break;
            }
            count.chain += 1;
        }
        let adds = ONE_BY_ONE * (queue.len() / self.rays) as f64;
        count.cycles += cycles.into_iter().fold(0.0, f64::max) + ROUND + adds;
    }
}
