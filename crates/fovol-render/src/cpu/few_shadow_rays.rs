//! Shadow rays for a few places of each ray, which stand for all of them.
//!
//! docs/guide/src/internals/algorithm.md, section 3.1, has the equations.

use crate::noise::FrameNoise;
use fovol_core::Pixel;
use fovol_simd::SimdF32;

/// Number of shadow rays of each pixel, and the noise that places them.
#[derive(Debug, Clone, Copy)]
pub struct FewShadowRays<'a> {
    /// Shadow rays of each pixel: 1 or more.
    pub per_pixel: u32,
    /// Noise of the frame.
    pub noise: FrameNoise<'a>,
}

/// Least number of shadow rays that stand for trapezoids. Their error is 4 to 6 dB less, but its mean is not 0; at 4 rays it is
/// up to 0.003, at 16 up to 0.0003.
const TRAPEZOIDS: u32 = 4;

/// Pixels between the noise of masks and that of shadow rays: sampled pixels have low values of the first.
const SHIFT: [u32; 2] = [59, 31];

impl FewShadowRays<'_> {
    /// Noise of `pixel`, 0…1.
    pub(super) fn offset(&self, pixel: Pixel) -> f32 {
        let [x, y] = [u32::from(pixel.x) + SHIFT[0], u32::from(pixel.y) + SHIFT[1]];
        (self.noise.rank(x, y) as f32 + 0.5) / self.noise.levels() as f32
    }

    /// Writes the noise of `pixels` to `offsets`.
    pub(super) fn put_offsets(&self, pixels: &[Pixel], offsets: &mut [f32]) {
        pixels.iter().zip(offsets).for_each(|(pixel, offset)| *offset = self.offset(*pixel));
    }
}

/// Neighbouring places of one ray that wait for their light, at most as many as a vector has lanes.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    pub ray: usize,
    pub from: usize,
    pub to: usize,
}

/// Place that has been chosen.
#[derive(Debug, Clone, Copy)]
pub struct Chosen {
    pub ray: usize,
    pub place: usize,
    /// Factor of its colour, so that it stands for other places of the ray too.
    pub weight: f32,
}

/// Chooses places of rays by their luminance in full light.
#[derive(Default)]
pub struct Chooser {
    rays: Vec<Light>,
    /// Luminance of each block.
    blocks: Vec<f32>,
    chosen: Vec<Chosen>,
}

impl Chooser {
    /// Adds a ray whose noise is `offset`, 0…1.
    pub fn add_ray(&mut self, offset: f32) {
        self.rays.push(Light { luminance: 0.0, before: 0.0, offset, next: 0 });
    }

    /// Chooses up to `per_pixel` places of every ray added so far, and forgets the rays. `colours` are those of all places;
    /// `blocks` has the places of each ray in their order along it.
    #[inline(always)]
    pub fn choose<V: SimdF32>(
        &mut self,
        zero: V,
        per_pixel: u32,
        colours: [&[f32]; 3],
        blocks: &[Block],
    ) -> &[Chosen] {
        self.blocks.clear();
        self.chosen.clear();
        for block in blocks {
            let luminance = block_luminance(zero, colours, block);
            self.rays[block.ray].luminance += luminance;
            self.blocks.push(luminance);
        }
        for (block, luminance) in blocks.iter().zip(&self.blocks) {
            let light = &mut self.rays[block.ray];
            if light.passes(*luminance, per_pixel) {
                light.choose(block, *luminance, (per_pixel, colours), &mut self.chosen);
            }
        }
        self.rays.clear();
        &self.chosen
    }
}

/// Chooses up to `per_pixel` places of one ray, whose noise is `offset`, by their `colours` in full light; plain code.
pub fn choose_places(offset: f32, per_pixel: u32, colours: &[[f32; 3]]) -> Vec<Chosen> {
    let whole = colours.iter().map(|colour| luminance(*colour)).sum();
    let mut light = Light { luminance: whole, before: 0.0, offset, next: 0 };
    let channels = [0, 1, 2].map(|c| colours.iter().map(|colour| colour[c]).collect::<Vec<f32>>());
    let mut chosen = Vec::new();
    let block = Block { ray: 0, from: 0, to: colours.len() };
    light.choose(&block, whole, (per_pixel, [&channels[0], &channels[1], &channels[2]]), &mut chosen);
    chosen
}

/// Light of a ray, and where the next shadow ray begins.
struct Light {
    /// Luminance of all places, and of those before the next one.
    luminance: f32,
    before: f32,
    /// Noise of the ray, and the number of its next shadow ray.
    offset: f32,
    next: u32,
}

impl Light {
    /// Luminance before the place where the next of `per_pixel` shadow rays begins.
    #[inline(always)]
    fn target(&self, per_pixel: u32) -> f32 {
        (self.next as f32 + self.offset) / per_pixel as f32 * self.luminance
    }

    /// Share of the light that the next of `per_pixel` shadow rays stands for. From [`TRAPEZOIDS`] on it is that of trapezoids
    /// between the rays, where the first and the last ray stand for the ends too; fewer rays share alike.
    #[inline(always)]
    fn share(&self, per_pixel: u32) -> f32 {
        let rays = match self.next {
            _ if per_pixel < TRAPEZOIDS => 1.0,
            0 => self.offset + 0.5,
            next if next + 1 == per_pixel => 1.5 - self.offset,
            _ => 1.0,
        };
        rays / per_pixel as f32
    }

    #[inline(always)]
    fn is_reached(&self, before: f32, per_pixel: u32) -> bool {
        self.next < per_pixel && self.target(per_pixel) <= before
    }

    /// Whether a shadow ray begins in the next block, of this `luminance`. If not, the block is passed.
    #[inline(always)]
    fn passes(&mut self, luminance: f32, per_pixel: u32) -> bool {
        let after = self.before + luminance;
        let passes = luminance > 0.0 && self.is_reached(after, per_pixel);
        if !passes {
            self.before = after;
        }
        passes
    }

    /// Chooses places of `block`, whose luminance is `whole`.
    fn choose(
        &mut self,
        block: &Block,
        whole: f32,
        (per_pixel, colours): (u32, [&[f32]; 3]),
        chosen: &mut Vec<Chosen>,
    ) {
        let after = self.before + whole;
        for place in block.from..block.to {
            let own = luminance(colours.map(|channel| channel[place]));
            self.before += own;
            if place + 1 == block.to {
                // Sums in another order round differently.
                self.before = after;
            }
            let mut share = 0.0;
            while self.is_reached(self.before, per_pixel) {
                share += self.share(per_pixel);
                self.next += 1;
            }
            if share > 0.0 && own > 0.0 {
                chosen.push(Chosen { ray: block.ray, place, weight: share * self.luminance / own });
            }
        }
    }
}

/// Luminance of the places of `block`.
#[inline(always)]
fn block_luminance<V: SimdF32>(zero: V, colours: [&[f32]; 3], block: &Block) -> f32 {
    let inside = zero.iota().simd_lt(zero.splat((block.to - block.from) as f32));
    let [r, g, b] = LUMINANCE;
    let red = zero.splat(r) * zero.load(&colours[0][block.from..]);
    let green = zero.splat(g).mul_add(zero.load(&colours[1][block.from..]), red);
    let all = zero.splat(b).mul_add(zero.load(&colours[2][block.from..]), green);
    V::select(inside, all, zero).sum()
}

/// Shares of red, green and blue in luminance (Rec. 709).
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

#[inline(always)]
fn luminance(colour: [f32; 3]) -> f32 {
    (0..3).map(|c| LUMINANCE[c] * colour[c]).sum()
}
