//! Lit samples waiting for their shadow rays, and the tracing of those rays in lanes.

use super::field::{Field, Texel};
use super::lanes::{Lanes, MOST_LANES};
use super::light_columns::{LightColumns, SLABS};
use super::march::DARK;
use super::segment::{LightPath, SHADOW_START, SHADOW_STEP};

/// Samples of one or more rays: where they are, what light would add, and (once traced) how much arrives.
#[derive(Default)]
pub struct ShadowPool {
    /// x, y, z in voxel-centre coordinates; r, g, b of the light's part; transmittance.
    columns: [Vec<f32>; 7],
    /// Where the shadow rays of a part of the pool run.
    courses: Vec<Course>,
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
    /// Which samples may meet anything, if knowing it pays.
    pub columns: Option<&'a LightColumns>,
}

/// The slabs that a shadow ray takes its samples in: those numbered `first`…`end` − 1 of a column.
#[derive(Debug, Clone, Copy)]
struct Course {
    column: u32,
    first: u32,
    end: u32,
}

impl Course {
    /// The ray of nobody.
    const NONE: Self = Self { column: 0, first: 0, end: 0 };

    /// Which samples of word `word` need be taken.
    #[inline(always)]
    fn samples(&self, word: u32, columns: &LightColumns) -> u32 {
        let start = word * SLABS;
        let after = u32::MAX << self.first.saturating_sub(start);
        let before = u32::MAX >> (SLABS - (self.end - start).min(SLABS));
        columns.word(self.column as usize, word as usize) & after & before
    }
}

/// A shadow ray for each lane, in memory while finished ones are replaced.
struct Bundle {
    position: [[f32; MOST_LANES]; 3],
    /// Δ from the point to the sample of the lowest bit of `left`, or to the next one.
    steps: [f32; MOST_LANES],
    /// What is still to be taken: a bit for each sample of one word of the ray's course, or their number as the bits
    /// of an f32.
    left: [u32; MOST_LANES],
    transmittance: [f32; MOST_LANES],
    course: [Course; MOST_LANES],
    /// The word after that of `left`.
    word: [u32; MOST_LANES],
    sample: [usize; MOST_LANES],
    next: usize,
}

const NOBODY: usize = usize::MAX;

impl Bundle {
    fn new() -> Self {
        Self {
            position: [[0.0; MOST_LANES]; 3],
            steps: [0.0; MOST_LANES],
            left: [0; MOST_LANES],
            transmittance: [1.0; MOST_LANES],
            course: [Course::NONE; MOST_LANES],
            word: [0; MOST_LANES],
            sample: [NOBODY; MOST_LANES],
            next: 0,
        }
    }

    /// Position, steps, what is left, and transmittance as vectors.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    unsafe fn load<L: Lanes>(&self) -> ([L::F; 3], L::F, L::I, L::F) {
        // SAFETY: the arrays hold at least N elements.
        unsafe {
            let [x, y, z] = &self.position;
            (
                [L::load(x.as_ptr()), L::load(y.as_ptr()), L::load(z.as_ptr())],
                L::load(self.steps.as_ptr()),
                L::to_bits(L::load(self.left.as_ptr().cast())),
                L::load(self.transmittance.as_ptr()),
            )
        }
    }

    /// Gives every lane of `finished` the next word of its ray that has samples to take; where there is
    /// none, delivers the ray's transmittance and takes the next ray of `pool` that has any.
    #[inline(always)]
    fn refill<T, const LISTED: bool>(
        &mut self,
        finished: u32,
        pool: &mut ShadowPool,
        rays: &ShadowRays<'_, T>,
    ) {
        let mut finished = finished;
        while finished != 0 {
            let lane = finished.trailing_zeros() as usize;
            finished &= finished - 1;
            if LISTED && self.transmittance[lane] > DARK && self.next_word(lane, rays.columns) {
                continue;
            }
            if self.sample[lane] != NOBODY {
                pool.columns[TRANSMITTANCE][self.sample[lane]] = self.transmittance[lane];
                self.sample[lane] = NOBODY;
            }
            self.left[lane] = 0;
            self.course[lane] = Course::NONE;
            self.word[lane] = 0;
            while self.next < pool.len {
                let sample = self.next;
                self.next += 1;
                self.course[lane] = pool.courses[sample];
                self.word[lane] = self.course[lane].first / SLABS;
                let goes = if LISTED { self.next_word(lane, rays.columns) } else { self.take_all(lane) };
                if goes {
                    (0..3).for_each(|a| self.position[a][lane] = pool.columns[a][sample]);
                    self.transmittance[lane] = 1.0;
                    self.sample[lane] = sample;
                    break;
                }
                pool.columns[TRANSMITTANCE][sample] = 1.0;
            }
        }
    }

    /// Whether no lane has a ray.
    #[inline(always)]
    fn is_done(&self) -> bool {
        self.sample == [NOBODY; MOST_LANES]
    }

    /// Makes `lane` take every sample of its course; false if there is none.
    #[inline(always)]
    fn take_all(&mut self, lane: usize) -> bool {
        let Course { first, end, .. } = self.course[lane];
        self.steps[lane] = SHADOW_START;
        self.left[lane] = ((end - first) as f32).to_bits();
        end > first
    }

    /// Moves `lane` on to the next word with samples to take; false if there is none.
    #[inline(always)]
    fn next_word(&mut self, lane: usize, columns: Option<&LightColumns>) -> bool {
        let Some(columns) = columns else { return false };
        let course = self.course[lane];
        while self.word[lane] * SLABS < course.end {
            let word = self.word[lane];
            self.word[lane] += 1;
            let samples = course.samples(word, columns);
            if samples != 0 {
                let before = (word * SLABS) as f32 - course.first as f32;
                self.steps[lane] = SHADOW_STEP.mul_add(before, SHADOW_START);
                self.left[lane] = samples;
                return true;
            }
        }
        false
    }
}

impl ShadowPool {
    /// Finds the courses of all waiting samples.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    unsafe fn plan<L: Lanes, T>(&mut self, rays: &ShadowRays<'_, T>) {
        let mut column = [0u32; MOST_LANES];
        let mut first = [0u32; MOST_LANES];
        let mut count = [0u32; MOST_LANES];
        self.courses.clear();
        let mut done = 0;
        while done < self.len {
            // SAFETY: `reserve` left a vector's room after the last sample; arrays hold at least N elements.
            unsafe {
                let p = [0, 1, 2].map(|a| L::load(self.columns[a].as_ptr().add(done)));
                let put = |v: L::I, to: &mut [u32; MOST_LANES]| {
                    L::store(L::from_bits(v), to.as_mut_ptr().cast());
                };
                put(rays.light.counts::<L>(p), &mut count);
                if let Some(columns) = rays.columns {
                    let (at, slab) = columns.locate::<L>(p);
                    put(at, &mut column);
                    put(slab, &mut first);
                }
            }
            let lanes = L::N.min(self.len - done);
            self.courses.extend((0..lanes).map(|i| Course {
                column: column[i],
                first: first[i],
                end: first[i] + count[i],
            }));
            done += L::N;
        }
    }
}

/// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn trace<L: Lanes, T: Texel>(rays: &ShadowRays<'_, T>, pool: &mut ShadowPool) -> u64 {
    // SAFETY: the caller's.
    unsafe {
        pool.plan::<L, T>(rays);
        if rays.columns.is_some() {
            trace_as::<L, T, true>(rays, pool)
        } else {
            trace_as::<L, T, false>(rays, pool)
        }
    }
}

/// [`trace`] along planned courses: the samples that words list (`LISTED`), or all.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
unsafe fn trace_as<L: Lanes, T: Texel, const LISTED: bool>(
    rays: &ShadowRays<'_, T>,
    pool: &mut ShadowPool,
) -> u64 {
    // SAFETY: table indices come from display values in 0…1 scaled to the table; lanes are loaded from
    // and stored to arrays of at least N elements.
    unsafe {
        let (zero, one, step) = (L::splat(0.0), L::splat(1.0), L::splat(SHADOW_STEP));
        let delta = rays.light.delta.map(|d| L::splat(d));
        let all = u32::MAX >> (32 - L::N);
        let mut bundle = Bundle::new();
        let mut taken = 0u64;
        bundle.refill::<T, LISTED>(all, pool, rays);
        // Where nothing is listed, what is left is the number of samples as an f32.
        let (mut p, mut steps, mut left, mut transmittance) = bundle.load::<L>();
        loop {
            let (place, waiting_samples) =
                if LISTED { lowest_bit::<L>(left) } else { (zero, L::gt(L::from_bits(left), zero)) };
            let active = L::and_m(waiting_samples, L::gt(transmittance, L::splat(DARK)));
            let running = L::bits(active);
            let idle = L::N as u32 - running.count_ones();
            let waiting = bundle.next < pool.len;
            if running == 0 || (waiting && idle * 4 >= L::N as u32) {
                L::store(L::from_bits(left), bundle.left.as_mut_ptr().cast());
                L::store(steps, bundle.steps.as_mut_ptr());
                L::store(transmittance, bundle.transmittance.as_mut_ptr());
                bundle.refill::<T, LISTED>(all & !running, pool, rays);
                if bundle.is_done() {
                    return taken;
                }
                (p, steps, left, transmittance) = bundle.load::<L>();
                continue;
            }
            let ahead = if LISTED { L::fma(place, step, steps) } else { steps };
            let at =
                [L::fma(ahead, delta[0], p[0]), L::fma(ahead, delta[1], p[1]), L::fma(ahead, delta[2], p[2])];
            taken += u64::from(running.count_ones());
            let index = L::truncate(L::add(rays.field.sample::<L>(at), L::splat(0.5)));
            let alpha = L::gather_f32(rays.alpha.as_ptr(), index);
            transmittance = L::mul(transmittance, L::select(active, L::sub(one, alpha), one));
            if LISTED {
                left = L::and_i(left, L::sub_i(left, L::splat_i(1)));
            } else {
                steps = L::add(steps, step);
                left = L::to_bits(L::sub(L::from_bits(left), one));
            }
        }
    }
}

/// The places of the lowest bits of `words`, and where there is one.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
unsafe fn lowest_bit<L: Lanes>(words: L::I) -> (L::F, L::M) {
    // SAFETY: the caller's.
    unsafe {
        let lowest = L::and_i(words, L::sub_i(L::splat_i(0), words));
        // A power of two, negative if it is the sign bit: its place is the exponent.
        let power = L::abs(L::to_f32(lowest));
        let exponent = L::sub_i(L::shr_i::<23>(L::to_bits(power)), L::splat_i(127));
        (L::to_f32(exponent), L::gt(power, L::splat(0.0)))
    }
}
