//! The media of rays, in lanes.

use super::field::{Field, Texel};
use super::light_columns::LightColumns;
use super::shadow_pool::ShadowPool;
use super::shadow_rays::{ByValue, Parts, ShadowRays};
use crate::scene::{LightPath, MAX_BLUE, MAX_RED_GREEN, TransferTable};
use bytemuck::cast_slice;
use fovol_simd::{Simd, SimdF32, SimdF32Op, SimdI32};

/// Medium of rays: one volume, or several at the same points.
pub trait Medium {
    /// The appearance of samples at two `places`, of which those that are `inside` count. `None` where all of them show
    /// nothing.
    fn look_at<V: SimdF32>(&self, places: [[V; 3]; 2], inside: [V::Mask; 2]) -> Option<[Look<V>; 2]>;

    /// |n·l| at `p` for light from `light`; 1 where the gradient is zero or not known.
    fn facing<V: SimdF32>(&self, p: [V; 3], light: [f32; 3]) -> V;

    /// α of one shadow step at `p`.
    fn shadow_alpha<V: SimdF32>(&self, p: [V; 3]) -> V;

    /// Finds the transmittance of every sample in `pool`; returns how many shadow samples that took.
    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64;

    /// Runs `work` with vectors of `simd`.
    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output;
}

/// The appearance of samples.
#[derive(Clone, Copy)]
pub struct Look<V: SimdF32> {
    /// The samples that may be visible, one bit each.
    pub shown: u32,
    /// α of one step; 0 where nothing is visible.
    pub alpha: V,
    /// Colours as a [`TransferTable`] packs them.
    pub packed: V::I32,
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

    /// The entries of the table for samples at `p`.
    #[inline(always)]
    pub fn entry<V: SimdF32>(&self, p: [V; 3]) -> V {
        self.field.sample(p) + p[0].splat(0.5)
    }

    /// Which samples of `entry`, of those that are `inside`, the table may show.
    #[inline(always)]
    pub fn shown<V: SimdF32>(&self, entry: V, inside: V::Mask) -> V::Mask {
        let [first, end] = self.visible;
        inside & (entry.simd_gt(entry.splat(first)) & entry.simd_lt(entry.splat(end)))
    }

    /// The appearance of samples of `entry`, of which those that are `shown` may be visible.
    #[inline(always)]
    pub fn look<V: SimdF32>(&self, entry: V, shown: V::Mask) -> Look<V> {
        let index = entry.to_i32();
        // SAFETY: visible values are indices of the table, others are below its scale or the entry of NaN.
        let [alpha, packed] =
            unsafe { V::load_word_pairs(cast_slice(&self.table.appearance), index + index) };
        let alpha = V::select(shown, V::from_bits(alpha), entry.splat(0.0));
        Look { shown: V::bits_of(shown), alpha, packed }
    }
}

impl<T: Texel> Medium for OneVolume<'_, T> {
    #[inline(always)]
    fn look_at<V: SimdF32>(&self, [p, q]: [[V; 3]; 2], inside: [V::Mask; 2]) -> Option<[Look<V>; 2]> {
        let [entry_p, entry_q] = self.field.sample_pair(p, q);
        let (entry_p, entry_q) = (entry_p + p[0].splat(0.5), entry_q + q[0].splat(0.5));
        let (shown_p, shown_q) = (self.shown(entry_p, inside[0]), self.shown(entry_q, inside[1]));
        if V::bits_of(shown_p) | V::bits_of(shown_q) == 0 {
            return None;
        }
        Some([self.look(entry_p, shown_p), self.look(entry_q, shown_q)])
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
        let index = self.entry(p).to_i32();
        // SAFETY: the field is scaled to indices of the table.
        unsafe { V::gather(&self.table.shadow_alpha, index) }
    }

    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        let rays = ShadowRays {
            absorber: ByValue { field: &self.field, alpha: &self.table.shadow_alpha },
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

/// Packs `colours`, 0…1, as [`colours`] unpacks them.
#[inline(always)]
pub(super) fn packed<V: SimdF32>([red, green, blue]: [V; 3]) -> V::I32 {
    let whole = |channel: V, most: f32| channel.mul_add(channel.splat(most), channel.splat(0.5)).to_i32();
    let (red, green, blue) = (whole(red, MAX_RED_GREEN), whole(green, MAX_RED_GREEN), whole(blue, MAX_BLUE));
    red + (green * red.splat(1 << 11) + blue * red.splat(1 << 22))
}
