//! Marching in lanes: consecutive samples of one ray side by side.

use super::field::{Field, Texel};
use super::lanes::{Lanes, MOST_LANES};
use super::light_columns::LightColumns;
use super::march::{OPAQUE, SampleCount};
use super::packet::Packet;
use super::shadow_pool::ShadowPool;
use super::shadow_rays::{Parts, ShadowRays, trace};
use super::skip::Skip;
use crate::scene::{LightPath, MAX_BLUE, MAX_RED_GREEN, RayResult, Segments, TransferTable};
use fovol_core::{Pixel, RayBasis};

/// How light reaches samples.
pub enum Lighting<'a> {
    /// In full: no shadows.
    Full,
    /// Along a shadow ray from every sample. The columns say which samples to skip, where skipping pays.
    Rays(Option<&'a LightColumns>),
    /// By transmittance from the shadow grid, at half the resolution.
    Cached(Field<'a, u8>),
}

/// The scene that SIMD lanes march primary rays through.
pub struct Kernel<'a, T> {
    /// The volume, scaled to indices of the table.
    pub field: Field<'a, T>,
    /// Where primary rays take their samples.
    pub segments: Segments,
    /// The edges of a voxel in world units.
    pub voxel_size: [f32; 3],
    /// Display value to colour and opacity.
    pub table: &'a TransferTable,
    /// Bounds of the table's visible part; see [`TransferTable::visible`].
    pub visible: [f32; 2],
    /// The way to the light.
    pub light: LightPath,
    /// How light reaches samples.
    pub lighting: Lighting<'a>,
    /// The light direction in world space where surfaces are shaded by their gradient.
    pub facing: Option<[f32; 3]>,
    /// The share of light that reaches every sample.
    pub ambient: f32,
    /// The background colour, RGB.
    pub background: [f32; 3],
    /// Empty space, where skipping it pays.
    pub skip: Option<Skip<'a>>,
}

/// The sums of one ray so far.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Gathered {
    /// One sum per lane: red, green, blue, opacity, and the opacity's share of the samples' numbers.
    sums: [[f32; MOST_LANES]; 5],
    /// The number of the sample that took opacity past one half; negative before.
    half_at: f32,
    /// The ray's first sample and step.
    start: [f32; 3],
    delta: [f32; 3],
}

impl Gathered {
    const NOTHING: Self =
        Self { sums: [[0.0; MOST_LANES]; 5], half_at: -1.0, start: [0.0; 3], delta: [0.0; 3] };
}

/// The samples that one block of a ray put into the pool.
struct Waiting {
    ray: usize,
    from: usize,
    to: usize,
}

/// Memory that marching reuses.
pub struct Scratch {
    packet: Packet,
    pool: ShadowPool,
    parts: Parts,
    gathered: Vec<Gathered>,
    waiting: Vec<Waiting>,
}

impl Default for Scratch {
    fn default() -> Self {
        Self {
            packet: Packet::new(),
            pool: ShadowPool::default(),
            parts: Parts::default(),
            gathered: Vec::new(),
            waiting: Vec::new(),
        }
    }
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
        pixels: &[Pixel],
        scratch: &mut Scratch,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let eye = self.segments.in_voxels(rays.origin());
        let mut count = SampleCount::default();
        for pixels in pixels.chunks(L::N) {
            scratch.packet.fill(pixels, rays, &self.segments);
            if scratch.packet.is_empty() && scratch.gathered.is_empty() {
                out.extend(pixels.iter().map(|_| RayResult::nothing(self.background)));
                continue;
            }
            // SAFETY: the caller's.
            unsafe {
                count.primary += self.primary::<L>(scratch);
                if scratch.pool.is_empty() || scratch.pool.len() >= ENOUGH {
                    count.shadow += self.finish::<L>(eye, scratch, out);
                }
            }
        }
        // SAFETY: the caller's.
        count.shadow += unsafe { self.finish::<L>(eye, scratch, out) };
        count
    }

    /// Composites the rays of the packet. Where shadow rays are wanted, lit samples go to the pool and
    /// only their ambient part is in the sums.
    #[inline(always)]
    unsafe fn primary<L: Lanes>(&self, scratch: &mut Scratch) -> u64 {
        let Scratch { packet, pool, gathered, waiting, .. } = scratch;
        let first = gathered.len();
        gathered.resize(first + packet.len, Gathered::NOTHING);
        if packet.is_empty() {
            return 0;
        }
        for (lane, ray) in gathered[first..].iter_mut().enumerate() {
            for a in 0..3 {
                ray.start[a] = packet.start[a].0[lane];
                ray.delta[a] = packet.delta[a].0[lane];
            }
        }
        if matches!(self.lighting, Lighting::Rays(_)) {
            let most: f32 = packet.samples.0.iter().sum();
            pool.reserve(most as usize + packet.len * L::N);
        }
        let mut count = 0;
        loop {
            // SAFETY: the caller's.
            let mut going = unsafe {
                match &self.skip {
                    Some(skip) => skip.advance::<L>(packet, 0.0),
                    None => packet.going::<L>(),
                }
            };
            if going == 0 {
                return count;
            }
            while going != 0 {
                let lane = going.trailing_zeros() as usize;
                going &= going - 1;
                let from = pool.len();
                // SAFETY: the caller's.
                count += unsafe { self.block::<L>(packet, lane, &mut gathered[first + lane], pool) };
                if pool.len() > from {
                    waiting.push(Waiting { ray: first + lane, from, to: pool.len() });
                }
            }
        }
    }

    /// Traces the waiting shadow rays and appends the colours of all gathered rays to `out`.
    #[inline(always)]
    unsafe fn finish<L: Lanes>(&self, eye: [f32; 3], scratch: &mut Scratch, out: &mut Vec<RayResult>) -> u64 {
        let rays = ShadowRays {
            field: &self.field,
            alpha: &self.table.shadow_alpha,
            light: &self.light,
            columns: if let Lighting::Rays(columns) = self.lighting { columns } else { None },
        };
        // SAFETY: the caller's; sums hold at least N elements.
        unsafe {
            let samples = trace::<L, T>(&rays, &mut scratch.pool, &mut scratch.parts);
            for block in &scratch.waiting {
                let [r, g, b, ..] = &mut scratch.gathered[block.ray].sums;
                let sums = [L::load(r.as_ptr()), L::load(g.as_ptr()), L::load(b.as_ptr())];
                let [lit_r, lit_g, lit_b] = scratch.pool.arriving::<L>(block.from, block.to, sums);
                L::store(lit_r, r.as_mut_ptr());
                L::store(lit_g, g.as_mut_ptr());
                L::store(lit_b, b.as_mut_ptr());
            }
            // Closures would be compiled without the instruction set.
            out.reserve(scratch.gathered.len());
            for ray in &scratch.gathered {
                out.push(self.marched::<L>(eye, ray));
            }
            scratch.gathered.clear();
            scratch.waiting.clear();
            scratch.pool.clear();
            samples
        }
    }

    /// The result of a finished ray from its sums; `eye` in voxel-centre coordinates.
    #[inline(always)]
    unsafe fn marched<L: Lanes>(&self, eye: [f32; 3], ray: &Gathered) -> RayResult {
        // SAFETY: sums hold at least N elements.
        unsafe {
            let [r, g, b, opacity, numbers] = &ray.sums;
            let opacity = L::load(opacity.as_ptr());
            if L::bits(L::gt(opacity, L::splat(0.0))) == 0 {
                return RayResult::nothing(self.background);
            }
            let whole = L::sum(opacity);
            let opacity = whole.min(1.0);
            let mut colour =
                [L::sum(L::load(r.as_ptr())), L::sum(L::load(g.as_ptr())), L::sum(L::load(b.as_ptr()))];
            for (sum, background) in colour.iter_mut().zip(&self.background) {
                *sum += (1.0 - opacity) * background;
            }
            let mean = L::sum(L::load(numbers.as_ptr())) / whole;
            let number = if ray.half_at < 0.0 { mean } else { ray.half_at };
            let depth = self.segments.distance(eye, ray.start, ray.delta, number);
            RayResult { colour, opacity, depth }
        }
    }

    /// Composites the next N samples of ray `lane`; returns how many of them counted.
    #[inline(always)]
    unsafe fn block<L: Lanes>(
        &self,
        packet: &mut Packet,
        lane: usize,
        ray: &mut Gathered,
        pool: &mut ShadowPool,
    ) -> u64 {
        // SAFETY: table indices come from display values in 0…1 scaled to the table; sums hold at least N
        // elements.
        unsafe {
            let (zero, one) = (L::splat(0.0), L::splat(1.0));
            let number = L::add(L::splat(packet.next.0[lane]), L::iota());
            packet.next.0[lane] += L::N as f32;
            let p = [
                L::fma(number, L::splat(packet.delta[0].0[lane]), L::splat(packet.start[0].0[lane])),
                L::fma(number, L::splat(packet.delta[1].0[lane]), L::splat(packet.start[1].0[lane])),
                L::fma(number, L::splat(packet.delta[2].0[lane]), L::splat(packet.start[2].0[lane])),
            ];
            let value = L::add(self.field.sample::<L>(p), L::splat(0.5));
            let inside = L::lt(number, L::splat(packet.samples.0[lane]));
            let [first, end] = self.visible;
            let shown = L::and_m(L::gt(value, L::splat(first)), L::lt(value, L::splat(end)));
            let shown = L::and_m(inside, shown);
            if L::bits(shown) == 0 {
                return u64::from(L::bits(inside).count_ones());
            }
            let index = L::truncate(value);
            let base = self.table.appearance.as_ptr().cast();
            let (alpha, packed) = L::gather_words(base, L::add_i(index, index));
            let alpha = L::select(shown, L::from_bits(alpha), zero);
            let (before, through) = L::products_before(L::sub(one, alpha));
            let before = L::mul(before, L::splat(packet.transmittance.0[lane]));
            let arriving = packet.transmittance.0[lane];
            packet.transmittance.0[lane] = arriving * through;
            if arriving > 0.5 && arriving * through <= 0.5 {
                let clear = L::gt(L::mul(before, L::sub(one, alpha)), L::splat(0.5));
                ray.half_at = packet.next.0[lane] - L::N as f32 + L::bits(clear).trailing_ones() as f32;
            }
            let going = L::and_m(inside, L::gt(before, L::splat(1.0 - OPAQUE)));
            let weight = L::select(going, L::mul(alpha, before), zero);
            let [r, g, b, opacity, numbers] = &mut ray.sums;
            L::store(L::add(L::load(opacity.as_ptr()), weight), opacity.as_mut_ptr());
            L::store(L::fma(weight, number, L::load(numbers.as_ptr())), numbers.as_mut_ptr());
            let mut colour = [L::load(r.as_ptr()), L::load(g.as_ptr()), L::load(b.as_ptr())];
            let rgb = colours::<L>(packed);
            self.light_samples::<L>(p, weight, rgb, &mut colour, pool);
            L::store(colour[0], r.as_mut_ptr());
            L::store(colour[1], g.as_mut_ptr());
            L::store(colour[2], b.as_mut_ptr());
            u64::from(L::bits(going).count_ones())
        }
    }

    /// Adds the light that samples of `weight` and colour `rgb` at `p` send to the eye to `colour`.
    ///
    /// With shadow rays it adds the ambient part only; the samples then wait in `pool`.
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
                Lighting::Rays(_) => {
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

    /// |n·l| at `p`; 1 where the gradient is zero or not known.
    #[inline(always)]
    pub(super) unsafe fn facing<L: Lanes>(&self, p: [L::F; 3], light: [f32; 3]) -> L::F {
        // SAFETY: the caller's.
        unsafe {
            let one = L::splat(1.0);
            let mut squared = L::splat(0.0);
            let mut along = L::splat(0.0);
            let mut highest = L::splat(0.0);
            for a in 0..3 {
                let (mut before, mut after) = (p, p);
                before[a] = L::sub(p[a], one);
                after[a] = L::add(p[a], one);
                let (after, before) = (self.field.sample::<L>(after), self.field.sample::<L>(before));
                if T::GAPS {
                    highest = L::max(highest, L::max(after, before));
                }
                let difference = L::sub(after, before);
                // Only the ratios of the components matter, so the field's own scale may stay.
                let g = L::mul(difference, L::splat(1.0 / self.voxel_size[a]));
                squared = L::fma(g, g, squared);
                along = L::fma(g, L::splat(light[a]), along);
            }
            let facing = L::abs(L::div(along, L::sqrt(squared)));
            let known = L::gt(squared, L::splat(0.0));
            // Beside NaN there is no gradient.
            let known =
                if T::GAPS { L::and_m(known, L::lt(highest, L::splat(self.field.missing))) } else { known };
            L::select(known, facing, one)
        }
    }
}

/// Unpacks colours of a [`TransferTable`].
#[inline(always)]
pub(super) unsafe fn colours<L: Lanes>(packed: L::I) -> [L::F; 3] {
    // SAFETY: the caller's.
    unsafe {
        let field = L::splat_i(MAX_RED_GREEN as i32);
        [
            L::mul(L::to_f32(L::and_i(packed, field)), L::splat(1.0 / MAX_RED_GREEN)),
            L::mul(L::to_f32(L::and_i(L::shr_i::<11>(packed), field)), L::splat(1.0 / MAX_RED_GREEN)),
            L::mul(L::to_f32(L::shr_i::<22>(packed)), L::splat(1.0 / MAX_BLUE)),
        ]
    }
}
