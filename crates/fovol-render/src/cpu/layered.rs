//! Several volumes at the same points, and volumes whose voxels have colours or whose opacity depends on the gradient,
//! as lanes see them.

use super::field::{AnyType, AnyValues, Field, InlinedAnyType, Texel, with_field};
use super::medium::{Look, Medium, OneVolume, WayToLight, colours, packed};
use super::shadow_pool::ShadowPool;
use super::shadow_rays::{Absorber, ByValue, Parts, ShadowRays};
use super::thinning::{ByGradient, Thinning};
use crate::scene::{BlendTable, Bricks};
use fovol_simd::{Simd, SimdF32, SimdF32Op};

/// Volumes at the same points: several, or one that is more than values and a table.
pub struct Layered<'a>(pub Vec<Layer<'a>>);

/// One of several volumes.
pub struct Layer<'a> {
    /// The voxels.
    bricks: &'a Bricks,
    /// The volume as a medium of its own.
    own: OneVolume<'a, InlinedAnyType>,
    /// Extinction of every entry of its table.
    extinction: &'a [f32],
    /// Red, green and blue of the voxels, where these have colours.
    colours: Option<[Field<'a, InlinedAnyType>; 3]>,
    /// Factors of the extinction, where the opacity depends on the gradient.
    thinning: Option<Thinning<'a>>,
}

/// Voxels of one of several volumes.
#[derive(Clone, Copy)]
pub struct LayerVoxels<'a> {
    /// The values.
    pub bricks: &'a Bricks,
    /// Red, green and blue, where voxels have colours.
    pub colours: Option<&'a [Bricks; 3]>,
    /// Lengths of the gradients, where the opacity depends on them.
    pub gradients: Option<&'a Bricks>,
}

impl<'a> Layer<'a> {
    /// The volume of `voxels` with `table`.
    pub fn new(voxels: LayerVoxels<'a>, voxel_size: [f32; 3], table: &'a BlendTable) -> Self {
        let LayerVoxels { bricks, colours, gradients } = voxels;
        let field = |bricks: &'a Bricks, unit: f32| {
            Field::<InlinedAnyType>::new(bricks, AnyValues::new(bricks), unit)
        };
        let own = OneVolume::new(field(bricks, table.transfer.scale()), voxel_size, &table.transfer);
        let colours = colours.map(|colours| colours.each_ref().map(|channel| field(channel, 1.0)));
        let thinning = Thinning::new(gradients, table);
        Self { bricks, own, extinction: &table.extinction, colours, thinning }
    }

    /// Extinction at `p`, where the table has the `entry`, if it may show anything, and 0 elsewhere.
    #[inline(always)]
    fn extinction<V: SimdF32>(&self, p: [V; 3], entry: V, shown: V::Mask) -> V {
        let zero = entry.splat(0.0);
        let extinction = match &self.thinning {
            Some(thinning) => thinning.extinction(p, entry),
            // SAFETY: the field is scaled to indices of the table.
            None => unsafe { V::gather(self.extinction, entry.to_i32()) },
        };
        V::select(shown, extinction, zero)
    }

    /// α of one shadow step at `p`.
    #[inline(always)]
    fn shadow_alpha<V: SimdF32>(&self, p: [V; 3]) -> V {
        match &self.thinning {
            Some(thinning) => thinning.shadow_alpha(p, self.own.entry(p)),
            None => self.own.shadow_alpha(p),
        }
    }
}

impl Layered<'_> {
    /// The appearance of samples at `p`, of which those that are `inside` count.
    #[inline(always)]
    fn blended<V: SimdF32>(&self, p: [V; 3], inside: V::Mask) -> Look<V> {
        let (zero, one) = (p[0].splat(0.0), p[0].splat(1.0));
        let (mut clear, mut whole, mut sums) = (one, zero, [zero; 3]);
        let mut any = 0;
        for layer in &self.0 {
            let entry = layer.own.entry(p);
            let shown = layer.own.shown(entry, inside);
            if V::bits_of(shown) == 0 {
                continue;
            }
            let weight = layer.extinction(p, entry, shown);
            let mut own = layer.own.look(entry, shown);
            if let Some(thinning) = &layer.thinning {
                own.alpha = thinning.alpha(weight);
                own.shown = V::bits_of(weight.simd_gt(zero));
            }
            any |= own.shown;
            let rgb = match &layer.colours {
                Some([red, green, blue]) => [red.sample(p), green.sample(p), blue.sample(p)],
                None => colours(own.packed),
            };
            clear = clear * (one - own.alpha);
            whole = whole + weight;
            for c in 0..3 {
                sums[c] = weight.mul_add(rgb[c], sums[c]);
            }
        }
        let share = V::select(whole.simd_gt(zero), one / whole, zero);
        let rgb = [sums[0] * share, sums[1] * share, sums[2] * share];
        Look {
            shown: any,
            alpha: one - clear,
            packed: packed([rgb[0].min(one), rgb[1].min(one), rgb[2].min(one)]),
        }
    }
}

impl Medium for Layered<'_> {
    #[inline(always)]
    fn look_at<V: SimdF32>(&self, [p, q]: [[V; 3]; 2], inside: [V::Mask; 2]) -> Option<[Look<V>; 2]> {
        let looks = [self.blended(p, inside[0]), self.blended(q, inside[1])];
        (looks[0].shown | looks[1].shown != 0).then_some(looks)
    }

    /// The mean of the volumes' own factors, weighted by their extinction.
    #[inline(always)]
    fn facing<V: SimdF32>(&self, p: [V; 3], light: [f32; 3]) -> V {
        let (zero, one) = (p[0].splat(0.0), p[0].splat(1.0));
        let all = zero.mask_of(u32::MAX >> (32 - V::N));
        let (mut whole, mut sum) = (zero, zero);
        for layer in &self.0 {
            let entry = layer.own.entry(p);
            let shown = layer.own.shown(entry, all);
            let weight = layer.extinction(p, entry, shown);
            whole = whole + weight;
            sum = weight.mul_add(layer.own.facing(p, light), sum);
        }
        V::select(whole.simd_gt(zero), sum / whole, one)
    }

    #[inline(always)]
    fn shadow_alpha<V: SimdF32>(&self, p: [V; 3]) -> V {
        let one = p[0].splat(1.0);
        let mut clear = one;
        for layer in &self.0 {
            clear = clear * (one - layer.shadow_alpha(p));
        }
        one - clear
    }

    /// Traces all rays through one volume after another, and multiplies their transmittances.
    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        let mut taken = 0;
        let mut product = Vec::new();
        for layer in &self.0 {
            taken += layer.trace(to_light, pool, parts);
            let arrived = pool.transmittance();
            if product.is_empty() {
                product.extend_from_slice(arrived);
            } else {
                product.iter_mut().zip(arrived).for_each(|(product, arrived)| *product *= *arrived);
            }
        }
        pool.transmittance().copy_from_slice(&product);
        taken
    }

    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        simd.in_vectors(work)
    }
}

impl Layer<'_> {
    fn trace(&self, to_light: &WayToLight<'_>, pool: &mut ShadowPool, parts: &mut Parts) -> u64 {
        let unit = self.own.table.scale();
        if to_light.simd == Simd::Portable {
            let field = Field::<AnyType>::new(self.bricks, AnyValues::new(self.bricks), unit);
            return self.trace_in(&field, to_light, pool, parts);
        }
        with_field!(self.bricks, unit, field => self.trace_in(&field, to_light, pool, parts))
    }

    /// [`Self::trace`] through the voxels as `field`, which is scaled to indices of the table.
    fn trace_in<T: Texel>(
        &self,
        field: &Field<'_, T>,
        to_light: &WayToLight<'_>,
        pool: &mut ShadowPool,
        parts: &mut Parts,
    ) -> u64 {
        match self.thinning {
            Some(thinning) => traced(ByGradient { field, thinning }, to_light, pool, parts),
            None => {
                let alpha = &self.own.table.shadow_alpha;
                traced(ByValue { field, alpha }, to_light, pool, parts)
            }
        }
    }
}

/// Traces the shadow rays of `pool` through `absorber`; returns how many samples that took.
fn traced(
    absorber: impl Absorber,
    to_light: &WayToLight<'_>,
    pool: &mut ShadowPool,
    parts: &mut Parts,
) -> u64 {
    let rays = ShadowRays { absorber, light: to_light.path, columns: to_light.columns };
    rays.trace(to_light.simd, pool, parts)
}
