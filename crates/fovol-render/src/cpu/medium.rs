//! The media of rays, in lanes.

use super::field::{Field, Texel};
use super::light_columns::LightColumns;
use super::shadow_pool::ShadowPool;
use super::shadow_rays::{Parts, ShadowRays};
use crate::scene::{LightPath, MAX_BLUE, MAX_RED_GREEN, TransferTable};
use bytemuck::cast_slice;
use fovol_simd::{Simd, SimdF32, SimdF32Op, SimdI32};

/// Medium of rays: one volume, or several at the same points.
pub trait Medium {
    /// α of one step and the colour of samples at `p`, of which those that are `inside` count. `None` where all of them show
    /// nothing.
    fn appearance<V: SimdF32>(&self, p: [V; 3], inside: V::Mask) -> Option<(V, [V; 3])>;

    /// |n·l| at `p` for light from `light`; 1 where the gradient is zero or not known.
    fn facing<V: SimdF32>(&self, p: [V; 3], light: [f32; 3]) -> V;

    /// α of one shadow step at `p`.
    fn shadow_alpha<V: SimdF32>(&self, p: [V; 3]) -> V;

    /// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64;

    /// Runs `work` with vectors of `simd`.
    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output;
}

/// The way of shadow rays.
pub struct WayToLight<'a> {
    /// Where they take their samples.
    pub path: &'a LightPath,
    /// Which samples can have opacity; `None` where skipping the others does not pay.
    pub columns: Option<&'a LightColumns>,
    /// The instruction set.
    pub simd: Simd,
}

/// One volume.
pub struct OneVolume<'a, T: Texel> {
    /// The volume, scaled to indices of the table.
    pub field: Field<'a, T>,
    /// The edges of a voxel in world units.
    pub voxel_size: [f32; 3],
    /// Display value to colour and opacity.
    pub table: &'a TransferTable,
    /// Bounds of the table's visible part; see [`TransferTable::visible`].
    pub visible: [f32; 2],
}

impl<'a, T: Texel> OneVolume<'a, T> {
    /// The volume of `field`, which is scaled to indices of `table`.
    pub fn new(field: Field<'a, T>, voxel_size: [f32; 3], table: &'a TransferTable) -> Self {
        Self { field, voxel_size, table, visible: table.visible() }
    }

    /// The entry of the table for samples at `p`, and which of those that are `inside` it may show.
    #[inline(always)]
    pub fn entry<V: SimdF32>(&self, p: [V; 3], inside: V::Mask) -> (V, V::Mask) {
        let zero = p[0].splat(0.0);
        let value = self.field.sample(p) + zero.splat(0.5);
        let [first, end] = self.visible;
        let shown = value.simd_gt(zero.splat(first)) & value.simd_lt(zero.splat(end));
        (value, inside & shown)
    }
}

impl<T: Texel> Medium for OneVolume<'_, T> {
    #[inline(always)]
    fn appearance<V: SimdF32>(&self, p: [V; 3], inside: V::Mask) -> Option<(V, [V; 3])> {
        let (value, shown) = self.entry(p, inside);
        if V::bits_of(shown) == 0 {
            return None;
        }
        let index = value.to_i32();
        // SAFETY: visible values are indices of the table, others are below its scale or the entry of NaN.
        let [alpha, packed] =
            unsafe { V::load_word_pairs(cast_slice(&self.table.appearance), index + index) };
        Some((V::select(shown, V::from_bits(alpha), value.splat(0.0)), colours(packed)))
    }

    #[inline(always)]
    fn facing<V: SimdF32>(&self, p: [V; 3], light: [f32; 3]) -> V {
        let zero = p[0].splat(0.0);
        let one = zero.splat(1.0);
        let (mut squared, mut along, mut highest) = (zero, zero, zero);
        for a in 0..3 {
            let (mut before, mut after) = (p, p);
            before[a] = p[a] - one;
            after[a] = p[a] + one;
            let (after, before) = (self.field.sample(after), self.field.sample(before));
            if self.field.has_gaps() {
                highest = highest.max(after.max(before));
            }
            let difference = after - before;
            // Only the ratios of the components matter, so the field's own scale may stay.
            let g = difference * zero.splat(1.0 / self.voxel_size[a]);
            squared = g.mul_add(g, squared);
            along = g.mul_add(zero.splat(light[a]), along);
        }
        let facing = (along / squared.sqrt()).abs();
        let known = squared.simd_gt(zero);
        // Beside NaN there is no gradient.
        let complete = highest.simd_lt(zero.splat(self.field.missing));
        let known = if self.field.has_gaps() { known & complete } else { known };
        V::select(known, facing, one)
    }

    #[inline(always)]
    fn shadow_alpha<V: SimdF32>(&self, p: [V; 3]) -> V {
        let index = (self.field.sample(p) + p[0].splat(0.5)).to_i32();
        // SAFETY: the field is scaled to indices of the table.
        unsafe { V::gather(&self.table.shadow_alpha, index) }
    }

    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        let rays = ShadowRays {
            field: &self.field,
            alpha: &self.table.shadow_alpha,
            light: to_light.path,
            columns: to_light.columns,
        };
        rays.trace(to_light.simd, pool, parts)
    }

    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        T::in_vectors(simd, work)
    }
}

/// Unpacks colours of a [`TransferTable`].
#[inline(always)]
pub(super) fn colours<V: SimdF32>(packed: V::I32) -> [V; 3] {
    let field = packed.splat(MAX_RED_GREEN as i32);
    let red = V::from_i32(packed & field);
    let green = V::from_i32(packed.shr::<11>() & field);
    let blue = V::from_i32(packed.shr::<22>());
    let scale = red.splat(1.0 / MAX_RED_GREEN);
    [red * scale, green * scale, blue * red.splat(1.0 / MAX_BLUE)]
}
