//! The specification of image formation, as plain code.
//!
//! Nothing here is fast. Every faster path is compared with it.

use super::few_shadow_rays::{Chosen, choose_places};
use super::prepared_layer::PreparedLayer;
use crate::scene::{
    Bricks, LightPath, RayResult, SHADOW_START, SHADOW_STEP, Segments, blended, corrected_opacity,
    extinction, thinned,
};
use fovol_core::{ClipBox, Grid, Ray, RayMode, Shading, ShadowMode, SurfaceShading, TransferFunction};

/// A primary ray ends at this accumulated opacity.
pub const OPAQUE: f32 = 0.999;
/// A shadow ray ends below this transmittance.
pub const DARK: f32 = 0.001;

/// The scene that the scalar specification marches rays through.
pub struct March<'a> {
    /// The voxels.
    pub bricks: &'a Bricks,
    /// Dimensions, spacing and place of the volume in the world.
    pub grid: &'a Grid,
    /// The crop box: only samples inside it count.
    pub clip: ClipBox,
    /// Display value to colour and opacity.
    pub transfer: &'a TransferFunction,
    /// Red, green and blue of the voxels, where they have colours.
    pub colours: Option<&'a [Bricks; 3]>,
    /// Lengths of the gradients, where the opacity depends on them.
    pub gradients: Option<&'a Bricks>,
    /// Further volumes at the same points.
    pub layers: &'a [PreparedLayer],
    /// Values along rays that pixels show.
    pub mode: RayMode,
    /// How samples are lit.
    pub shading: &'a Shading,
    /// Transmittance towards the light at every voxel, where shadows are cached.
    pub shadow_grid: Option<&'a Bricks>,
    /// The background colour, RGB.
    pub background: [f64; 3],
    /// The sampling distance in voxels.
    pub step: f64,
    /// Shadow rays of each pixel and the noise of this one, where not every sample has one.
    pub few: Option<(u32, f32)>,
}

/// How many samples rays took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleCount {
    /// Along primary rays.
    pub primary: u64,
    /// Along shadow rays.
    pub shadow: u64,
}

impl std::ops::AddAssign for SampleCount {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
    }
}

impl March<'_> {
    /// Where primary rays take their samples.
    pub fn segments(&self) -> Segments {
        Segments::new(self.grid, &self.clip, self.step)
    }

    /// The way to the light.
    pub fn light_path(&self) -> LightPath {
        LightPath::new(&self.shading.light, self.grid, &self.clip, self.step)
    }

    /// Marches `ray` and returns its colour over the background, its opacity and its depth; adds to `count`.
    pub fn ray(&self, ray: &Ray, count: &mut SampleCount) -> RayResult {
        let segments = self.segments();
        let segment = segments.of(ray);
        let light = self.light_path();
        let [mut colour, mut unshadowed] = [[0.0f32; 3]; 2];
        let mut opacity = 0.0f32;
        let mut half_at = None;
        let mut weighted_number = 0.0f32;
        let mut waiting: Vec<([f32; 3], [f32; 3])> = Vec::new();
        for k in 0..segment.count {
            if opacity >= OPAQUE {
                break;
            }
            count.primary += 1;
            let p = segment.position(k);
            let rgba = self.appearance(p);
            let alpha = corrected_opacity(rgba[3], self.step);
            if alpha == 0.0 {
                continue;
            }
            let weight = alpha * (1.0 - opacity);
            let rgb = [0, 1, 2].map(|c| weight * rgba[c] as f32);
            let waits = self.casts_rays() && self.few.is_some();
            let lit = if waits { self.light_without_shadows(p) } else { self.light(p, &light, count) };
            let unshadowed_light = if self.casts_rays() { self.light_without_shadows(p) } else { lit };
            for c in 0..3 {
                colour[c] += lit * rgb[c];
                unshadowed[c] += unshadowed_light * rgb[c];
            }
            if waits {
                let direct = (1.0 - self.shading.ambient as f32) * self.surface(p);
                waiting.push((p, rgb.map(|value| direct * value)));
            }
            opacity += weight;
            weighted_number += weight * k as f32;
            if opacity >= 0.5 && half_at.is_none() {
                half_at = Some(k as f32);
            }
        }
        if let Some((per_pixel, offset)) = self.few {
            let colours: Vec<[f32; 3]> = waiting.iter().map(|(_, rgb)| *rgb).collect();
            for Chosen { place, weight, .. } in choose_places(offset, per_pixel, &colours) {
                let dark = weight * (self.transmittance(waiting[place].0, &light, count) - 1.0);
                (0..3).for_each(|c| colour[c] += dark * colours[place][c]);
            }
        }
        let colour = std::array::from_fn(|c| colour[c] + (1.0 - opacity) * self.background[c] as f32);
        if opacity == 0.0 {
            return RayResult::nothing(colour);
        }
        let number = half_at.unwrap_or(weighted_number / opacity);
        let depth = segments.distance(segment.distance, number);
        RayResult { colour, unshadowed, opacity, depth }
    }

    /// The factor by which light scales the colour at `p`: ambient + (1 − ambient)·T·|n·l|.
    fn light(&self, p: [f32; 3], light: &LightPath, count: &mut SampleCount) -> f32 {
        let transmittance = match (self.shading.shadows, self.shadow_grid) {
            (ShadowMode::Off, _) => 1.0,
            (ShadowMode::Cached, Some(grid)) => self.cached_transmittance(p, light, grid),
            (ShadowMode::On | ShadowMode::Cached, _) => self.transmittance(p, light, count),
        };
        let ambient = self.shading.ambient as f32;
        ambient + (1.0 - ambient) * transmittance * self.surface(p)
    }

    /// The factor by which light scales the colour at `p` where nothing casts a shadow.
    fn light_without_shadows(&self, p: [f32; 3]) -> f32 {
        let ambient = self.shading.ambient as f32;
        ambient + (1.0 - ambient) * self.surface(p)
    }

    /// Colour and opacity per reference length at `p`.
    fn appearance(&self, p: [f32; 3]) -> [f64; 4] {
        let first = coloured(own_appearance(self.first(), p), self.colours, p);
        if self.layers.is_empty() {
            return first;
        }
        let others = self
            .layers
            .iter()
            .map(|layer| coloured(own_appearance(values_of(layer), p), layer.colours.as_ref(), p));
        blended(std::iter::once(first).chain(others))
    }

    /// Values of the first volume.
    fn first(&self) -> Values<'_> {
        (self.transfer, self.bricks, self.gradients)
    }

    /// Whether shadow rays are marched.
    pub(super) fn casts_rays(&self) -> bool {
        match self.shading.shadows {
            ShadowMode::Off => false,
            ShadowMode::Cached => self.shadow_grid.is_none(),
            ShadowMode::On => true,
        }
    }

    /// The factor of direct light at `p` for its surface: |n·l|, or 1 with flat shading.
    pub(super) fn surface(&self, p: [f32; 3]) -> f32 {
        match self.shading.surface {
            SurfaceShading::Flat => 1.0,
            SurfaceShading::Gradient => self.facing(p),
        }
    }

    /// T = ∏(1 − α_j) along the shadow ray of `p`.
    pub fn transmittance(&self, p: [f32; 3], light: &LightPath, count: &mut SampleCount) -> f32 {
        let mut transmittance = 1.0f32;
        for j in 0..light.count(p) {
            if transmittance < DARK {
                break;
            }
            count.shadow += 1;
            let opacity = self.appearance(light.position(p, j))[3];
            transmittance *= 1.0 - corrected_opacity(opacity, self.step * f64::from(SHADOW_STEP));
        }
        transmittance
    }

    /// T of `p` by its first shadow sample, and by `grid` from where that sample's stretch ends.
    fn cached_transmittance(&self, p: [f32; 3], light: &LightPath, grid: &Bricks) -> f32 {
        let way = light.way_out(p);
        let mut transmittance = 1.0;
        if way > SHADOW_START {
            let opacity = self.appearance(light.position(p, 0))[3];
            transmittance -= corrected_opacity(opacity, self.step * f64::from(SHADOW_STEP));
        }
        if way > SHADOW_START + SHADOW_STEP {
            let after = std::array::from_fn(|a| SHADOW_STEP.mul_add(light.delta[a], p[a]));
            transmittance *= grid.sample(after);
        }
        transmittance
    }

    /// |n·l| with n from central differences over ±1 voxel in world units; 1 where the gradient is zero or
    /// not known, beside NaN. Of several volumes the mean, weighted by their extinction at `p`.
    pub(super) fn facing(&self, p: [f32; 3]) -> f32 {
        let own = self.facing_in(self.bricks, p);
        if self.layers.is_empty() {
            return own;
        }
        let weight = |values| extinction(own_appearance(values, p)[3]) as f32;
        let first = weight(self.first());
        let (mut whole, mut sum) = (first, first * own);
        for layer in self.layers {
            let weight = weight(values_of(layer));
            whole += weight;
            sum += weight * self.facing_in(&layer.bricks, p);
        }
        if whole > 0.0 { sum / whole } else { 1.0 }
    }

    /// [`Self::facing`] of the values of `bricks` alone.
    fn facing_in(&self, bricks: &Bricks, p: [f32; 3]) -> f32 {
        let voxel = self.grid.voxel_size();
        let gradient: [f32; 3] = std::array::from_fn(|a| {
            let (mut before, mut after) = (p, p);
            before[a] -= 1.0;
            after[a] += 1.0;
            (bricks.sample(after) - bricks.sample(before)) / voxel[a] as f32
        });
        let length = gradient.iter().map(|g| g * g).sum::<f32>().sqrt();
        let light = self.shading.light.direction();
        let along: f32 = (0..3).map(|a| gradient[a] * light[a] as f32).sum();
        if length > 0.0 { (along / length).abs() } else { 1.0 }
    }
}

/// Transfer function, values, and lengths of gradients of one volume.
type Values<'a> = (&'a TransferFunction, &'a Bricks, Option<&'a Bricks>);

fn values_of(layer: &PreparedLayer) -> Values<'_> {
    (&layer.transfer, &layer.bricks, layer.gradients.as_ref())
}

/// Colour and opacity per reference length that one volume has at `p` by its transfer function. The opacity of NaN
/// depends on no gradient.
fn own_appearance((transfer, bricks, gradients): Values<'_>, p: [f32; 3]) -> [f64; 4] {
    let value = f64::from(bricks.sample(p));
    let [r, g, b, opacity] = transfer.evaluate(value);
    match (transfer.gradient_opacity(), gradients) {
        (Some(curve), Some(lengths)) => {
            let factor = if value.is_nan() { 1.0 } else { curve.evaluate(lengths.sample(p).into()) };
            [r, g, b, thinned(opacity, factor)]
        }
        _ => [r, g, b, opacity],
    }
}

/// `own` colour and opacity, but for the colour at `p` where voxels have `colours`.
fn coloured(own: [f64; 4], colours: Option<&[Bricks; 3]>, p: [f32; 3]) -> [f64; 4] {
    match colours {
        Some([r, g, b]) => [r.sample(p).into(), g.sample(p).into(), b.sample(p).into(), own[3]],
        None => own,
    }
}
