//! The tracing of shadow rays in lanes.
//!
//! A ray is traced part by part. A part is the samples that one word of its column lists (light_columns.rs), or all of
//! its samples where no columns are given. The first parts of all rays are traced first, then the next parts of those
//! that still see light, and so on. Parts are thus found and assigned to lanes in vectors.

use super::field::{Field, Texel};
use super::light_columns::{LightColumns, SLABS};
use super::march::DARK;
use super::shadow_pool::ShadowPool;
use crate::scene::{LightPath, SHADOW_START, SHADOW_STEP};
use fovol_simd::{MOST_LANES, Simd, SimdF32, SimdF32Op, SimdI32};

/// Matter that absorbs the light of shadow rays.
pub trait Absorber {
    /// α of one shadow step at `p`.
    fn alpha<V: SimdF32>(&self, p: [V; 3]) -> V;

    /// Runs `work` with vectors of `simd`.
    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output;
}

/// One volume whose values alone decide how much it absorbs.
pub struct ByValue<'a, 'v, T: Texel> {
    /// The volume, scaled to indices of `alpha`.
    pub field: &'a Field<'v, T>,
    /// α of one shadow step.
    pub alpha: &'a [f32],
}

impl<T: Texel> Absorber for ByValue<'_, '_, T> {
    #[inline(always)]
    fn alpha<V: SimdF32>(&self, p: [V; 3]) -> V {
        let index = (self.field.sample(p) + p[0].splat(0.5)).to_i32();
        // SAFETY: fields are scaled to indices of the table.
        unsafe { V::gather(self.alpha, index) }
    }

    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        T::in_vectors(simd, work)
    }
}

/// The scene that shadow rays are traced through.
pub struct ShadowRays<'a, A> {
    /// The matter on their way.
    pub absorber: A,
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
    fn load<V: SimdF32>(&self, zero: V, column: usize, at: usize) -> V {
        debug_assert!(at + V::N <= self.columns[column].len());
        // SAFETY: `begin` left a vector's room after the last part.
        zero.load(unsafe { self.columns[column].get_unchecked(at..at + V::N) })
    }

    #[inline(always)]
    fn store<V: SimdF32>(&mut self, column: usize, at: usize, v: V) {
        debug_assert!(at + V::N <= self.columns[column].len());
        // SAFETY: see `load`.
        v.store(unsafe { self.columns[column].get_unchecked_mut(at..at + V::N) });
    }

    /// Makes a part for every ray of `pool`: all of its samples, or none before [`Self::advance`] finds some.
    #[inline(always)]
    fn begin<V: SimdF32, A>(&mut self, zero: V, pool: &ShadowPool, rays: &ShadowRays<'_, A>) {
        self.len = pool.len();
        let room = self.len + 4 * MOST_LANES;
        if self.columns[0].len() < room {
            self.columns.iter_mut().for_each(|column| column.resize(room.next_power_of_two(), 0.0));
        }
        let mut at = 0;
        while at < self.len {
            let p = pool.positions(zero, at);
            (0..3).for_each(|a| self.store(X + a, at, p[a]));
            let count = V::from_i32(rays.light.counts(p));
            self.store(LIGHT, at, zero.splat(1.0));
            self.store(STEPS, at, zero.splat(SHADOW_START));
            self.store(LEFT, at, count);
            let places = zero.iota().to_i32() + zero.splat_i32(at as i32);
            self.store(SAMPLE, at, V::from_bits(places));
            if let Some(columns) = rays.columns {
                let (column, slab) = columns.locate(p);
                let first = V::from_i32(slab);
                self.store(COLUMN, at, V::from_bits(column));
                self.store(FIRST, at, first);
                self.store(END, at, first + count);
                self.store(WORD, at, V::from_i32(slab.shr::<{ SLABS.ilog2() }>()));
            }
            at += V::N;
        }
    }

    /// Advances every ray that still sees light to its next part with samples.
    ///
    /// Rays that are dark or have no such part end; their transmittance goes to `arrived`.
    #[inline(always)]
    fn advance<V: SimdF32>(&mut self, zero: V, columns: &LightColumns, arrived: &mut [f32]) {
        let (len, mut kept) = (self.len, 0);
        let mut at = 0;
        while at < len {
            let inside = zero.iota().simd_lt(zero.splat((len - at) as f32));
            let going = inside & self.load(zero, LIGHT, at).simd_gt(zero.splat(DARK));
            let found = self.next_words(zero, columns, at, going);
            let mut gone = V::bits_of(inside) & !V::bits_of(found);
            while gone != 0 {
                let part = at + gone.trailing_zeros() as usize;
                gone &= gone - 1;
                arrived[self.columns[SAMPLE][part].to_bits() as usize] = self.columns[LIGHT][part];
            }
            for column in 0..self.columns.len() {
                let v = self.load(zero, column, at);
                // SAFETY: see `load`; `kept` is at most `at`.
                v.compress(found, unsafe { self.columns[column].get_unchecked_mut(kept..kept + V::N) });
            }
            kept += V::bits_of(found).count_ones() as usize;
            at += V::N;
        }
        self.len = kept;
    }

    /// Finds the next word with samples for each of the rays from `at` on that are `going`.
    ///
    /// Stores the next parts of these rays, and returns the rays that have one.
    #[inline(always)]
    fn next_words<V: SimdF32>(
        &mut self,
        zero: V,
        columns: &LightColumns,
        at: usize,
        going: V::Mask,
    ) -> V::Mask {
        let (one, slabs) = (zero.splat(1.0), zero.splat(SLABS as f32));
        let (first, end) = (self.load(zero, FIRST, at), self.load(zero, END, at));
        let column = self.load(zero, COLUMN, at).to_bits();
        let mut word = self.load(zero, WORD, at);
        let (mut samples, mut start) = (zero.splat_i32(0), word * slabs);
        let mut searching = going & start.simd_lt(end);
        while V::bits_of(searching) != 0 {
            // SAFETY: `locate` gave the columns, and words are searched between the first and last slab of rays.
            let listed = unsafe { columns.words(searching, column, word) };
            let after = zero.splat_i32(-1).shl_lanes((first - start).max(zero).to_i32());
            let beyond = (slabs - (end - start)).max(zero);
            let before = zero.splat_i32(-1).shr_lanes(beyond.to_i32());
            let listed = listed & (after & before);
            samples = V::select(searching, V::from_bits(listed), V::from_bits(samples)).to_bits();
            word = V::select(searching, word + one, word);
            let empty = V::from_i32(samples).abs().simd_lt(one);
            start = V::select(searching & empty, start + slabs, start);
            searching = searching & empty & start.simd_lt(end);
        }
        self.store(WORD, at, word);
        self.store(LEFT, at, V::from_bits(samples));
        self.store(STEPS, at, (start - first).mul_add(zero.splat(SHADOW_STEP), zero.splat(SHADOW_START)));
        V::from_i32(samples).abs().simd_gt(zero)
    }

    /// Takes the samples of all parts: the listed ones (`LISTED`), or all; returns how many that were.
    #[inline(always)]
    fn trace<const LISTED: bool, V: SimdF32, A: Absorber>(
        &mut self,
        zero: V,
        rays: &ShadowRays<'_, A>,
    ) -> u64 {
        let (one, step) = (zero.splat(1.0), zero.splat(SHADOW_STEP));
        let [dx, dy, dz] = rays.light.delta;
        let delta = [zero.splat(dx), zero.splat(dy), zero.splat(dz)];
        let mut bundle = Bundle::new(zero);
        let mut taken = 0u64;
        loop {
            // Without columns, `left` is the number of samples.
            let (place, has_samples) =
                if LISTED { lowest_bit(bundle.left.to_bits()) } else { (zero, bundle.left.simd_gt(zero)) };
            let active = has_samples & bundle.light.simd_gt(zero.splat(DARK));
            let running = V::bits_of(active);
            let idle = V::N as u32 - running.count_ones();
            if running == 0 || (bundle.next < self.len && idle * 4 >= V::N as u32) {
                if !bundle.refill(running, self) {
                    return taken;
                }
                continue;
            }
            let ahead = if LISTED { place.mul_add(step, bundle.steps) } else { bundle.steps };
            let p = bundle.position;
            let at =
                [ahead.mul_add(delta[0], p[0]), ahead.mul_add(delta[1], p[1]), ahead.mul_add(delta[2], p[2])];
            taken += u64::from(running.count_ones());
            let alpha = rays.absorber.alpha(at);
            bundle.light = bundle.light * V::select(active, one - alpha, one);
            if LISTED {
                let left = bundle.left.to_bits();
                bundle.left = V::from_bits(left & (left - zero.splat_i32(1)));
            } else {
                bundle.steps = bundle.steps + step;
                bundle.left = bundle.left - one;
            }
        }
    }
}

/// A part for each lane.
struct Bundle<V: SimdF32> {
    position: [V; 3],
    light: V,
    steps: V,
    left: V,
    /// Which part.
    part: [u32; MOST_LANES],
    /// The next part that no lane has had.
    next: usize,
}

/// The part of an idle lane.
const NONE: u32 = u32::MAX;

impl<V: SimdF32> Bundle<V> {
    #[inline(always)]
    fn new(zero: V) -> Self {
        let part = [NONE; MOST_LANES];
        Self { position: [zero; 3], light: zero, steps: zero, left: zero, part, next: 0 }
    }

    /// Delivers the light of all lanes that are not `running` and gives them the next of `parts`; false if no lane has
    /// one any more.
    #[inline(always)]
    fn refill(&mut self, running: u32, parts: &mut Parts) -> bool {
        let mut light = [0.0f32; MOST_LANES];
        self.light.store(&mut light);
        let (mut idle, mut refilled) = (!running & (u32::MAX >> (32 - V::N)), 0u32);
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
        let lanes = self.light.mask_of(refilled);
        // SAFETY: `begin` left a vector's room after the last part, and `first` is one of the parts.
        let from = |column: usize| unsafe { parts.columns[column].get_unchecked(first..first + V::N) };
        let [x, y, z] = self.position;
        self.position =
            [x.expand(lanes, from(X)), y.expand(lanes, from(X + 1)), z.expand(lanes, from(X + 2))];
        self.light = self.light.expand(lanes, from(LIGHT));
        self.steps = self.steps.expand(lanes, from(STEPS));
        self.left = self.left.expand(lanes, from(LEFT));
        true
    }
}

impl<A: Absorber> ShadowRays<'_, A> {
    /// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
    ///
    /// An operation of its own, so that both kinds of integration share the compiled code.
    pub fn trace(&self, simd: Simd, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        A::in_vectors(simd, Trace { rays: self, pool, parts })
    }
}

/// Shadow rays to trace in vectors.
struct Trace<'a, A> {
    rays: &'a ShadowRays<'a, A>,
    pool: &'a mut ShadowPool,
    parts: &'a mut Parts,
}

impl<A: Absorber> SimdF32Op for Trace<'_, A> {
    type Output = u64;

    #[inline(always)]
    fn run<V: SimdF32>(self, zero: V) -> u64 {
        let Self { rays, pool, parts } = self;
        parts.begin(zero, pool, rays);
        let arrived = pool.transmittance();
        let Some(columns) = rays.columns else {
            let taken = parts.trace::<false, V, A>(zero, rays);
            arrived.copy_from_slice(&parts.columns[LIGHT][..parts.len]);
            return taken;
        };
        let mut taken = 0;
        loop {
            parts.advance(zero, columns, arrived);
            if parts.len == 0 {
                return taken;
            }
            taken += parts.trace::<true, V, A>(zero, rays);
        }
    }
}

/// The places of the lowest bits of `words`, and where there is one.
#[inline(always)]
fn lowest_bit<V: SimdF32>(words: V::I32) -> (V, V::Mask) {
    let lowest = words & (words.splat(0) - words);
    // A power of two, negative if it is the sign bit: its place is the exponent.
    let power = V::from_i32(lowest).abs();
    let exponent = power.to_bits().shr::<23>() - words.splat(127);
    (V::from_i32(exponent), power.simd_gt(power.splat(0.0)))
}
