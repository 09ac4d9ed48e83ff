use super::domain::Domain;
use super::gradient_noise::GradientNoise;
use super::shapes::smoothstep;
use fovol_core::{Result, Volume};
use glam::Vec3;

/// Smoke that rises from a small source, billows, widens and thins out. Values are densities, 0…1,
/// and 0 in most of the cube.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let plume =
        Plume { sway: GradientNoise::new(domain.seed(0)), billows: GradientNoise::new(domain.seed(1)) };
    Volume::from_values(domain.grid(), domain.sample(|site| plume.density(site.centre))?)
}

struct Plume {
    sway: GradientNoise,
    billows: GradientNoise,
}

impl Plume {
    fn density(&self, p: Vec3) -> f32 {
        let height = 0.5 * (p.y + 1.0);
        let radius = 0.07 + 0.56 * height.powf(0.95);
        // Nothing is carried farther out than this, so most voxels need no noise.
        if p.with_y(0.0).length() > 1.5 * radius + 0.2 * height {
            return 0.0;
        }
        let bend = self.sway.vector(Vec3::new(0.0, p.y * 1.1, 0.0), 2).with_y(0.0) * 0.45 * height;
        let q = p - bend;
        let scale = 2.6 / (0.35 + height);
        let rising = q - Vec3::Y * 0.4 * height;
        let warp = self.sway.vector(rising * scale * 0.8, 3) * 0.75;
        let billow = self.billows.fbm(rising * scale + warp * 2.0, 5);
        let across = q.with_y(0.0).length() / radius;
        let body = 0.7 - across + 1.5 * billow;
        let thinning = smoothstep(0.0, 0.04, height) * (1.0 - 0.55 * height) * smoothstep(1.0, 0.82, height);
        (smoothstep(0.0, 0.85, body) * thinning).clamp(0.0, 1.0)
    }
}
