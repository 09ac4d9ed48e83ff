//! Lit samples waiting for their shadow rays, and the tracing of those rays in lanes.

use super::field::{Field, Texel};
use super::lanes::{Lanes, MOST_LANES};
use super::march::DARK;
use super::segment::{LightPath, SHADOW_START, SHADOW_STEP};
use super::skip::{Course, Skip};

/// Samples of one or more rays: where they are, what light would add, and (once traced) how much arrives.
#[derive(Default)]
pub struct ShadowPool {
    /// x, y, z in voxel-centre coordinates; r, g, b of the light's part; transmittance.
    columns: [Vec<f32>; 7],
    len: usize,
}

const TRANSMITTANCE: usize = 6;

impl ShadowPool {
    /// How many samples wait.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Forgets all samples, keeps the memory.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Makes room for `more` samples and one vector beyond them.
    pub fn reserve(&mut self, more: usize) {
        let needed = self.len + more + 64;
        if self.columns[0].len() < needed {
            let size = needed.next_power_of_two();
            self.columns.iter_mut().for_each(|c| c.resize(size, 0.0));
        }
    }

    /// Appends the lanes of `position` and `colour` where `m` holds.
    ///
    /// # Safety
    /// The instruction set of `L` must be available, and room reserved.
    #[inline(always)]
    pub unsafe fn push<L: Lanes>(&mut self, m: L::M, position: [L::F; 3], colour: [L::F; 3]) {
        debug_assert!(self.len + L::N <= self.columns[0].len());
        let len = self.len;
        for (column, v) in self.columns.iter_mut().zip(position.into_iter().chain(colour)) {
            // SAFETY: `reserve` left a vector's room after `len`.
            unsafe { L::compress(v, m, column.as_mut_ptr().add(len)) };
        }
        // SAFETY: the caller's.
        self.len += unsafe { L::bits(m) }.count_ones() as usize;
    }

    /// Adds T·rgb of the samples `from`…`to` (at most N) to `sums`, lane by lane.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn arriving<L: Lanes>(&self, from: usize, to: usize, sums: [L::F; 3]) -> [L::F; 3] {
        // SAFETY: `reserve` left a vector's room after the last sample.
        unsafe {
            let inside = L::lt(L::iota(), L::splat((to - from) as f32));
            let t = L::select(inside, L::load(self.columns[TRANSMITTANCE].as_ptr().add(from)), L::splat(0.0));
            let mut out = sums;
            for c in 0..3 {
                let rgb = L::select(inside, L::load(self.columns[3 + c].as_ptr().add(from)), L::splat(0.0));
                out[c] = L::fma(t, rgb, sums[c]);
            }
            out
        }
    }
}

/// What shadow rays meet.
pub struct ShadowRays<'a, T> {
    /// The volume, scaled to indices of `alpha`.
    pub field: &'a Field<'a, T>,
    /// α of one shadow step.
    pub alpha: &'a [f32],
    /// The way to the light.
    pub light: &'a LightPath,
    /// Where nothing is, if looking for it pays.
    pub skip: Option<&'a Skip<'a>>,
}

/// The lanes of a bundle of shadow rays, in memory while finished ones are replaced.
struct Bundle {
    position: [[f32; MOST_LANES]; 3],
    steps: [f32; MOST_LANES],
    left: [f32; MOST_LANES],
    transmittance: [f32; MOST_LANES],
    sample: [usize; MOST_LANES],
    next: usize,
}

const NOBODY: usize = usize::MAX;

impl Bundle {
    fn new() -> Self {
        Self {
            position: [[0.0; MOST_LANES]; 3],
            steps: [0.0; MOST_LANES],
            left: [0.0; MOST_LANES],
            transmittance: [1.0; MOST_LANES],
            sample: [NOBODY; MOST_LANES],
            next: 0,
        }
    }

    /// Position, steps, steps left and transmittance as vectors.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    unsafe fn load<L: Lanes>(&self) -> ([L::F; 3], L::F, L::F, L::F) {
        // SAFETY: the arrays hold at least N elements.
        unsafe {
            let [x, y, z] = &self.position;
            (
                [L::load(x.as_ptr()), L::load(y.as_ptr()), L::load(z.as_ptr())],
                L::load(self.steps.as_ptr()),
                L::load(self.left.as_ptr()),
                L::load(self.transmittance.as_ptr()),
            )
        }
    }

    /// Delivers every finished lane's transmittance and gives the lane the next sample that has any
    /// way to the light.
    #[inline(always)]
    fn refill(&mut self, finished: u32, pool: &mut ShadowPool, light: &LightPath) {
        let mut finished = finished;
        while finished != 0 {
            let lane = finished.trailing_zeros() as usize;
            finished &= finished - 1;
            if self.sample[lane] != NOBODY {
                pool.columns[TRANSMITTANCE][self.sample[lane]] = self.transmittance[lane];
                self.sample[lane] = NOBODY;
            }
            self.left[lane] = 0.0;
            while self.next < pool.len {
                let sample = self.next;
                self.next += 1;
                let p = [pool.columns[0][sample], pool.columns[1][sample], pool.columns[2][sample]];
                let count = light.count(p);
                if count == 0 {
                    pool.columns[TRANSMITTANCE][sample] = 1.0;
                    continue;
                }
                (0..3).for_each(|a| self.position[a][lane] = p[a]);
                self.steps[lane] = SHADOW_START;
                self.left[lane] = count as f32;
                self.transmittance[lane] = 1.0;
                self.sample[lane] = sample;
                break;
            }
        }
    }
}

/// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn trace<L: Lanes, T: Texel>(rays: &ShadowRays<'_, T>, pool: &mut ShadowPool) -> u64 {
    // SAFETY: table indices come from display values in 0…1 scaled to the table; lanes are loaded from
    // and stored to arrays of at least N elements.
    unsafe {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let delta = rays.light.delta.map(|d| L::splat(d));
        let all = u32::MAX >> (32 - L::N);
        let mut bundle = Bundle::new();
        let mut samples = 0u64;
        bundle.refill(all, pool, rays.light);
        let (mut p, mut steps, mut left, mut transmittance) = bundle.load::<L>();
        let course = Course::<L>::towards(rays.light);
        let mut look = 0u32;
        loop {
            let mut active = L::and_m(L::gt(left, zero), L::gt(transmittance, L::splat(DARK)));
            let running = L::bits(active);
            let idle = L::N as u32 - running.count_ones();
            let waiting = bundle.next < pool.len;
            if running == 0 || (waiting && idle * 4 >= L::N as u32) {
                L::store(steps, bundle.steps.as_mut_ptr());
                L::store(left, bundle.left.as_mut_ptr());
                L::store(transmittance, bundle.transmittance.as_mut_ptr());
                bundle.refill(all & !running, pool, rays.light);
                (p, steps, left, transmittance) = bundle.load::<L>();
                active = L::and_m(L::gt(left, zero), L::gt(transmittance, L::splat(DARK)));
                if L::bits(active) == 0 {
                    return samples;
                }
                look = 0;
            }
            let mut at =
                [L::fma(steps, delta[0], p[0]), L::fma(steps, delta[1], p[1]), L::fma(steps, delta[2], p[2])];
            if let Some(skip) = rays.skip {
                if look == 0 {
                    let jump = skip.shadow_steps::<L>(at, &course);
                    if L::bits(L::and_m(L::gt(jump, zero), active)) != 0 {
                        steps = L::fma(jump, L::splat(SHADOW_STEP), steps);
                        left = L::sub(left, jump);
                        look = LOOK_AGAIN;
                        active = L::and_m(active, L::gt(left, zero));
                        at = [
                            L::fma(steps, delta[0], p[0]),
                            L::fma(steps, delta[1], p[1]),
                            L::fma(steps, delta[2], p[2]),
                        ];
                    } else {
                        look = LOOK_EVERY;
                    }
                } else {
                    look -= 1;
                }
            }
            samples += u64::from(L::bits(active).count_ones());
            let index = L::truncate(L::add(rays.field.sample::<L>(at), L::splat(0.5)));
            let alpha = L::gather_f32(rays.alpha.as_ptr(), index);
            transmittance = L::mul(transmittance, L::select(active, L::sub(one, alpha), one));
            steps = L::add(steps, L::splat(SHADOW_STEP));
            left = L::sub(left, one);
        }
    }
}

/// After a look that found something to skip, this many steps go by without one.
const LOOK_AGAIN: u32 = 2;
/// After a look that found nothing, this many.
const LOOK_EVERY: u32 = 6;
