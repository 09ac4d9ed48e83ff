//! Fine integration in lanes: consecutive steps of one ray side by side.

use super::super::field::Texel;
use super::super::kernel::{Kernel, Lighting, colours};
use super::super::lanes::{Lanes, MOST_LANES};
use super::super::march::SampleCount;
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

/// The scene that SIMD lanes march primary rays through by fine integration.
pub struct FineKernel<'a, T> {
    /// The part that plain integration uses too.
    pub kernel: Kernel<'a, T>,
    /// Extinction and colour between two display values.
    pub extinction: &'a ExtinctionTable,
}

/// Lanes, in memory.
type Stored = [f32; MOST_LANES];

/// The sums of one ray so far.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Gathered {
    /// One sum per lane: red, green, blue, opacity, and the opacity's share of the steps' numbers.
    sums: [Stored; 5],
    /// The number of the step that took opacity past one half; negative before.
    half_at: f32,
    /// The middle of the ray's first step, and one step.
    start: [f32; 3],
    delta: [f32; 3],
}

/// Memory that marching reuses.
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
}

impl Default for FineScratch {
    fn default() -> Self {
        Self {
            packet: Packet::new(),
            covered: PerRay::default(),
            pool: ShadowPool::default(),
            parts: Parts::default(),
            gathered: Vec::new(),
            places: Vec::new(),
            stretches: Stretches::default(),
        }
    }
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
    ///
    /// # Safety
    /// The instruction set of `L` must be available.
    #[inline(always)]
    pub unsafe fn march<L: Lanes>(
        &self,
        rays: &RayBasis,
        pixels: &[Pixel],
        scratch: &mut FineScratch,
        out: &mut Vec<RayResult>,
    ) -> SampleCount {
        let eye = self.kernel.segments.in_voxels(rays.origin());
        let mut count = SampleCount::default();
        for pixels in pixels.chunks(L::N) {
            let packet = &mut scratch.packet;
            packet.fill(pixels, rays, &self.kernel.segments);
            // SAFETY: the caller's.
            unsafe { packet.count_ends::<L>() };
            if packet.is_empty() && scratch.places.is_empty() {
                out.extend(pixels.iter().map(|_| RayResult::nothing(self.kernel.background)));
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

    /// Composites the rays of the packet, but for the light that nodes wait for; returns how many steps that took.
    #[inline(always)]
    unsafe fn primary<L: Lanes>(&self, scratch: &mut FineScratch) -> u64 {
        let first = scratch.places.len();
        scratch.places.resize(first + scratch.packet.len, NOTHING);
        scratch.covered = PerRay::default();
        let mut count = 0;
        loop {
            // SAFETY: the caller's.
            unsafe {
                let mut going = self.going::<L>(&mut scratch.packet, &scratch.covered);
                if going == 0 {
                    return count;
                }
                let front = self.fronts::<L>(&scratch.packet);
                scratch.pool.reserve((L::N + 1) * L::N);
                while going != 0 {
                    let lane = going.trailing_zeros() as usize;
                    going &= going - 1;
                    count += self.block::<L>(scratch, lane, first + lane, front[lane]);
                }
            }
        }
    }

    /// Advances all rays to their next step that may be visible; returns a bit for each ray that has one.
    ///
    /// Empty space is skipped from end to end of steps, so the step before the first visible end counts as well. Blocks
    /// begin at a node, if there are any.
    #[inline(always)]
    unsafe fn going<L: Lanes>(&self, packet: &mut Packet, covered: &PerRay) -> u32 {
        // SAFETY: the caller's; the arrays of a packet hold at least N elements.
        unsafe {
            let length = L::load(packet.length.0.as_ptr());
            let Some(skip) = &self.kernel.skip else {
                let left = L::lt(L::load(packet.next.0.as_ptr()), length);
                return packet.going::<L>() & L::bits(left);
            };
            let has_nodes = !matches!(self.kernel.lighting, Lighting::Full);
            loop {
                let going = skip.advance::<L>(packet, 0.5);
                let next = L::load(packet.next.0.as_ptr());
                let before = L::max(L::sub(next, L::splat(1.0)), L::load(covered.0.as_ptr()));
                let first = if has_nodes { last_node::<L>(before) } else { before };
                // Where the last step was taken already, only its end is left: no step begins there.
                let left = L::and_m(L::mask(going), L::lt(before, length));
                let done = L::load(packet.samples.0.as_ptr());
                let ended = L::select(L::mask(going), done, next);
                L::store(L::select(left, first, ended), packet.next.0.as_mut_ptr());
                if going == 0 || L::bits(left) != 0 {
                    return L::bits(left);
                }
            }
        }
    }

    /// Of every ray the entry of the transfer table at its next node.
    #[inline(always)]
    unsafe fn fronts<L: Lanes>(&self, packet: &Packet) -> Stored {
        // SAFETY: the arrays of a packet hold at least N elements.
        unsafe {
            let start = Packet::load::<L>(&packet.start);
            let delta = Packet::load::<L>(&packet.delta);
            let (next, length) = (L::load(packet.next.0.as_ptr()), L::load(packet.length.0.as_ptr()));
            let mut front = [0.0; MOST_LANES];
            let p = boundary::<L>(start, delta, L::min(next, length));
            L::store(entry::<L>(self.kernel.field.sample::<L>(p)), front.as_mut_ptr());
            front
        }
    }

    /// Takes the next N steps of `ray`, which is in `lane` of the packet and begins at `first_entry`; returns how many
    /// of them counted.
    #[inline(always)]
    unsafe fn block<L: Lanes>(
        &self,
        scratch: &mut FineScratch,
        lane: usize,
        ray: usize,
        first_entry: f32,
    ) -> u64 {
        let FineScratch { packet, covered, pool, gathered, places, stretches, .. } = scratch;
        // SAFETY: entries come from display values in 0…1 scaled to the table; arrays hold at least N elements, and the
        // pool has room for all nodes.
        unsafe {
            let (zero, one) = (L::splat(0.0), L::splat(1.0));
            let first = packet.next.0[lane];
            let number = L::add(L::splat(first), L::iota());
            packet.next.0[lane] += L::N as f32;
            covered.0[lane] = packet.next.0[lane];
            let start = [0, 1, 2].map(|a| L::splat(packet.start[a].0[lane]));
            let delta = [0, 1, 2].map(|a| L::splat(packet.delta[a].0[lane]));
            let length = L::splat(packet.length.0[lane]);
            let end = L::min(L::add(number, one), length);
            let at_end = boundary::<L>(start, delta, end);
            let behind = entry::<L>(self.kernel.field.sample::<L>(at_end));
            let front = L::moved_up(behind, first_entry);
            let inside = L::lt(number, length);
            let [least, most] = self.kernel.visible;
            let (high, low) = (L::max(front, behind), L::min(front, behind));
            let shown = L::and_m(inside, L::and_m(L::gt(high, L::splat(least)), L::lt(low, L::splat(most))));
            let inside = u64::from(L::bits(inside).count_ones());
            if L::bits(shown) == 0 {
                return inside;
            }
            let table = self.extinction;
            let behind = table.points::<L>(behind);
            let front = behind.moved_up(table, first_entry);
            let part = L::max(L::sub(end, number), zero);
            let unit = L::mul(part, L::splat(table.unit));
            let depth = L::mul(table.means::<L, T>(&front, &behind), unit);
            if L::bits(L::gt(depth, zero)) == 0 {
                return inside;
            }
            let ray = place(&mut places[ray], gathered, packet, lane);
            let through = passing::<L>(depth);
            let arriving = packet.transmittance.0[lane];
            let (before, all) = L::products_before(through);
            let before = L::mul(before, L::splat(arriving));
            let passed = arriving * all;
            packet.transmittance.0[lane] = if passed > 1.0 - OPAQUE { passed } else { 0.0 };
            let gathered = &mut gathered[ray];
            if arriving > 0.5 && passed <= 0.5 {
                let clear = L::gt(L::mul(before, through), L::splat(0.5));
                gathered.half_at = first + L::bits(clear).trailing_ones() as f32;
            }
            let going = L::and_m(L::gt(depth, zero), L::gt(before, L::splat(1.0 - OPAQUE)));
            let before = L::select(going, before, zero);
            let weight = L::mul(before, L::sub(one, through));
            let [r, g, b, opacity, numbers] = &mut gathered.sums;
            L::store(L::add(L::load(opacity.as_ptr()), weight), opacity.as_mut_ptr());
            L::store(L::fma(weight, number, L::load(numbers.as_ptr())), numbers.as_mut_ptr());
            let rgb = colours::<L>(table.colours_between::<L, T>(&front, &behind));
            let kernel = &self.kernel;
            let mut direct = L::splat(1.0 - kernel.ambient);
            if let Some(light) = kernel.facing {
                let middle = L::min(L::add(number, L::splat(0.5)), length);
                direct = L::mul(direct, kernel.facing::<L>(boundary::<L>(start, delta, middle), light));
            }
            let is_full = matches!(kernel.lighting, Lighting::Full);
            let known = L::add(L::splat(kernel.ambient), if is_full { direct } else { zero });
            let known = L::mul(weight, known);
            for (sum, rgb) in [r, g, b].into_iter().zip(rgb) {
                L::store(L::fma(known, rgb, L::load(sum.as_ptr())), sum.as_mut_ptr());
            }
            if is_full {
                return inside;
            }
            let depths = over_nodes::<L>(depth);
            let thick = L::gt(depths[1], L::splat(THIN));
            let nodes = Nodes::around(L::bits(going), L::bits(thick));
            let direct = L::mul(direct, weight);
            let values = [L::mul(direct, rgb[0]), L::mul(direct, rgb[1]), L::mul(direct, rgb[2])];
            let [r, g, b] = values.map(|v| over_nodes::<L>(v)).map(|[two, four]| L::select(thick, two, four));
            let depth = L::select(thick, depths[0], depths[1]);
            stretches.push::<L>(nodes.begins, [r, g, b, depth], (nodes.all, pool.len()), ray);
            let p = boundary::<L>(start, delta, L::min(number, length));
            let inner = L::mask(nodes.all & (u32::MAX >> (32 - L::N)));
            pool.push::<L>(inner, p, [front.entry, front.sum, front.extinction]);
            if nodes.all >> L::N & 1 == 1 {
                let last = L::mask(1 << (L::N - 1));
                pool.push::<L>(last, at_end, [behind.entry, behind.sum, behind.extinction]);
            }
            inside
        }
    }

    /// Finds the light at the waiting nodes and appends the colours of all gathered rays to `out`.
    #[inline(always)]
    unsafe fn finish<L: Lanes>(
        &self,
        eye: [f32; 3],
        scratch: &mut FineScratch,
        out: &mut Vec<RayResult>,
    ) -> u64 {
        let FineScratch { pool, parts, gathered, places, stretches, .. } = scratch;
        let kernel = &self.kernel;
        let to_light = ToLight {
            field: &kernel.field,
            extinction: self.extinction,
            shadow_alpha: &kernel.table.shadow_alpha,
            path: &kernel.light,
            lighting: &kernel.lighting,
        };
        // SAFETY: the caller's; arrays hold at least N elements.
        unsafe {
            let samples = to_light.find::<L>(pool, parts);
            stretches.arrive::<L>(pool, |ray, light| {
                for (sum, light) in gathered[ray].sums.iter_mut().zip(light) {
                    sum[0] += light;
                }
            });
            out.reserve(places.len());
            for place in places.iter() {
                out.push(match gathered.get(*place as usize) {
                    Some(ray) => self.marched::<L>(eye, ray),
                    None => RayResult::nothing(self.kernel.background),
                });
            }
            places.clear();
            gathered.clear();
            stretches.clear();
            pool.clear();
            samples
        }
    }

    /// The result of a finished ray from its sums; `eye` in voxel-centre coordinates.
    #[inline(always)]
    unsafe fn marched<L: Lanes>(&self, eye: [f32; 3], ray: &Gathered) -> RayResult {
        let background = self.kernel.background;
        // SAFETY: sums hold at least N elements.
        unsafe {
            let [r, g, b, opacity, numbers] = &ray.sums;
            let whole = L::sum(L::load(opacity.as_ptr()));
            if whole <= 0.0 {
                return RayResult::nothing(background);
            }
            let (scale, left) = if whole < OPAQUE { (1.0, 1.0 - whole) } else { (1.0 / whole, 0.0) };
            let colour =
                [L::sum(L::load(r.as_ptr())), L::sum(L::load(g.as_ptr())), L::sum(L::load(b.as_ptr()))];
            let [r, g, b] = background;
            let colour =
                [colour[0] * scale + left * r, colour[1] * scale + left * g, colour[2] * scale + left * b];
            let mean = L::sum(L::load(numbers.as_ptr())) / whole;
            let number = if ray.half_at < 0.0 { mean } else { ray.half_at };
            let depth = self.kernel.segments.distance(eye, ray.start, ray.delta, number);
            RayResult { colour, opacity: 1.0 - left, depth }
        }
    }
}

/// The number of the last step at or before `number` that every block may begin at: a multiple of four.
#[inline(always)]
unsafe fn last_node<L: Lanes>(number: L::F) -> L::F {
    // SAFETY: the caller's.
    unsafe { L::mul(L::splat(4.0), L::to_f32(L::truncate(L::mul(L::splat(0.25), number)))) }
}

/// The place in `gathered` of the ray in `lane` of `packet`, which gets one if it has none.
#[inline(always)]
fn place(place: &mut u32, gathered: &mut Vec<Gathered>, packet: &Packet, lane: usize) -> usize {
    if *place == NOTHING {
        *place = gathered.len() as u32;
        gathered.push(Gathered {
            sums: [[0.0; MOST_LANES]; 5],
            half_at: -1.0,
            start: [packet.start[0].0[lane], packet.start[1].0[lane], packet.start[2].0[lane]],
            delta: [packet.delta[0].0[lane], packet.delta[1].0[lane], packet.delta[2].0[lane]],
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
unsafe fn over_nodes<L: Lanes>(v: L::F) -> [L::F; 2] {
    // SAFETY: the caller's.
    unsafe {
        let two = L::add(v, L::neighbours(v));
        [two, L::add(two, L::next_neighbours(two))]
    }
}

/// Where a ray is `steps` steps after it entered the box; `start` is half a step in.
#[inline(always)]
unsafe fn boundary<L: Lanes>(start: [L::F; 3], delta: [L::F; 3], steps: L::F) -> [L::F; 3] {
    // SAFETY: the caller's.
    unsafe {
        let from_first = L::sub(steps, L::splat(0.5));
        [
            L::fma(from_first, delta[0], start[0]),
            L::fma(from_first, delta[1], start[1]),
            L::fma(from_first, delta[2], start[2]),
        ]
    }
}
