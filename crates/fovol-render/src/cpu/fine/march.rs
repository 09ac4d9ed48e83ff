//! The specification of fine integration, as plain code. docs/integration.md has its equations.

use super::super::few_shadow_rays::{Chosen, choose_places};
use super::super::march::{March, SampleCount};
use crate::scene::{ExtinctionTable, LightPath, RayResult, SHADOW_STEP, Segment};
use fovol_core::{Ray, ShadowMode};

/// The ends of the first steps of a shadow ray, as fractions of their total length.
pub const NEAR_STEPS: [f32; 4] = [0.125, 0.25, 0.5, 1.0];
/// Points beyond this optical depth are dark: −ln of [`DARK`].
pub const DEEP: f32 = 6.907_755;
/// A ray ends at this opacity. Its colour is then scaled to full opacity, as the rest would add less than 1/255.
pub const OPAQUE: f32 = 0.996;
/// Four steps of no more optical depth than this have nodes at their ends only.
pub const THIN: f32 = 0.25;

/// How much light comes to a point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Light {
    /// Optical depth of the near part of the shadow ray.
    pub near: f32,
    /// Transmittance of the far part of the shadow ray.
    pub far: f32,
}

/// One step of a ray: its table entries and its optical depth.
struct Step {
    /// Its place along the ray: the first step has number 0.
    number: f32,
    /// Entries of the transfer table at both ends.
    front: usize,
    behind: usize,
    /// Optical depth.
    depth: f32,
}

/// The sums of one ray so far.
#[derive(Default)]
struct Gathered {
    colour: [f32; 3],
    unshadowed: [f32; 3],
    /// Part of `colour` that shadows can take away.
    direct: [f32; 3],
    opacity: f32,
    weighted_number: f32,
    half_at: Option<f32>,
}

/// Part of a ray that waits for the light at its ends.
struct Waiting {
    ends: [f32; 2],
    /// Optical depth.
    depth: f32,
    /// Red, green and blue that shadows can take away.
    direct: [f32; 3],
}

/// Light where nothing casts shadows.
const FULL: Light = Light { near: 0.0, far: 1.0 };

impl March<'_> {
    /// Marches `ray` by fine integration and returns its colour over the background, its opacity and its depth.
    pub fn fine_ray(&self, table: &ExtinctionTable, ray: &Ray, count: &mut SampleCount) -> RayResult {
        let segments = self.segments();
        let segment = segments.of(ray);
        let path = self.light_path();
        let mut gathered = Gathered::default();
        let mut front = self.entry(table, segment.boundary(0.0));
        let mut lit: Option<Light> = None;
        let mut number = 0.0;
        let mut waiting = Vec::new();
        while number < segment.length && gathered.opacity < OPAQUE {
            let steps: [Step; 4] = std::array::from_fn(|i| {
                let step = self.step_between(table, &segment, number + i as f32, front, count);
                front = step.behind;
                step
            });
            let parts = if depth_of(&steps) <= THIN { 4 } else { 2 };
            for part in steps.chunks(parts) {
                if depth_of(part) == 0.0 {
                    lit = None;
                    continue;
                }
                if self.few.is_some() && self.casts_rays() {
                    let number = part[0].number;
                    let before = gathered.direct;
                    self.add_part(table, &segment, part, [FULL; 2], &mut gathered);
                    let direct = std::array::from_fn(|c| gathered.direct[c] - before[c]);
                    waiting.push(Waiting {
                        ends: [number, number + parts as f32],
                        depth: depth_of(part),
                        direct,
                    });
                    continue;
                }
                let mut light = |steps| self.light_at(table, segment.boundary(steps), &path, count);
                let before = lit.unwrap_or_else(|| light(part[0].number));
                let after = light(part[0].number + parts as f32);
                self.add_part(table, &segment, part, [before, after], &mut gathered);
                lit = Some(after);
            }
            number += 4.0;
        }
        if let Some(few) = self.few {
            let light = |steps, count: &mut _| self.light_at(table, segment.boundary(steps), &path, count);
            add_shadows(&waiting, few, |steps| light(steps, &mut *count), &mut gathered.colour);
        }
        let Gathered { colour, unshadowed, opacity, weighted_number, half_at, .. } = gathered;
        if opacity == 0.0 {
            return RayResult::nothing(self.background.map(|c| c as f32));
        }
        let (whole, left) = if opacity < OPAQUE { (1.0, 1.0 - opacity) } else { (opacity, 0.0) };
        let colour = std::array::from_fn(|c| colour[c] / whole + left * self.background[c] as f32);
        let unshadowed = unshadowed.map(|sum| sum / whole);
        let number = half_at.unwrap_or(weighted_number / opacity);
        let depth = segments.distance(segment.distance, number);
        RayResult { colour, unshadowed, opacity: 1.0 - left, depth }
    }

    /// The entry of the transfer table at `p`.
    fn entry(&self, table: &ExtinctionTable, p: [f32; 3]) -> usize {
        let value = self.bricks.sample(p);
        if value.is_nan() {
            table.nan_entry()
        } else {
            (value * (table.nan_entry() - 1) as f32 + 0.5) as usize
        }
    }

    /// Step `number` of `segment`, which begins at entry `front`.
    fn step_between(
        &self,
        table: &ExtinctionTable,
        segment: &Segment,
        number: f32,
        front: usize,
        count: &mut SampleCount,
    ) -> Step {
        let length = (segment.length - number).clamp(0.0, 1.0);
        if length == 0.0 {
            return Step { number, front, behind: front, depth: 0.0 };
        }
        count.primary += 1;
        let behind = self.entry(table, segment.boundary(number + 1.0));
        Step { number, front, behind, depth: table.mean(front, behind) * length }
    }

    /// Adds the light that the steps of `part` send to the eye; `light` arrives at its two ends.
    fn add_part(
        &self,
        table: &ExtinctionTable,
        segment: &Segment,
        part: &[Step],
        light: [Light; 2],
        gathered: &mut Gathered,
    ) {
        let arriving = arriving(depth_of(part), light);
        for step in part {
            self.add(table, segment, step, arriving, gathered);
        }
    }

    /// Adds the light that `step` sends to the eye; `arriving` is the share of the light that reaches it.
    fn add(
        &self,
        table: &ExtinctionTable,
        segment: &Segment,
        step: &Step,
        arriving: f32,
        gathered: &mut Gathered,
    ) {
        let number = step.number;
        if step.depth == 0.0 {
            return;
        }
        let passing = 1.0 - gathered.opacity;
        let alpha = 1.0 - (-step.depth).exp();
        let facing = self.surface(segment.boundary(number + 0.5));
        let ambient = self.shading.ambient as f32;
        let lit = |arriving: f32| passing * alpha * (ambient + (1.0 - ambient) * facing * arriving);
        let (weight, unshadowed) = (lit(arriving), lit(if self.casts_rays() { 1.0 } else { arriving }));
        let packed = table.colour(step.front, step.behind);
        let rgb = [packed & 0x7FF, packed >> 11 & 0x7FF, packed >> 22];
        for (c, most) in [2047.0, 2047.0, 1023.0].into_iter().enumerate() {
            let rgb = rgb[c] as f32 / most;
            gathered.colour[c] += weight * rgb;
            gathered.unshadowed[c] += unshadowed * rgb;
            gathered.direct[c] += passing * alpha * (1.0 - ambient) * facing * arriving * rgb;
        }
        gathered.opacity += passing * alpha;
        gathered.weighted_number += passing * alpha * number;
        if gathered.opacity >= 0.5 && gathered.half_at.is_none() {
            gathered.half_at = Some(number);
        }
    }

    /// How much light comes to `p`.
    fn light_at(
        &self,
        table: &ExtinctionTable,
        p: [f32; 3],
        path: &LightPath,
        count: &mut SampleCount,
    ) -> Light {
        if self.shading.shadows == ShadowMode::Off {
            return Light { near: 0.0, far: 1.0 };
        }
        let (near, q) = self.near_depth(table, p, path, count);
        if near > DEEP || path.way_out(q) < 0.5 * SHADOW_STEP {
            return Light { near, far: 1.0 };
        }
        let far = match self.shadow_grid {
            Some(grid) => grid.sample(q),
            None => self.transmittance(q, path, count),
        };
        Light { near, far }
    }

    /// The optical depth of the near part of the shadow ray from `p`, and the point where that part ends.
    ///
    /// The far part, from there on, is a whole number of shadow steps.
    pub fn near_depth(
        &self,
        table: &ExtinctionTable,
        p: [f32; 3],
        path: &LightPath,
        count: &mut SampleCount,
    ) -> (f32, [f32; 3]) {
        let way = path.way_out(p).max(0.0);
        let length = near_length(way);
        let mut front = self.entry(table, p);
        let (mut near, mut begin) = (0.0, 0.0);
        for end in NEAR_STEPS {
            count.shadow += 1;
            let at = std::array::from_fn(|a| (length * end).mul_add(path.delta[a], p[a]));
            let behind = self.entry(table, at);
            near = (table.mean(front, behind) * length).mul_add(end - begin, near);
            (front, begin) = (behind, end);
        }
        (near, std::array::from_fn(|a| length.mul_add(path.delta[a], p[a])))
    }
}

/// Adds to `colour` what shadows take away from the parts that `waiting` has, by shadow rays at the ends of a few of them.
/// `few` is their number and the noise of the pixel; `light` finds the light at a place along the ray.
fn add_shadows(
    waiting: &[Waiting],
    (per_pixel, offset): (u32, f32),
    mut light: impl FnMut(f32) -> Light,
    colour: &mut [f32; 3],
) {
    let directs: Vec<[f32; 3]> = waiting.iter().map(|part| part.direct).collect();
    for Chosen { place, weight, .. } in choose_places(offset, per_pixel, &directs) {
        let part = &waiting[place];
        let dark = weight * (arriving(part.depth, part.ends.map(&mut light)) - 1.0);
        (0..3).for_each(|c| colour[c] += dark * part.direct[c]);
    }
}

/// The share of the light that arrives at a part of optical `depth`; `light` arrives at its two ends.
fn arriving(depth: f32, [before, after]: [Light; 2]) -> f32 {
    let share = mean_passing(depth + after.near - before.near) / mean_passing(depth);
    far_between(before, after) * (-before.near).exp() * share
}

/// The optical depth of `steps` together.
fn depth_of(steps: &[Step]) -> f32 {
    steps.iter().map(|step| step.depth).sum()
}

/// How many of the `way` steps out of the box are near: one to two shadow steps, so that a whole number of these is
/// left.
fn near_length(way: f32) -> f32 {
    way - SHADOW_STEP * ((way - SHADOW_STEP) * (1.0 / SHADOW_STEP)).floor().max(0.0)
}

/// The far transmittance between two points. A point in the deep does not know its own.
fn far_between(before: Light, after: Light) -> f32 {
    match (before.near > DEEP, after.near > DEEP) {
        (true, _) => after.far,
        (false, true) => before.far,
        (false, false) => 0.5 * (before.far + after.far),
    }
}

/// The mean of e^(−x·s) over s from 0 to 1: (1 − e^(−x))/x.
fn mean_passing(x: f32) -> f32 {
    if x.abs() < 0.05 { 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) } else { (1.0 - (-x).exp()) / x }
}
