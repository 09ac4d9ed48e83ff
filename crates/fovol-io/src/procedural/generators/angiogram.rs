use super::domain::Domain;
use super::grain::Grain;
use super::seeded::Draws;
use super::shapes::{Scanner, bar, sphere};
use super::vessels::{Vessel, grow};
use fovol_core::{Result, Volume, stop};
use glam::Vec3;
use rayon::prelude::*;

/// Contrast agent in full.
const BLOOD: f32 = 235.0;
/// Largest value of background tissue: the residue of subtracting the mask image.
const BACKGROUND: f32 = 4.0;

/// Rotational angiography: three arteries branch into vessels down to a voxel's width; on one of them
/// an aneurysm. All else is next to zero. Values are 0…255.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let vessels = grow(3, domain.seed(0));
    let bulge = aneurysm(&vessels, domain.seed(1));
    let [nx, ny, _] = domain.grid().dims();
    let grain = Grain::new(domain.seed(2));
    let painter = Painter {
        domain,
        scanner: Scanner::new(1.7 * domain.voxel()),
        axes: [0, 1, 2].map(|a| domain.centres(a)),
    };
    let mut values: Vec<u8> = domain.zeros()?;
    values.par_chunks_mut(nx * ny).enumerate().for_each(|(z, out)| {
        stop::point();
        let mut blood = vec![0.0; nx * ny];
        painter
            .paint(z, &mut blood, [bulge.0 - bulge.1, bulge.0 + bulge.1], |p| sphere(p, bulge.0, bulge.1.x));
        for Vessel { ends, radii } in &vessels {
            let reach = Vec3::splat(radii[0]);
            let bounds = [ends[0].min(ends[1]) - reach, ends[0].max(ends[1]) + reach];
            painter.paint(z, &mut blood, bounds, |p| bar(p, *ends, *radii));
        }
        for (i, (out, blood)) in out.iter_mut().zip(blood).enumerate() {
            let noise = grain.at([i % nx, i / nx, z]);
            let residue = (0.5 * BACKGROUND + noise).clamp(0.0, BACKGROUND);
            *out = (residue + blood * BLOOD * (1.0 + 0.02 * noise)).round() as u8;
        }
    });
    Volume::from_values(domain.grid(), values)
}

/// A bulge on the side of a wide vessel: its centre and its radius in each direction.
fn aneurysm(vessels: &[Vessel], seed: u64) -> (Vec3, Vec3) {
    let mut draws = Draws::new(seed);
    let wide: Vec<&Vessel> =
        vessels.iter().filter(|v| (0.018..0.026).contains(&v.radii[0]) && v.ends[0].y > -0.6).collect();
    let pick = (draws.unit() * wide.len() as f32) as usize;
    let site = wide.get(pick).copied().unwrap_or(&vessels[0]);
    let along = (site.ends[1] - site.ends[0]).normalize_or(Vec3::Y);
    let side = along.cross(draws.direction()).normalize_or(Vec3::X);
    let radius = draws.between(0.075, 0.1);
    (site.ends[0] + side * (radius * 0.85), Vec3::splat(radius))
}

struct Painter<'a> {
    domain: &'a Domain,
    scanner: Scanner,
    axes: [Vec<f32>; 3],
}

impl Painter<'_> {
    /// Raises the voxels of slice `z` to their share of the shape that lies within `bounds`.
    fn paint(&self, z: usize, slice: &mut [f32], bounds: [Vec3; 2], distance: impl Fn(Vec3) -> f32) {
        let margin = Vec3::splat(2.0 * self.domain.voxel());
        let [low, high] = [bounds[0] - margin, bounds[1] + margin];
        let pz = self.axes[2][z];
        if pz < low.z || pz > high.z {
            return;
        }
        let within = |axis: usize| {
            let centres = &self.axes[axis];
            centres.partition_point(|&c| c < low[axis])..centres.partition_point(|&c| c <= high[axis])
        };
        let nx = self.axes[0].len();
        for y in within(1) {
            for x in within(0) {
                let share = self.scanner.share(distance(Vec3::new(self.axes[0][x], self.axes[1][y], pz)));
                let value = &mut slice[y * nx + x];
                *value = value.max(share);
            }
        }
    }
}
