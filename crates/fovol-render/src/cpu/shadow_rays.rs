//! The tracing of shadow rays in lanes.
//!
//! A ray is traced part by part. A part is the samples that one word of its column lists (light_columns.rs), or all of
//! its samples where no columns are given. The first parts of all rays are traced first, then the next parts of those
//! that still see light, and so on. Parts are thus found and assigned to lanes in vectors.

use super::field::{Field, Texel};
use super::lanes::{Lanes, MOST_LANES};
use super::light_columns::{LightColumns, SLABS};
use super::march::DARK;
use super::shadow_pool::ShadowPool;
use crate::scene::{LightPath, SHADOW_START, SHADOW_STEP};

/// The scene that shadow rays are traced through.
pub struct ShadowRays<'a, T> {
    /// The volume, scaled to indices of `alpha`.
    pub field: &'a Field<'a, T>,
    /// α of one shadow step.
    pub alpha: &'a [f32],
    /// The way to the light.
    pub light: &'a LightPath,
    /// Which samples can have opacity; `None` where skipping the others does not pay.
    pub columns: Option<&'a LightColumns>,
}

/// Parts of shadow rays, at most one of each.
#[derive(Default)]
pub struct Parts {
    /// One column per field, indexed by [`X`] to [`WORD`]. Integers are stored as the bits of an f32 where noted.
    columns: [Vec<f32>; 11],
    len: usize,
}

/// Where the ray starts: x, and after it y and z.
const X: usize = 0;
/// The transmittance so far, 0…1.
const LIGHT: usize = 3;
/// Δ from the start to the sample of the lowest bit of [`LEFT`], or to the next one.
const STEPS: usize = 4;
/// The samples of this part: one bit (of 32) for each, or their number where no columns are given.
const LEFT: usize = 5;
/// The sample's index in the pool, as bits.
const SAMPLE: usize = 6;
/// The column of the ray, as bits.
const COLUMN: usize = 7;
/// The slab of the ray's first sample.
const FIRST: usize = 8;
/// The slab after the ray's last sample.
const END: usize = 9;
/// The word of the column that follows this part.
const WORD: usize = 10;

impl Parts {
    /// The vectors of `column` from `at` on.
    #[inline(always)]
    unsafe fn load<L: Lanes>(&self, column: usize, at: usize) -> L::F {
        debug_assert!(at < self.columns[column].len());
        // SAFETY: `begin` left a vector's room after the last part.
        unsafe { L::load(self.columns[column].as_ptr().add(at)) }
    }

    #[inline(always)]
    unsafe fn store<L: Lanes>(&mut self, column: usize, at: usize, v: L::F) {
        // SAFETY: as `load`.
        unsafe { L::store(v, self.columns[column].as_mut_ptr().add(at)) }
    }

    /// Makes a part for every ray of `pool`: all of its samples, or none before [`Self::advance`] finds some.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    unsafe fn begin<L: Lanes, T>(&mut self, pool: &ShadowPool, rays: &ShadowRays<'_, T>) {
        self.len = pool.len();
        let room = self.len + 4 * MOST_LANES;
        if self.columns[0].len() < room {
            self.columns.iter_mut().for_each(|column| column.resize(room.next_power_of_two(), 0.0));
        }
        let mut at = 0;
        while at < self.len {
            // SAFETY: there is room for all samples and a vector more.
            unsafe {
                let p = pool.positions::<L>(at);
                (0..3).for_each(|a| self.store::<L>(X + a, at, p[a]));
                let count = L::to_f32(rays.light.counts::<L>(p));
                self.store::<L>(LIGHT, at, L::splat(1.0));
                self.store::<L>(STEPS, at, L::splat(SHADOW_START));
                self.store::<L>(LEFT, at, count);
                let places = L::add_i(L::truncate(L::iota()), L::splat_i(at as i32));
                self.store::<L>(SAMPLE, at, L::from_bits(places));
                if let Some(columns) = rays.columns {
                    let (column, slab) = columns.locate::<L>(p);
                    let first = L::to_f32(slab);
                    self.store::<L>(COLUMN, at, L::from_bits(column));
                    self.store::<L>(FIRST, at, first);
                    self.store::<L>(END, at, L::add(first, count));
                    self.store::<L>(WORD, at, L::to_f32(L::shr_i::<{ SLABS.ilog2() }>(slab)));
                }
            }
            at += L::N;
        }
    }

    /// Advances every ray that still sees light to its next part with samples.
    ///
    /// Rays that are dark or have no such part end; their transmittance goes to `arrived`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available; the parts must be of the rays that `arrived` is of.
    #[inline(always)]
    unsafe fn advance<L: Lanes>(&mut self, columns: &LightColumns, arrived: &mut [f32]) {
        let (len, mut kept) = (self.len, 0);
        let mut at = 0;
        while at < len {
            // SAFETY: words are looked up in columns and slabs that `locate` gave.
            unsafe {
                let inside = L::lt(L::iota(), L::splat((len - at) as f32));
                let going = L::and_m(inside, L::gt(self.load::<L>(LIGHT, at), L::splat(DARK)));
                let found = self.next_words::<L>(columns, at, going);
                let mut gone = L::bits(inside) & !L::bits(found);
                while gone != 0 {
                    let part = at + gone.trailing_zeros() as usize;
                    gone &= gone - 1;
                    arrived[self.columns[SAMPLE][part].to_bits() as usize] = self.columns[LIGHT][part];
                }
                for column in 0..self.columns.len() {
                    let v = self.load::<L>(column, at);
                    L::compress(v, found, self.columns[column].as_mut_ptr().add(kept));
                }
                kept += L::bits(found).count_ones() as usize;
            }
            at += L::N;
        }
        self.len = kept;
    }

    /// Finds the next word with samples for each of the rays from `at` on that are `going`.
    ///
    /// Stores the next parts of these rays, and returns the rays that have one.
    #[inline(always)]
    unsafe fn next_words<L: Lanes>(&mut self, columns: &LightColumns, at: usize, going: L::M) -> L::M {
        // SAFETY: the caller's.
        unsafe {
            let (zero, one, slabs) = (L::splat(0.0), L::splat(1.0), L::splat(SLABS as f32));
            let (first, end) = (self.load::<L>(FIRST, at), self.load::<L>(END, at));
            let column = L::to_bits(self.load::<L>(COLUMN, at));
            let mut word = self.load::<L>(WORD, at);
            let (mut samples, mut start) = (L::splat_i(0), L::mul(word, slabs));
            let mut searching = L::and_m(going, L::lt(start, end));
            while L::bits(searching) != 0 {
                let listed = columns.words::<L>(searching, column, word);
                let after = L::shift_left(L::splat_i(-1), L::truncate(L::max(L::sub(first, start), zero)));
                let beyond = L::max(L::sub(slabs, L::sub(end, start)), zero);
                let before = L::shift_right(L::splat_i(-1), L::truncate(beyond));
                let listed = L::and_i(listed, L::and_i(after, before));
                samples = L::to_bits(L::select(searching, L::from_bits(listed), L::from_bits(samples)));
                word = L::select(searching, L::add(word, one), word);
                let empty = L::lt(L::abs(L::to_f32(samples)), one);
                start = L::select(L::and_m(searching, empty), L::add(start, slabs), start);
                searching = L::and_m(L::and_m(searching, empty), L::lt(start, end));
            }
            self.store::<L>(WORD, at, word);
            self.store::<L>(LEFT, at, L::from_bits(samples));
            self.store::<L>(
                STEPS,
                at,
                L::fma(L::sub(start, first), L::splat(SHADOW_STEP), L::splat(SHADOW_START)),
            );
            L::gt(L::abs(L::to_f32(samples)), zero)
        }
    }

    /// Takes the samples of all parts: the listed ones (`LISTED`), or all; returns how many that were.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    unsafe fn trace<L: Lanes, T: Texel, const LISTED: bool>(&mut self, rays: &ShadowRays<'_, T>) -> u64 {
        // SAFETY: table indices come from display values in 0…1 scaled to the table.
        unsafe {
            let (zero, one, step) = (L::splat(0.0), L::splat(1.0), L::splat(SHADOW_STEP));
            let delta = rays.light.delta.map(|d| L::splat(d));
            let mut bundle = Bundle::<L>::new();
            let mut taken = 0u64;
            loop {
                // Without columns, `left` is the number of samples.
                let (place, has_samples) = if LISTED {
                    lowest_bit::<L>(L::to_bits(bundle.left))
                } else {
                    (zero, L::gt(bundle.left, zero))
                };
                let active = L::and_m(has_samples, L::gt(bundle.light, L::splat(DARK)));
                let running = L::bits(active);
                let idle = L::N as u32 - running.count_ones();
                if running == 0 || (bundle.next < self.len && idle * 4 >= L::N as u32) {
                    if !bundle.refill(running, self) {
                        return taken;
                    }
                    continue;
                }
                let ahead = if LISTED { L::fma(place, step, bundle.steps) } else { bundle.steps };
                let p = bundle.position;
                let at = [
                    L::fma(ahead, delta[0], p[0]),
                    L::fma(ahead, delta[1], p[1]),
                    L::fma(ahead, delta[2], p[2]),
                ];
                taken += u64::from(running.count_ones());
                let index = L::truncate(L::add(rays.field.sample::<L>(at), L::splat(0.5)));
                let alpha = L::gather_f32(rays.alpha.as_ptr(), index);
                bundle.light = L::mul(bundle.light, L::select(active, L::sub(one, alpha), one));
                if LISTED {
                    let left = L::to_bits(bundle.left);
                    bundle.left = L::from_bits(L::and_i(left, L::sub_i(left, L::splat_i(1))));
                } else {
                    bundle.steps = L::add(bundle.steps, step);
                    bundle.left = L::sub(bundle.left, one);
                }
            }
        }
    }
}

/// A part for each lane.
struct Bundle<L: Lanes> {
    position: [L::F; 3],
    light: L::F,
    steps: L::F,
    left: L::F,
    /// Which part.
    part: [u32; MOST_LANES],
    /// The next part that no lane has had.
    next: usize,
}

/// The part of an idle lane.
const NONE: u32 = u32::MAX;

impl<L: Lanes> Bundle<L> {
    #[inline(always)]
    unsafe fn new() -> Self {
        // SAFETY: the caller's.
        unsafe {
            let zero = L::splat(0.0);
            let part = [NONE; MOST_LANES];
            Self { position: [zero; 3], light: zero, steps: zero, left: zero, part, next: 0 }
        }
    }

    /// Delivers the light of all lanes that are not `running` and gives them the next of `parts`; false if no lane has
    /// one any more.
    #[inline(always)]
    unsafe fn refill(&mut self, running: u32, parts: &mut Parts) -> bool {
        // SAFETY: there is room for a vector after the last part; arrays hold at least N elements.
        unsafe {
            let mut light = [0.0f32; MOST_LANES];
            L::store(self.light, light.as_mut_ptr());
            let (mut idle, mut refilled) = (!running & (u32::MAX >> (32 - L::N)), 0u32);
            let first = self.next;
            while idle != 0 {
                let lane = idle.trailing_zeros() as usize;
                idle &= idle - 1;
                if self.part[lane] != NONE {
                    parts.columns[LIGHT][self.part[lane] as usize] = light[lane];
                    self.part[lane] = NONE;
                }
                if self.next < parts.len {
                    self.part[lane] = self.next as u32;
                    self.next += 1;
                    refilled |= 1 << lane;
                }
            }
            if refilled == 0 {
                return running != 0;
            }
            let lanes = L::mask(refilled);
            let from = |column: usize| parts.columns[column].as_ptr().add(first);
            let [x, y, z] = self.position;
            self.position = [
                L::expand(x, lanes, from(X)),
                L::expand(y, lanes, from(X + 1)),
                L::expand(z, lanes, from(X + 2)),
            ];
            self.light = L::expand(self.light, lanes, from(LIGHT));
            self.steps = L::expand(self.steps, lanes, from(STEPS));
            self.left = L::expand(self.left, lanes, from(LEFT));
            true
        }
    }
}

/// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
///
/// # Safety
/// The instruction set of `L` must be available.
#[inline(always)]
pub unsafe fn trace<L: Lanes, T: Texel>(
    rays: &ShadowRays<'_, T>,
    pool: &mut ShadowPool,
    parts: &mut Parts,
) -> u64 {
    // SAFETY: the caller's.
    unsafe {
        parts.begin::<L, T>(pool, rays);
        let arrived = pool.transmittance();
        let Some(columns) = rays.columns else {
            let taken = parts.trace::<L, T, false>(rays);
            arrived.copy_from_slice(&parts.columns[LIGHT][..parts.len]);
            return taken;
        };
        let mut taken = 0;
        loop {
            parts.advance::<L>(columns, arrived);
            if parts.len == 0 {
                return taken;
            }
            taken += parts.trace::<L, T, true>(rays);
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
