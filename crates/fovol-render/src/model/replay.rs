use super::ray_steps::{LitSample, RaySteps, ShadowSteps, Step};
use crate::cpu::light_columns::SLABS;
use crate::cpu::march::{DARK, OPAQUE};
use crate::scene::{Bricks, LightPath, Macrocells, SHADOW_STEP, Segment, Segments, TransferTable};
use fovol_core::{Ray, Result, Scene, ShadowMode};

/// A scene whose rays can be followed step by step, as shaders follow them.
///
/// Where columns list the samples of shadow rays, they list exactly those in visible cells. Those of
/// shaders/light_columns.wgsl also list a few beside such cells.
#[derive(Debug)]
pub struct Replay {
    bricks: Bricks,
    cells: Macrocells,
    table: TransferTable,
    segments: Segments,
    light: LightPath,
    has_shadows: bool,
    last: [f32; 3],
    scale: f32,
}

/// Space ahead of a point on a ray.
pub(super) struct Ahead {
    pub is_empty: bool,
    /// Steps for which this holds, at least 1.
    pub steps: f32,
}

impl Replay {
    /// Prepares `scene`.
    ///
    /// # Errors
    /// Numbers of the scene that cannot be rendered with, too little memory.
    pub fn new(scene: &Scene) -> Result<Self> {
        scene.check()?;
        let mut bricks = Bricks::of_volume(&scene.volume)?;
        bricks.set_interpolation(scene.interpolation);
        let mut cells = Macrocells::new(&bricks)?;
        cells.classify(&scene.transfer_function, scene.mode);
        let (grid, clip, step) = (*scene.volume.grid(), scene.clip_box(), scene.marching_step());
        let table = TransferTable::new(&scene.transfer_function, step);
        Ok(Self {
            scale: table.scale(),
            cells,
            table,
            segments: Segments::new(&grid, &clip, step),
            light: LightPath::new(&scene.shading.light, &grid, &clip, step),
            has_shadows: scene.shading.shadows == ShadowMode::On,
            last: grid.dims().map(|side| (side - 1) as f32),
            bricks,
        })
    }

    /// The samples of `ray`.
    pub fn segment(&self, ray: &Ray) -> Segment {
        self.segments.of(ray)
    }

    /// Follows the ray of `segment` and its shadow rays, whose samples are listed beforehand where `columns` are used.
    pub(super) fn follow(&self, segment: &Segment, columns: bool) -> RaySteps {
        let mut ray = RaySteps::default();
        let inverse = inverse_of(segment.delta);
        let (mut opacity, mut number, mut known) = (0.0f32, 0u32, 0u32);
        while number < segment.count && opacity < OPAQUE {
            let p = segment.position(number);
            let looks = number >= known;
            if looks {
                let ahead = self.ahead(p, inverse);
                known = number.saturating_add(ahead.steps as u32);
                if ahead.is_empty {
                    ray.steps.push((Step { looks, samples: false }, None));
                    number = known;
                    continue;
                }
            }
            let alpha = f32::from_bits(self.table.appearance[self.entry(p)][0]);
            let lit = (alpha > 0.0).then(|| {
                opacity += alpha * (1.0 - opacity);
                ray.lit.push(LitSample { number, shadow: self.shadow(p, columns) });
                ray.lit.len() - 1
            });
            ray.steps.push((Step { looks, samples: true }, lit));
            number += 1;
        }
        ray.end = number.min(segment.count);
        ray
    }

    /// Samples of the ray of `segment` that show something, and samples of their shadow rays.
    pub fn visible_samples(&self, segment: &Segment) -> [u64; 2] {
        let ray = self.follow(segment, true);
        [ray.lit.len() as u64, ray.lit.iter().map(|lit| lit.shadow.count()).sum()]
    }

    /// Follows the shadow ray from `p`.
    fn shadow(&self, p: [f32; 3], columns: bool) -> ShadowSteps {
        let mut shadow = ShadowSteps::default();
        if !self.has_shadows {
            return shadow;
        }
        let inverse = self.light.inverse.map(|i| if i.is_finite() { i / SHADOW_STEP } else { 0.0 });
        let count = self.light.count(p);
        if columns {
            // About as many as the samples need: where a ray begins within a word does not matter here.
            shadow.words = u64::from(count.div_ceil(SLABS));
        }
        let (mut transmittance, mut j, mut known) = (1.0f32, 0u32, 0u32);
        while j < count && transmittance >= DARK {
            let at = self.light.position(p, j);
            let looks = j >= known;
            if looks {
                let ahead = self.ahead(at, inverse);
                known = j.saturating_add(ahead.steps as u32);
                if ahead.is_empty {
                    if !columns {
                        shadow.steps.push(Step { looks, samples: false });
                    }
                    j = known;
                    continue;
                }
            }
            transmittance *= 1.0 - self.table.shadow_alpha[self.entry(at)];
            shadow.steps.push(Step { looks: looks && !columns, samples: true });
            j += 1;
        }
        shadow
    }

    /// Looks ahead of `p` along a ray with steps of 1/`inverse` voxels; as shaders/skip.wgsl.
    pub(super) fn ahead(&self, p: [f32; 3], inverse: [f32; 3]) -> Ahead {
        let cells = self.cells.cells();
        let cell: [usize; 3] =
            std::array::from_fn(|a| (p[a].clamp(0.0, self.last[a]) as usize) >> self.cells.shift());
        let distance = self.cells.distances()[(cell[2] * cells[1] + cell[1]) * cells[0] + cell[0]];
        let reach = f32::from(distance.max(1));
        let edge = (1u32 << self.cells.shift()) as f32;
        let mut steps = f32::INFINITY;
        for a in (0..3).filter(|a| inverse[*a] != 0.0) {
            let low = cell[a] as f32;
            let face = if inverse[a] > 0.0 { low + reach } else { low - reach + 1.0 } * edge;
            steps = steps.min((face - p[a]) * inverse[a]);
        }
        Ahead { is_empty: distance > 0, steps: steps.ceil().clamp(1.0, 1e9) }
    }

    fn entry(&self, p: [f32; 3]) -> usize {
        (self.bricks.sample(p) * self.scale + 0.5) as usize
    }
}

/// 1/`delta`, 0 where a ray does not move.
pub fn inverse_of(delta: [f32; 3]) -> [f32; 3] {
    delta.map(|d| if d.abs() < 1e-12 { 0.0 } else { 1.0 / d })
}
