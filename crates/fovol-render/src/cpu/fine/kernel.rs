//! Fine integration in lanes: consecutive steps of one ray side by side.

use super::super::few_shadow_rays::{Block, Chooser, FewShadowRays};
use super::super::field::Texel;
use super::super::kernel::{Kernel, Lighting};
use super::super::march::SampleCount;
use super::super::medium::{Medium, OneVolume, colours};
use super::super::packet::{Packet, PerRay};
use super::super::shadow_pool::ShadowPool;
use super::super::shadow_rays::Parts;
use super::exponential::passing;
use super::lit::ToLight;
use super::lookup::entry;
use super::march::{OPAQUE, THIN};
use super::stretches::Stretches;
use crate::scene::{ExtinctionTable, RayResult};
use fovol_core::{Pixel, RayBasis};
use fovol_simd::{MOST_LANES, SimdF32};

/// The scene that SIMD lanes march primary rays through by fine integration.
pub struct FineKernel<'a, T: Texel> {
    /// The part that plain integration uses too.
    pub kernel: Kernel<'a, OneVolume<'a, T>>,
    /// Extinction and colour between two display values.
    pub extinction: &'a ExtinctionTable,
}

/// Lanes, in memory.
type Stored = [f32; MOST_LANES];

/// The sums of one ray so far.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Gathered {
    /// One sum per lane: red, green, blue in full light, opacity, and the opacity's share of the steps' numbers.
    sums: [Stored; 5],
    /// Red, green and blue that shadows take away, at most 0.
    shadow: [f32; 3],
    /// The number of the step that took opacity past one half; negative before.
    half_at: f32,
    /// How far the middle of the ray's first step is from its origin, in world units.
    first: f32,
    /// The noise that places few shadow rays, 0…1.
    offset: f32,
}

/// Memory that marching reuses.
#[derive(Default)]
pub struct FineScratch {
    packet: Packet,
    /// For each ray of the packet, the step after the last one taken.
    covered: PerRay,
    pool: ShadowPool,
    parts: Parts,
    gathered: Vec<Gathered>,
    /// For each ray that waits to be returned, its index in `gathered`, or [`NOTHING`].
    places: Vec<u32>,
    stretches: Stretches,
    /// The stretches by rays, where only few of them get shadow rays, and their nodes.
    blocks: Vec<Block>,
    chooser: Chooser,
    chosen: ShadowPool,
}

/// The index of rays that crossed nothing visible.
const NOTHING: u32 = u32::MAX;
/// The light is found once this many nodes wait.
const ENOUGH: usize = 4096;
/// A bit for every second step, and for every fourth.
const EVEN: u32 = 0x5555_5555;
const FOURTH: u32 = 0x1111_1111;

impl<T: Texel> FineKernel<'_, T> {
    /// Marches `pixels` and appends their colours (over the background) and opacities to `out`.
    #[inline(always)]
    pub fn march<V: SimdF32>(
        &self,
        zero: V,
        rays: &RayBasis,
        pixels: &[Pixel],
        scratch: &mut FineScratch,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let mut count = SampleCount::default();
        let chunks = pixels.len().div_ceil(V::N);
        for (number, pixels) in pixels.chunks(V::N).enumerate() {
            let packet = &mut scratch.packet;
            packet.fill(pixels, rays, &self.kernel.segments);
            packet.count_ends(zero);
            if let Lighting::Rays(_, Some(few)) = &self.kernel.lighting {
                few.put_offsets(pixels, &mut packet.offset.0);
            }
            if packet.is_empty() && scratch.places.is_empty() {
                out.extend(pixels.iter().map(|_| RayResult::nothing(self.kernel.background)));
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

    /// Composites the rays of the packet, but for the light that nodes wait for; returns how many steps that took.
    #[inline(always)]
    fn primary<V: SimdF32>(&self, zero: V, scratch: &mut FineScratch) -> u64 {
        let first = scratch.places.len();
        scratch.places.resize(first + scratch.packet.len, NOTHING);
        scratch.covered = PerRay::default();
        let mut count = 0;
        loop {
            let mut going = self.going(zero, &mut scratch.packet, &scratch.covered);
            if going == 0 {
                return count;
            }
            let front = self.fronts(zero, &scratch.packet);
            scratch.pool.reserve((V::N + 1) * V::N);
            while going != 0 {
                let lane = going.trailing_zeros() as usize;
                going &= going - 1;
                count += self.block(zero, scratch, (lane, first + lane), front[lane]);
            }
        }
    }

    /// Advances all rays to their next step that may be visible; returns a bit for each ray that has one.
    ///
    /// Empty space is skipped from end to end of steps, so the step before the first visible end counts as well. Blocks
    /// begin at a node, if there are any.
    #[inline(always)]
    fn going<V: SimdF32>(&self, zero: V, packet: &mut Packet, covered: &PerRay) -> u32 {
        let length = zero.load(&packet.length.0);
        let Some(skip) = &self.kernel.skip else {
            let left = zero.load(&packet.next.0).simd_lt(length);
            return packet.going(zero) & V::bits_of(left);
        };
        let has_nodes = !matches!(self.kernel.lighting, Lighting::Full);
        loop {
            let going = skip.advance(zero, packet, 0.5);
            let next = zero.load(&packet.next.0);
            let before = (next - zero.splat(1.0)).max(zero.load(&covered.0));
            let first = if has_nodes { last_node(before) } else { before };
            // Where the last step was taken already, only its end is left: no step begins there.
            let left = zero.mask_of(going) & before.simd_lt(length);
            let done = zero.load(&packet.samples.0);
            let ended = V::select(zero.mask_of(going), done, next);
            V::select(left, first, ended).store(&mut packet.next.0);
            if going == 0 || V::bits_of(left) != 0 {
                return V::bits_of(left);
            }
        }
    }

    /// Of every ray the entry of the transfer table at its next node.
    #[inline(always)]
    fn fronts<V: SimdF32>(&self, zero: V, packet: &Packet) -> Stored {
        let start = Packet::load(zero, &packet.start);
        let delta = Packet::load(zero, &packet.delta);
        let (next, length) = (zero.load(&packet.next.0), zero.load(&packet.length.0));
        let mut front = [0.0; MOST_LANES];
        let p = boundary(start, delta, next.min(length));
        entry(self.kernel.medium.field.sample(p)).store(&mut front);
        front
    }

    /// Takes the next N steps of `ray`, which is in `lane` of the packet and begins at `first_entry`; returns how many
    /// of them counted.
    #[inline(always)]
    fn block<V: SimdF32>(
        &self,
        zero: V,
        scratch: &mut FineScratch,
        (lane, ray): (usize, usize),
        first_entry: f32,
    ) -> u64 {
        let FineScratch { packet, covered, pool, gathered, places, stretches, blocks, .. } = scratch;
        let kernel = &self.kernel;
        let one = zero.splat(1.0);
        let first = packet.next.0[lane];
        let number = zero.splat(first) + zero.iota();
        packet.next.0[lane] += V::N as f32;
        covered.0[lane] = packet.next.0[lane];
        let start = Packet::splat(zero, &packet.start, lane);
        let delta = Packet::splat(zero, &packet.delta, lane);
        let length = zero.splat(packet.length.0[lane]);
        let end = (number + one).min(length);
        let at_end = boundary(start, delta, end);
        let behind = entry(self.kernel.medium.field.sample(at_end));
        let front = behind.moved_up(first_entry);
        let inside = number.simd_lt(length);
        let [least, most] = self.kernel.medium.visible;
        let (high, low) = (front.max(behind), front.min(behind));
        let shown = inside & (high.simd_gt(zero.splat(least)) & low.simd_lt(zero.splat(most)));
        let inside = u64::from(V::bits_of(inside).count_ones());
        if V::bits_of(shown) == 0 {
            return inside;
        }
        let table = self.extinction;
        // SAFETY: fields are scaled to entries of the table.
        let behind = unsafe { table.points(behind) };
        let front = behind.moved_up(table, first_entry);
        let part = (end - number).max(zero);
        let unit = part * zero.splat(table.unit);
        let depth = table.means(&front, &behind, kernel.medium.field.has_gaps()) * unit;
        if V::bits_of(depth.simd_gt(zero)) == 0 {
            return inside;
        }
        let ray = place(&mut places[ray], gathered, packet, lane);
        let through = passing(depth);
        let arriving = packet.transmittance.0[lane];
        let (before, all) = through.products_before();
        let before = before * zero.splat(arriving);
        let passed = arriving * all;
        packet.transmittance.0[lane] = if passed > 1.0 - OPAQUE { passed } else { 0.0 };
        let gathered = &mut gathered[ray];
        if arriving > 0.5 && passed <= 0.5 {
            let clear = (before * through).simd_gt(zero.splat(0.5));
            gathered.half_at = first + V::bits_of(clear).trailing_ones() as f32;
        }
        let going = depth.simd_gt(zero) & before.simd_gt(zero.splat(1.0 - OPAQUE));
        let before = V::select(going, before, zero);
        let weight = before * (one - through);
        let [r, g, b, opacity, numbers] = &mut gathered.sums;
        (zero.load(opacity) + weight).store(opacity);
        weight.mul_add(number, zero.load(numbers)).store(numbers);
        let rgb = colours(table.colours_between(&front, &behind, kernel.medium.field.has_gaps()));
        let mut direct = zero.splat(1.0 - kernel.ambient);
        if let Some(light) = kernel.facing {
            let middle = (number + zero.splat(0.5)).min(length);
            direct = direct * kernel.medium.facing(boundary(start, delta, middle), light);
        }
        let lit = weight * (zero.splat(kernel.ambient) + direct);
        for (sum, rgb) in [r, g, b].into_iter().zip(rgb) {
            lit.mul_add(rgb, zero.load(sum)).store(sum);
        }
        if matches!(kernel.lighting, Lighting::Full) {
            return inside;
        }
        let depths = over_nodes(depth);
        let thick = depths[1].simd_gt(zero.splat(THIN));
        let nodes = Nodes::around(V::bits_of(going), V::bits_of(thick));
        let direct = direct * weight;
        let r = between_nodes(thick, direct * rgb[0]);
        let g = between_nodes(thick, direct * rgb[1]);
        let b = between_nodes(thick, direct * rgb[2]);
        let depth = V::select(thick, depths[0], depths[1]);
        let from = stretches.len();
        stretches.push(nodes.begins, [r, g, b, depth], (nodes.all, pool.len()), ray);
        if matches!(kernel.lighting, Lighting::Rays(_, Some(_))) {
            blocks.push(Block { ray, from, to: stretches.len() });
        }
        let p = boundary(start, delta, number.min(length));
        let inner = zero.mask_of(nodes.all & (u32::MAX >> (32 - V::N)));
        pool.push(inner, p, [front.entry, front.sum, front.extinction]);
        if nodes.all >> V::N & 1 == 1 {
            let last = zero.mask_of(1 << (V::N - 1));
            pool.push(last, at_end, [behind.entry, behind.sum, behind.extinction]);
        }
        inside
    }

    /// Finds the light at the waiting nodes and appends the colours of all gathered rays to `out`.
    #[inline(always)]
    fn finish<V: SimdF32>(&self, zero: V, scratch: &mut FineScratch, out: &mut Vec<RayResult>) -> u64 {
        if let Lighting::Rays(_, Some(few)) = &self.kernel.lighting {
            self.choose(zero, few, scratch);
        }
        let FineScratch { pool, parts, gathered, places, stretches, .. } = scratch;
        let kernel = &self.kernel;
        let to_light = ToLight {
            field: &kernel.medium.field,
            extinction: self.extinction,
            shadow_alpha: &kernel.medium.table.shadow_alpha,
            path: &kernel.light,
            lighting: &kernel.lighting,
            simd: kernel.simd,
        };
        let samples = to_light.find(zero, pool, parts);
        stretches.shadow(zero, pool, |ray, shadow| {
            for (sum, shadow) in gathered[ray].shadow.iter_mut().zip(shadow) {
                *sum += shadow;
            }
        });
        out.reserve(places.len());
        for place in places.iter() {
            out.push(match gathered.get(*place as usize) {
                Some(ray) => self.marched(zero, ray),
                None => RayResult::nothing(self.kernel.background),
            });
        }
        places.clear();
        gathered.clear();
        stretches.clear();
        pool.clear();
        samples
    }

    /// Keeps a few of the stretches that wait, which stand for all, and their nodes.
    #[inline(always)]
    fn choose<V: SimdF32>(&self, zero: V, few: &FewShadowRays<'_>, scratch: &mut FineScratch) {
        let FineScratch { pool, gathered, stretches, blocks, chooser, chosen, .. } = scratch;
        gathered.iter().for_each(|ray| chooser.add_ray(ray.offset));
        let places = chooser.choose(zero, few.per_pixel, stretches.colours(), blocks);
        stretches.keep(places, pool, chosen);
        blocks.clear();
    }

    /// The result of a finished ray from its sums.
    #[inline(always)]
    fn marched<V: SimdF32>(&self, zero: V, ray: &Gathered) -> RayResult {
        let background = self.kernel.background;
        let [r, g, b, opacity, numbers] = &ray.sums;
        let whole = zero.load(opacity).sum();
        if whole <= 0.0 {
            return RayResult::nothing(background);
        }
        let (scale, left) = if whole < OPAQUE { (1.0, 1.0 - whole) } else { (1.0 / whole, 0.0) };
        let lit = [zero.load(r).sum(), zero.load(g).sum(), zero.load(b).sum()];
        let (mut colour, mut unshadowed) = (lit, lit);
        for c in 0..3 {
            let seen = lit[c] + ray.shadow[c];
            colour[c] = seen * scale + left * background[c];
            // With cached shadows the colour itself is the guide.
            unshadowed[c] = scale * (if self.casts_rays() { lit[c] } else { seen });
        }
        let mean = zero.load(numbers).sum() / whole;
        let number = if ray.half_at < 0.0 { mean } else { ray.half_at };
        let depth = self.kernel.segments.distance(ray.first, number);
        RayResult { colour, unshadowed, opacity: 1.0 - left, depth }
    }

    /// Whether shadow rays are marched.
    fn casts_rays(&self) -> bool {
        matches!(self.kernel.lighting, Lighting::Rays(..))
    }
}

/// The number of the last step at or before `number` that every block may begin at: a multiple of four.
#[inline(always)]
fn last_node<V: SimdF32>(number: V) -> V {
    number.splat(4.0) * V::from_i32((number.splat(0.25) * number).to_i32())
}

/// The place in `gathered` of the ray in `lane` of `packet`, which gets one if it has none.
#[inline(always)]
fn place(place: &mut u32, gathered: &mut Vec<Gathered>, packet: &Packet, lane: usize) -> usize {
    if *place == NOTHING {
        *place = gathered.len() as u32;
        gathered.push(Gathered {
            sums: [[0.0; MOST_LANES]; 5],
            shadow: [0.0; 3],
            half_at: -1.0,
            first: packet.distance.0[lane],
            offset: packet.offset.0[lane],
        });
    }
    *place as usize
}

/// The nodes that a block's steps lie between; node n lies before step n.
struct Nodes {
    /// All nodes, one bit each.
    all: u32,
    /// The nodes at which a stretch begins, one bit each.
    begins: u32,
}

impl Nodes {
    /// The nodes around the visible steps `show`: two steps apart among the `thick` steps, four elsewhere.
    #[inline(always)]
    fn around(show: u32, thick: u32) -> Self {
        let twos = (show | show >> 1) & EVEN & thick;
        let fours = (show | show >> 1 | show >> 2 | show >> 3) & FOURTH & !thick;
        let begins = twos | fours;
        Self { all: begins | twos << 2 | fours << 4, begins }
    }
}

/// The sums of `v` over two and over four steps, in the lanes of each of them.
#[inline(always)]
fn over_nodes<V: SimdF32>(v: V) -> [V; 2] {
    let two = v + v.neighbours();
    [two, two + two.next_neighbours()]
}

/// The sums of `v` over the steps between two nodes: two where steps are `thick`, else four.
#[inline(always)]
fn between_nodes<V: SimdF32>(thick: V::Mask, v: V) -> V {
    let [two, four] = over_nodes(v);
    V::select(thick, two, four)
}

/// Where a ray is `steps` steps after it entered the box; `start` is half a step in.
#[inline(always)]
fn boundary<V: SimdF32>(start: [V; 3], delta: [V; 3], steps: V) -> [V; 3] {
    let from_first = steps - steps.splat(0.5);
    [
        from_first.mul_add(delta[0], start[0]),
        from_first.mul_add(delta[1], start[1]),
        from_first.mul_add(delta[2], start[2]),
    ]
}
