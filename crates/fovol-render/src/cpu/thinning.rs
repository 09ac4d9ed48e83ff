//! Opacity that depends on the gradient, in lanes.

use super::field::{Field, Texel};
use super::fine::passing;
use super::shadow_rays::Absorber;
use crate::scene::{BlendTable, BrickData, Bricks, SHADOW_STEP};
use fovol_simd::{Simd, SimdF32, SimdF32Op};

/// Factors of the extinction of a volume by the lengths of its gradients.
#[derive(Clone, Copy)]
pub struct Thinning<'a> {
    /// Lengths of gradients, scaled to indices of `factors`.
    lengths: Field<'a, u16>,
    factors: &'a [f32],
    /// The last index of `factors`.
    last: f32,
    /// Extinction per reference length of every entry of the volume's table.
    extinction: &'a [f32],
    /// The entry of NaN, whose opacity depends on no gradient.
    missing: f32,
    /// Primary step in voxels.
    step: f32,
}

impl<'a> Thinning<'a> {
    /// Factors of `table` for gradients of the `lengths`; `None` where the opacity depends on no gradient.
    pub fn new(lengths: Option<&'a Bricks>, table: &'a BlendTable) -> Option<Self> {
        let (lengths, gradient) = (lengths?, table.gradient.as_ref()?);
        let BrickData::U16(values) = lengths.data() else { return None };
        Some(Self {
            lengths: Field::new(lengths, &values[..], gradient.scale),
            factors: &gradient.factors,
            last: gradient.last(),
            extinction: &table.extinction,
            missing: table.transfer.scale() + 1.0,
            step: table.step,
        })
    }

    /// Extinction per reference length at `p`, where the table of the volume has the `entry`.
    #[inline(always)]
    pub fn extinction<V: SimdF32>(&self, p: [V; 3], entry: V) -> V {
        let (half, one) = (entry.splat(0.5), entry.splat(1.0));
        let length = self.lengths.sample(p).min(entry.splat(self.last));
        // SAFETY: lengths are 0 or more, and at most the last index; entries are indices of the other table.
        let [factor, extinction] = unsafe {
            [V::gather(self.factors, (length + half).to_i32()), V::gather(self.extinction, entry.to_i32())]
        };
        extinction * V::select(entry.simd_lt(entry.splat(self.missing)), factor, one)
    }

    /// α of a primary step through matter of `extinction`.
    #[inline(always)]
    pub fn alpha<V: SimdF32>(&self, extinction: V) -> V {
        extinction.splat(1.0) - passing(extinction * extinction.splat(self.step))
    }

    /// α of a shadow step at `p`, where the table of the volume has the `entry`.
    #[inline(always)]
    pub fn shadow_alpha<V: SimdF32>(&self, p: [V; 3], entry: V) -> V {
        let depth = self.extinction(p, entry) * entry.splat(SHADOW_STEP * self.step);
        entry.splat(1.0) - passing(depth)
    }
}

/// One volume that absorbs light as its values and gradients decide.
pub struct ByGradient<'a, 'v, 't, T: Texel> {
    /// The volume, scaled to indices of its table.
    pub field: &'a Field<'v, T>,
    /// Factors of the extinction by its gradients.
    pub thinning: Thinning<'t>,
}

impl<T: Texel> Absorber for ByGradient<'_, '_, '_, T> {
    #[inline(always)]
    fn alpha<V: SimdF32>(&self, p: [V; 3]) -> V {
        self.thinning.shadow_alpha(p, self.field.sample(p) + p[0].splat(0.5))
    }

    fn in_vectors<W: SimdF32Op>(simd: Simd, work: W) -> W::Output {
        T::in_vectors(simd, work)
    }
}
