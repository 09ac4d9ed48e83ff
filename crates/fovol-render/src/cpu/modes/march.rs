//! The specification of projections and isosurfaces, as plain code.

use super::super::march::{March, SampleCount};
use super::projected::projected;
use crate::scene::{Bricks, LightPath, RayResult, SHADOW_START, Segment, blended_results};
use fovol_core::{Ray, RayMode, ShadowMode, TransferFunction};

/// How often the part of a ray in which it crosses an isosurface is halved.
const HALVINGS: u32 = 10;

impl March<'_> {
    /// Marches `ray` in the mode of this scene, which is not [`RayMode::Composite`].
    pub fn mode_ray(&self, ray: &Ray, count: &mut SampleCount) -> RayResult {
        match self.mode {
            RayMode::Isosurface(value) => self.isosurface_ray(value, ray, count),
            _ => self.projection_ray(ray, count),
        }
    }

    /// Shows the greatest, least or mean value along `ray`; of several volumes each on its own, blended.
    fn projection_ray(&self, ray: &Ray, count: &mut SampleCount) -> RayResult {
        let own = self.projection_of((self.bricks, self.transfer), ray, count);
        if self.layers.is_empty() {
            return own;
        }
        let others =
            self.layers.iter().map(|layer| self.projection_of((&layer.bricks, &layer.transfer), ray, count));
        let all: Vec<RayResult> = std::iter::once(own).chain(others).collect();
        blended_results(&all, self.background.map(|c| c as f32))
    }

    /// Shows the greatest, least or mean value of one volume along `ray`. NaN counts only where there is nothing else.
    fn projection_of(
        &self,
        (bricks, transfer): (&Bricks, &TransferFunction),
        ray: &Ray,
        count: &mut SampleCount,
    ) -> RayResult {
        let segment = self.segments().of(ray);
        let (mut shown, mut number, mut known) = (f64::NAN, 0.0, 0.0);
        for k in 0..segment.count {
            count.primary += 1;
            let value = f64::from(bricks.sample(segment.position(k)));
            if value.is_nan() {
                continue;
            }
            known += 1.0;
            let is_shown = shown.is_nan()
                || match self.mode {
                    RayMode::Mip => value > shown,
                    RayMode::Minip => value < shown,
                    _ => false,
                };
            if self.mode == RayMode::Average && known > 1.0 {
                shown += (value - shown) / known;
                number += (f64::from(k) - number) / known;
            } else if is_shown {
                (shown, number) = (value, f64::from(k));
            }
        }
        let background = self.background.map(|c| c as f32);
        if segment.count == 0 {
            return RayResult::nothing(background);
        }
        projected(transfer, background, shown, self.segments().distance(segment.distance, number as f32))
    }

    /// Shows the first place along `ray` where values cross `iso`.
    fn isosurface_ray(&self, iso: f32, ray: &Ray, count: &mut SampleCount) -> RayResult {
        let segment = self.segments().of(ray);
        let mut before = f32::NAN;
        for k in 0..segment.count {
            count.primary += 1;
            let value = self.bricks.sample(segment.position(k));
            let is_known = !before.is_nan() && !value.is_nan();
            if is_known && (before >= iso) != (value >= iso) {
                let crossing = Crossing { iso, before: k as f32 - 1.0, is_from_above: before >= iso };
                let number = self.refined(&segment, &crossing);
                let is_lit = !self.casts_mode_shadows() || self.is_lit(segment.at(number), &crossing, count);
                return self.surface_result(&segment, number, (iso, is_lit));
            }
            before = value;
        }
        RayResult::nothing(self.background.map(|c| c as f32))
    }

    /// The number of the sample, with a fraction, at which the ray of `segment` crosses the surface.
    pub fn refined(&self, segment: &Segment, crossing: &Crossing) -> f32 {
        let (mut low, mut high) = (crossing.before, crossing.before + 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if (self.bricks.sample(segment.at(middle)) >= crossing.iso) == crossing.is_from_above {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// The result of the ray of `segment`, which meets the surface of the value `iso` at sample `number`. Light
    /// arrives there or not.
    pub fn surface_result(&self, segment: &Segment, number: f32, (iso, is_lit): (f32, bool)) -> RayResult {
        let [r, g, b, _] = self.transfer.evaluate(f64::from(iso)).map(|channel| channel as f32);
        let ambient = self.shading.ambient as f32;
        let unshadowed = ambient + (1.0 - ambient) * self.facing(segment.at(number));
        let light = if is_lit { unshadowed } else { ambient };
        RayResult {
            colour: [r, g, b].map(|channel| light * channel),
            unshadowed: [r, g, b].map(|channel| unshadowed * channel),
            opacity: 1.0,
            depth: self.segments().distance(segment.distance, number),
        }
    }

    /// Whether surfaces cast shadows. Cached shadows are those of composited pictures, so surfaces have rays instead.
    pub fn casts_mode_shadows(&self) -> bool {
        self.shading.shadows != ShadowMode::Off
    }

    /// Whether light comes to `p` on the side of the surface that the eye is on: everything up to the light is on that
    /// side.
    fn is_lit(&self, p: [f32; 3], crossing: &Crossing, count: &mut SampleCount) -> bool {
        let light: LightPath = self.light_path();
        let way = light.way_out(p);
        let mut steps = SHADOW_START;
        while steps < way {
            count.shadow += 1;
            let value = self.bricks.sample(light.at(p, steps));
            if !value.is_nan() && (value >= crossing.iso) != crossing.is_from_above {
                return false;
            }
            steps += 1.0;
        }
        true
    }
}

/// Two samples between which a ray crosses a surface.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// The value of the surface.
    pub iso: f32,
    /// The number of the sample before it.
    pub before: f32,
    /// Whether that sample has the value or more.
    pub is_from_above: bool,
}
