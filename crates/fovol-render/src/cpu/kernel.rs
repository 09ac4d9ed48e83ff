//! Marching in lanes: consecutive samples of one ray side by side.

use super::field::{Field, Texel};
use super::lanes::Lanes;
use super::march::{OPAQUE, SampleCount};
use super::segment::{LightPath, Segment};
use super::shadow_pool::{ShadowPool, ShadowRays, trace};
use super::skip::Skip;
use super::transfer_table::{MAX_BLUE, MAX_RED_GREEN, TransferTable};
use fovol_core::{Grid, Pixel, RayBasis};

/// How the light reaches samples.
pub enum Lighting<'a> {
    /// Unhindered.
    Full,
    /// Along a shadow ray from every sample.
    Rays,
    /// As read from a grid of half the resolution.
    Cached(Field<'a, u8>),
}

/// What rays meet, prepared for lanes.
pub struct Kernel<'a, T> {
    /// The volume, scaled to indices of the table.
    pub field: Field<'a, T>,
    /// Its size in the world.
    pub grid: &'a Grid,
    /// Display value to colour and opacity.
    pub table: &'a TransferTable,
    /// The way to the light.
    pub light: LightPath,
    /// How it reaches samples.
    pub lighting: Lighting<'a>,
    /// The light direction in world space where surfaces are shaded by their gradient.
    pub facing: Option<[f32; 3]>,
    /// The share of light that reaches every sample.
    pub ambient: f32,
    /// What shows through.
    pub background: [f32; 3],
    /// The sampling distance in voxels.
    pub step: f64,
    /// Where nothing is, if looking for it pays.
    pub skip: Option<Skip<'a>>,
}

/// A ray whose shadows may still be on their way.
struct Pending {
    colour: [f32; 3],
    opacity: f32,
    /// Its samples in the pool.
    from: usize,
    to: usize,
}

/// Memory that marching uses again and again.
#[derive(Default)]
pub struct Scratch {
    pool: ShadowPool,
    pending: Vec<Pending>,
}

/// Shadow rays are traced once this many samples wait.
const ENOUGH: usize = 8192;

impl<T: Texel> Kernel<'_, T> {
    /// Marches `pixels` and appends their colours (over the background) and opacities to `out`.
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn march<L: Lanes>(
        &self,
        rays: &RayBasis,
        pixels: impl Iterator<Item = Pixel>,
        scratch: &mut Scratch,
        out: &mut Vec<[f32; 4]>,
    ) -> SampleCount {
        let mut count = SampleCount::default();
        scratch.pool.clear();
        scratch.pending.clear();
        for pixel in pixels {
            let ray = rays.ray(u32::from(pixel.x), u32::from(pixel.y));
            let segment = Segment::new(&ray, self.grid, self.step);
            // SAFETY: the caller's.
            let pending = unsafe { self.primary::<L>(&segment, &mut scratch.pool, &mut count) };
            scratch.pending.push(pending);
            if scratch.pool.len() >= ENOUGH {
                // SAFETY: the caller's.
                count.shadow += unsafe { self.finish::<L>(scratch, out) };
            }
        }
        // SAFETY: the caller's.
        count.shadow += unsafe { self.finish::<L>(scratch, out) };
        count
    }

    /// Traces the waiting shadow rays and completes the rays that waited for them.
    #[inline(always)]
    unsafe fn finish<L: Lanes>(&self, scratch: &mut Scratch, out: &mut Vec<[f32; 4]>) -> u64 {
        let rays = ShadowRays {
            field: &self.field,
            alpha: &self.table.shadow_alpha,
            light: &self.light,
            skip: self.skip.as_ref(),
        };
        // SAFETY: the caller's.
        let samples = unsafe { trace::<L, T>(&rays, &mut scratch.pool) };
        for ray in &scratch.pending {
            // SAFETY: the caller's.
            let light = unsafe { scratch.pool.arriving::<L>(ray.from, ray.to) };
            let [r, g, b] =
                std::array::from_fn(|c| ray.colour[c] + light[c] + (1.0 - ray.opacity) * self.background[c]);
            out.push([r, g, b, ray.opacity]);
        }
        scratch.pending.clear();
        scratch.pool.clear();
        samples
    }

    /// Composites one primary ray; where shadow rays are wanted, its lit samples go to `pool` and only
    /// their ambient part is in the colour.
    #[inline(always)]
    unsafe fn primary<L: Lanes>(
        &self,
        segment: &Segment,
        pool: &mut ShadowPool,
        count: &mut SampleCount,
    ) -> Pending {
        // SAFETY: table indices come from display values in 0…1 scaled to the table.
        unsafe {
            let from = pool.len();
            if matches!(self.lighting, Lighting::Rays) {
                pool.reserve(segment.count as usize + L::N);
            }
            let zero = L::splat(0.0);
            let one = L::splat(1.0);
            let clear = L::splat(1.0 - OPAQUE);
            let start = segment.start.map(|s| L::splat(s));
            let delta = segment.delta.map(|d| L::splat(d));
            let samples = L::splat(segment.count as f32);
            let mut colour = [zero; 3];
            let mut opacity = zero;
            let mut transmittance = 1.0f32;
            let mut k = 0u32;
            while k < segment.count && transmittance > 1.0 - OPAQUE {
                if let Some(skip) = &self.skip {
                    let empty = skip.primary_samples(segment, k);
                    if empty > 0 {
                        k += empty;
                        continue;
                    }
                }
                let number = L::add(L::splat(k as f32), L::iota());
                k += L::N as u32;
                let p = [
                    L::fma(number, delta[0], start[0]),
                    L::fma(number, delta[1], start[1]),
                    L::fma(number, delta[2], start[2]),
                ];
                let index = L::truncate(L::add(self.field.sample::<L>(p), L::splat(0.5)));
                let inside = L::lt(number, samples);
                let alpha = L::select(inside, L::gather_f32(self.table.alpha.as_ptr(), index), zero);
                if L::bits(L::gt(alpha, zero)) == 0 {
                    count.primary += u64::from(L::bits(inside).count_ones());
                    continue;
                }
                let (before, through) = L::products_before(L::sub(one, alpha));
                let before = L::mul(before, L::splat(transmittance));
                transmittance *= through;
                let going = L::and_m(inside, L::gt(before, clear));
                count.primary += u64::from(L::bits(going).count_ones());
                let weight = L::select(going, L::mul(alpha, before), zero);
                opacity = L::add(opacity, weight);
                let rgb = self.colours::<L>(index);
                self.light_samples::<L>(p, weight, rgb, &mut colour, pool);
            }
            Pending {
                colour: [L::sum(colour[0]), L::sum(colour[1]), L::sum(colour[2])],
                opacity: L::sum(opacity).min(1.0),
                from,
                to: pool.len(),
            }
        }
    }

    /// Adds what samples of `weight` and colour `rgb` at `p` send towards the eye to `colour`, or what is
    /// known of it before their shadow rays.
    #[inline(always)]
    unsafe fn light_samples<L: Lanes>(
        &self,
        p: [L::F; 3],
        weight: L::F,
        rgb: [L::F; 3],
        colour: &mut [L::F; 3],
        pool: &mut ShadowPool,
    ) {
        // SAFETY: the caller's.
        unsafe {
            let facing = match self.facing {
                Some(light) => self.facing::<L>(p, light),
                None => L::splat(1.0),
            };
            let ambient = L::splat(self.ambient);
            let direct = L::mul(L::splat(1.0 - self.ambient), facing);
            match &self.lighting {
                Lighting::Rays => {
                    let known = L::mul(weight, ambient);
                    let waiting = L::mul(weight, direct);
                    for c in 0..3 {
                        colour[c] = L::fma(known, rgb[c], colour[c]);
                    }
                    let light = [L::mul(waiting, rgb[0]), L::mul(waiting, rgb[1]), L::mul(waiting, rgb[2])];
                    pool.push::<L>(L::gt(weight, L::splat(0.0)), p, light);
                }
                Lighting::Full => {
                    let lit = L::mul(weight, L::add(ambient, direct));
                    for c in 0..3 {
                        colour[c] = L::fma(lit, rgb[c], colour[c]);
                    }
                }
                Lighting::Cached(grid) => {
                    let half = L::splat(0.5);
                    let q = [
                        L::mul(L::sub(p[0], half), half),
                        L::mul(L::sub(p[1], half), half),
                        L::mul(L::sub(p[2], half), half),
                    ];
                    let lit = L::mul(weight, L::fma(direct, grid.sample::<L>(q), ambient));
                    for c in 0..3 {
                        colour[c] = L::fma(lit, rgb[c], colour[c]);
                    }
                }
            }
        }
    }

    /// The colours of table entries.
    #[inline(always)]
    unsafe fn colours<L: Lanes>(&self, index: L::I) -> [L::F; 3] {
        // SAFETY: the caller's indices lie in the table.
        unsafe {
            let words = L::gather::<4>(self.table.colour.as_ptr().cast(), index);
            let field = L::splat_i(MAX_RED_GREEN as i32);
            [
                L::mul(L::to_f32(L::and_i(words, field)), L::splat(1.0 / MAX_RED_GREEN)),
                L::mul(L::to_f32(L::and_i(L::shr_i::<11>(words), field)), L::splat(1.0 / MAX_RED_GREEN)),
                L::mul(L::to_f32(L::shr_i::<22>(words)), L::splat(1.0 / MAX_BLUE)),
            ]
        }
    }

    /// |n·l| at `p`; 1 where the gradient is zero.
    #[inline(always)]
    unsafe fn facing<L: Lanes>(&self, p: [L::F; 3], light: [f32; 3]) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let voxel = self.grid.voxel_size();
            let one = L::splat(1.0);
            let mut squared = L::splat(0.0);
            let mut along = L::splat(0.0);
            for a in 0..3 {
                let (mut before, mut after) = (p, p);
                before[a] = L::sub(p[a], one);
                after[a] = L::add(p[a], one);
                let difference = L::sub(self.field.sample::<L>(after), self.field.sample::<L>(before));
                // Only the ratios of the components matter, so the field's own scale may stay.
                let g = L::mul(difference, L::splat((1.0 / voxel[a]) as f32));
                squared = L::fma(g, g, squared);
                along = L::fma(g, L::splat(light[a]), along);
            }
            let facing = L::abs(L::div(along, L::sqrt(squared)));
            L::select(L::gt(squared, L::splat(0.0)), facing, one)
        }
    }
}
