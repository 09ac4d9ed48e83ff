//! Marching in lanes: consecutive samples of one ray side by side.

use super::few_shadow_rays::{Block, Chooser, FewShadowRays};
use super::field::Field;
use super::light_columns::LightColumns;
use super::march::{OPAQUE, SampleCount};
use super::medium::{Look, Medium, WayToLight, colours};
use super::packet::{Packet, PerRay};
use super::shadow_pool::ShadowPool;
use super::shadow_rays::Parts;
use super::skip::Skip;
use crate::scene::{LightPath, RayResult, SHADOW_START, SHADOW_STEP, Segments};
use fovol_core::{Pixel, RayBasis};
use fovol_simd::{MOST_LANES, Simd, SimdF32};

/// How light reaches samples.
pub enum Lighting<'a> {
    /// In full: no shadows.
    Full,
    /// Along a shadow ray from every sample, or from a few. The columns say which samples to skip, where skipping pays.
    Rays(Option<&'a LightColumns>, Option<FewShadowRays<'a>>),
    /// By transmittance from the shadow grid.
    Cached(Field<'a, u8>),
}

/// The scene that SIMD lanes march primary rays through.
pub struct Kernel<'a, M> {
    /// The medium of the rays.
    pub medium: M,
    /// Where primary rays take their samples.
    pub segments: Segments,
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
    /// The instruction set of shadow rays.
    pub simd: Simd,
}

/// The sums of one ray so far.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Gathered {
    /// One sum per lane: red, green, blue without shadow rays, opacity, and the opacity's share of the samples' numbers.
    sums: [[f32; MOST_LANES]; 5],
    /// Red, green and blue that shadow rays take away, at most 0, one sum per lane.
    shadow: [[f32; MOST_LANES]; 3],
    /// The number of the sample that took opacity past one half; negative before.
    half_at: f32,
    /// How far the ray's first sample is from its origin, in world units.
    first: f32,
    /// The noise that places few shadow rays, 0…1.
    offset: f32,
}

impl Gathered {
    const NOTHING: Self = Self {
        sums: [[0.0; MOST_LANES]; 5],
        shadow: [[0.0; MOST_LANES]; 3],
        half_at: -1.0,
        first: 0.0,
        offset: 0.0,
    };
}

/// The next N samples of each ray of a packet.
#[repr(align(64))]
struct Looks {
    /// Opacities; 0 where nothing is visible.
    alpha: [[f32; MOST_LANES]; MOST_LANES],
    /// Packed colours, as the bits of f32.
    packed: [[f32; MOST_LANES]; MOST_LANES],
}

impl Default for Looks {
    fn default() -> Self {
        Self { alpha: [[0.0; MOST_LANES]; MOST_LANES], packed: [[0.0; MOST_LANES]; MOST_LANES] }
    }
}

impl Looks {
    #[inline(always)]
    fn put<V: SimdF32>(&mut self, lane: usize, look: Look<V>) {
        look.alpha.store(&mut self.alpha[lane]);
        V::from_bits(look.packed).store(&mut self.packed[lane]);
    }
}

/// Memory that marching reuses.
#[derive(Default)]
pub struct Scratch {
    packet: Packet,
    looks: Looks,
    pool: ShadowPool,
    parts: Parts,
    gathered: Vec<Gathered>,
    /// The samples of the pool, by rays.
    waiting: Vec<Block>,
    chooser: Chooser,
    /// The samples that were chosen, where only few of the pool get shadow rays.
    chosen: ShadowPool,
}

/// Shadow rays are traced once this many samples wait.
const ENOUGH: usize = 8192;

impl<M: Medium> Kernel<'_, M> {
    /// Marches `pixels` and appends their colours (over the background) and opacities to `out`.
    #[inline(always)]
    pub fn march<V: SimdF32>(
        &self,
        zero: V,
        rays: &RayBasis,
        pixels: &[Pixel],
        scratch: &mut Scratch,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let mut count = SampleCount::default();
        let chunks = pixels.len().div_ceil(V::N);
        for (number, pixels) in pixels.chunks(V::N).enumerate() {
            scratch.packet.fill(pixels, rays, &self.segments);
            if let Lighting::Rays(_, Some(few)) = &self.lighting {
                few.put_offsets(pixels, &mut scratch.packet.offset.0);
            }
            if scratch.packet.is_empty() && scratch.gathered.is_empty() {
                out.extend(pixels.iter().map(|_| RayResult::nothing(self.background)));
                continue;
            }
            count.primary += self.primary(zero, scratch);
            let is_last = number + 1 == chunks;
            if is_last || scratch.pool.is_empty() || scratch.pool.len() >= ENOUGH {
                count.shadow += self.finish(zero, scratch, out);
            }
        }
        count
    }

    /// Composites the rays of the packet as if nothing cast shadows. Where shadow rays are wanted, lit samples go to the
    /// pool.
    #[inline(always)]
    fn primary<V: SimdF32>(&self, zero: V, scratch: &mut Scratch) -> u64 {
        let Scratch { packet, looks, pool, gathered, waiting, .. } = scratch;
        let first = gathered.len();
        gathered.resize(first + packet.len, Gathered::NOTHING);
        if packet.is_empty() {
            return 0;
        }
        for (lane, ray) in gathered[first..].iter_mut().enumerate() {
            ray.first = packet.distance.0[lane];
            ray.offset = packet.offset.0[lane];
        }
        if matches!(self.lighting, Lighting::Rays(..)) {
            let most: f32 = packet.samples.0.iter().sum();
            pool.reserve(most as usize + packet.len * V::N);
        }
        let mut count = 0;
        loop {
            let going = match &self.skip {
                Some(skip) => skip.advance(zero, packet, 0.0),
                None => packet.going(zero),
            };
            if going == 0 {
                return count;
            }
            let (visible, invisible) = self.look(zero, packet, going, looks);
            count += invisible;
            let (arriving, mut shown) = (packet.transmittance, visible);
            while shown != 0 {
                let lane = shown.trailing_zeros() as usize;
                shown &= shown - 1;
                let from = pool.len();
                count += self.block(zero, (packet, lane), looks, &mut gathered[first + lane], pool);
                if pool.len() > from {
                    waiting.push(Block { ray: first + lane, from, to: pool.len() });
                }
            }
            self.note_halves(zero, (packet, &arriving, visible), looks, &mut gathered[first..]);
            let next = zero.load(&packet.next.0);
            V::select(zero.mask_of(going), next + zero.splat(V::N as f32), next).store(&mut packet.next.0);
        }
    }

    /// Traces the waiting shadow rays and appends the colours of all gathered rays to `out`.
    #[inline(always)]
    fn finish<V: SimdF32>(&self, zero: V, scratch: &mut Scratch, out: &mut Vec<RayResult>) -> u64 {
        if let Lighting::Rays(_, Some(few)) = &self.lighting {
            self.choose(zero, few, scratch);
        }
        let to_light = WayToLight {
            path: &self.light,
            columns: if let Lighting::Rays(columns, _) = self.lighting { columns } else { None },
            simd: self.simd,
        };
        let samples = self.medium.trace(&to_light, &mut scratch.pool, &mut scratch.parts);
        for block in &scratch.waiting {
            let [r, g, b] = &mut scratch.gathered[block.ray].shadow;
            let sums = [zero.load(r), zero.load(g), zero.load(b)];
            let [dark_r, dark_g, dark_b] = scratch.pool.shadow(block.from, block.to, sums);
            dark_r.store(r);
            dark_g.store(g);
            dark_b.store(b);
        }
        // Closures would be compiled without the instruction set.
        out.reserve(scratch.gathered.len());
        for ray in &scratch.gathered {
            out.push(self.marched(zero, ray));
        }
        scratch.gathered.clear();
        scratch.waiting.clear();
        scratch.pool.clear();
        samples
    }

    /// Replaces the samples that wait by a few of them, which stand for all.
    #[inline(always)]
    fn choose<V: SimdF32>(&self, zero: V, few: &FewShadowRays<'_>, scratch: &mut Scratch) {
        let Scratch { pool, waiting, chooser, chosen, gathered, .. } = scratch;
        gathered.iter().for_each(|ray| chooser.add_ray(ray.offset));
        let places = chooser.choose(zero, few.per_pixel, pool.colours(), waiting);
        chosen.clear();
        chosen.reserve(places.len());
        waiting.clear();
        for (at, place) in places.iter().enumerate() {
            chosen.push_weighted(pool, place.place, place.weight);
            waiting.push(Block { ray: place.ray, from: at, to: at + 1 });
        }
        std::mem::swap(pool, chosen);
    }

    /// The result of a finished ray from its sums.
    #[inline(always)]
    fn marched<V: SimdF32>(&self, zero: V, ray: &Gathered) -> RayResult {
        let [r, g, b, opacity, numbers] = &ray.sums;
        let opacity = zero.load(opacity);
        if V::bits_of(opacity.simd_gt(zero)) == 0 {
            return RayResult::nothing(self.background);
        }
        let whole = opacity.sum();
        let opacity = whole.min(1.0);
        let unshadowed = [zero.load(r).sum(), zero.load(g).sum(), zero.load(b).sum()];
        let [r, g, b] = &ray.shadow;
        let mut colour = [zero.load(r).sum(), zero.load(g).sum(), zero.load(b).sum()];
        for c in 0..3 {
            colour[c] += unshadowed[c] + (1.0 - opacity) * self.background[c];
        }
        let mean = zero.load(numbers).sum() / whole;
        let number = if ray.half_at < 0.0 { mean } else { ray.half_at };
        let depth = self.segments.distance(ray.first, number);
        RayResult { colour, unshadowed, opacity, depth }
    }

    /// Looks up the next N samples of the rays of `packet` that are `going`, two rays side by side: the samples of one
    /// are a long chain of dependent instructions, so a processor has too little to do with one alone.
    ///
    /// Returns the rays with anything visible, and how many samples the others had.
    #[inline(always)]
    fn look<V: SimdF32>(&self, zero: V, packet: &Packet, going: u32, looks: &mut Looks) -> (u32, u64) {
        let (mut left, mut visible, mut invisible) = (going, 0, 0);
        while left != 0 {
            let a = left.trailing_zeros() as usize;
            left &= left - 1;
            // The last of an odd number is its own neighbour.
            let b = if left == 0 { a } else { left.trailing_zeros() as usize };
            left &= left.wrapping_sub(1);
            let (p, q) = (packet.next_places(zero, a), packet.next_places(zero, b));
            let inside = [packet.inside(zero, a), packet.inside(zero, b)];
            let Some([look_a, look_b]) = self.medium.look_at([p, q], inside) else { continue };
            visible |= u32::from(look_a.shown != 0) << a | u32::from(look_b.shown != 0) << b;
            looks.put(a, look_a);
            looks.put(b, look_b);
        }
        let mut unseen = going & !visible;
        while unseen != 0 {
            let lane = unseen.trailing_zeros() as usize;
            unseen &= unseen - 1;
            invisible += (packet.samples.0[lane] - packet.next.0[lane]).min(V::N as f32) as u64;
        }
        (visible, invisible)
    }

    /// Finds where the rays of `packet` lose half of their light, if that is among the samples in `looks`.
    ///
    /// After all blocks: a branch in each of them would often be mispredicted.
    #[inline(always)]
    fn note_halves<V: SimdF32>(
        &self,
        zero: V,
        (packet, arriving, visible): (&Packet, &PerRay, u32),
        looks: &Looks,
        rays: &mut [Gathered],
    ) {
        let half = zero.splat(0.5);
        let (before, after) = (zero.load(&arriving.0), zero.load(&packet.transmittance.0));
        let mut crossing = V::bits_of(before.simd_gt(half) & half.simd_ge(after)) & visible;
        while crossing != 0 {
            let lane = crossing.trailing_zeros() as usize;
            crossing &= crossing - 1;
            let clear = zero.splat(1.0) - zero.load(&looks.alpha[lane]);
            let before = clear.products_before().0 * zero.splat(arriving.0[lane]);
            let above = V::bits_of((before * clear).simd_gt(half)).trailing_ones();
            rays[lane].half_at = packet.next.0[lane] + above as f32;
        }
    }

    /// Composites the next N samples of ray `lane`; returns how many of them counted.
    #[inline(always)]
    fn block<V: SimdF32>(
        &self,
        zero: V,
        (packet, lane): (&mut Packet, usize),
        looks: &Looks,
        ray: &mut Gathered,
        pool: &mut ShadowPool,
    ) -> u64 {
        let one = zero.splat(1.0);
        let number = packet.numbers(zero, lane);
        let inside = packet.inside(zero, lane);
        let (alpha, packed) = (zero.load(&looks.alpha[lane]), zero.load(&looks.packed[lane]).to_bits());
        let (before, through) = (one - alpha).products_before();
        let before = before * zero.splat(packet.transmittance.0[lane]);
        packet.transmittance.0[lane] *= through;
        let going = inside & before.simd_gt(zero.splat(1.0 - OPAQUE));
        let weight = V::select(going, alpha * before, zero);
        let [r, g, b, opacity, numbers] = &mut ray.sums;
        (zero.load(opacity) + weight).store(opacity);
        weight.mul_add(number, zero.load(numbers)).store(numbers);
        let mut colour = [zero.load(r), zero.load(g), zero.load(b)];
        let rgb = colours(packed);
        self.light_samples((packet, lane), weight, rgb, &mut colour, pool);
        colour[0].store(r);
        colour[1].store(g);
        colour[2].store(b);
        u64::from(V::bits_of(going).count_ones())
    }

    /// Adds the light that the next samples of ray `lane`, of `weight` and colour `rgb`, send to the eye to `colour`.
    ///
    /// With shadow rays it adds full light; the samples then wait in `pool` for the part that shadows take away.
    #[inline(always)]
    fn light_samples<V: SimdF32>(
        &self,
        (packet, lane): (&Packet, usize),
        weight: V,
        rgb: [V; 3],
        colour: &mut [V; 3],
        pool: &mut ShadowPool,
    ) {
        let zero = weight.splat(0.0);
        let facing = match self.facing {
            Some(light) => self.medium.facing(packet.next_places(zero, lane), light),
            None => zero.splat(1.0),
        };
        let ambient = zero.splat(self.ambient);
        let direct = zero.splat(1.0 - self.ambient) * facing;
        match &self.lighting {
            Lighting::Rays(..) | Lighting::Full => {
                let lit = weight * (ambient + direct);
                for c in 0..3 {
                    colour[c] = lit.mul_add(rgb[c], colour[c]);
                }
                if matches!(self.lighting, Lighting::Rays(..)) {
                    let waiting = weight * direct;
                    let light = [waiting * rgb[0], waiting * rgb[1], waiting * rgb[2]];
                    pool.push(weight.simd_gt(zero), packet.next_places(zero, lane), light);
                }
            }
            Lighting::Cached(grid) => {
                let light = self.cached_light(packet.next_places(zero, lane), grid);
                let lit = weight * direct.mul_add(light, ambient);
                for c in 0..3 {
                    colour[c] = lit.mul_add(rgb[c], colour[c]);
                }
            }
        }
    }

    /// Transmittance towards the light at `p`: the first sample of the shadow ray, and what `grid` has from there on.
    #[inline(always)]
    fn cached_light<V: SimdF32>(&self, p: [V; 3], grid: &Field<'_, u8>) -> V {
        let (zero, one) = (p[0].splat(0.0), p[0].splat(1.0));
        let towards = |a: usize, steps: f32| zero.splat(steps).mul_add(zero.splat(self.light.delta[a]), p[a]);
        let at = [towards(0, SHADOW_START), towards(1, SHADOW_START), towards(2, SHADOW_START)];
        let after = [towards(0, SHADOW_STEP), towards(1, SHADOW_STEP), towards(2, SHADOW_STEP)];
        let way = self.light.ways_out(p);
        let alpha = self.medium.shadow_alpha(at);
        let near = V::select(way.simd_gt(zero.splat(SHADOW_START)), one - alpha, one);
        let far = V::select(way.simd_gt(zero.splat(SHADOW_START + SHADOW_STEP)), grid.sample(after), one);
        near * far
    }
}
