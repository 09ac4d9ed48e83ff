use super::domain::Domain;
use super::gradient_noise::GradientNoise;
use super::shapes::smoothstep;
use fovol_core::{Result, Volume};
use glam::Vec3;

/// An exploded star some hours later: a blast wave that is dented by convection, behind it fingers of
/// heavy matter that sank outwards through light (Rayleigh–Taylor), inside them a hot bubble.
/// Values are entropy-like, 0…1.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let star = Supernova {
        dents: GradientNoise::new(domain.seed(0)),
        fingers: GradientNoise::new(domain.seed(1)),
        eddies: GradientNoise::new(domain.seed(2)),
    };
    Volume::from_values(domain.grid(), domain.sample(|site| star.entropy(site.centre))?)
}

struct Supernova {
    dents: GradientNoise,
    fingers: GradientNoise,
    eddies: GradientNoise,
}

impl Supernova {
    fn entropy(&self, p: Vec3) -> f32 {
        let r = p.length();
        let shock = 0.86 * (1.0 + 0.12 * self.dents.fbm(p / r.max(1e-3) * 1.7, 2));
        if r > shock {
            return 0.0;
        }
        // Eddies curl the tips of the fingers over into mushrooms.
        let curled = p + self.eddies.vector(p * 5.0, 2) * 0.09 * smoothstep(0.2, 0.6, r);
        let rc = curled.length().max(1e-3);
        let direction = curled / rc;
        let roots = shock * 0.5;
        let behind = smoothstep(shock, shock - 0.015, r);
        // Fingers follow rays: the noise varies with direction, and little with distance.
        let finger = self.fingers.fbm(direction * 7.0 + Vec3::splat(rc * 1.3), 4);
        let tip = roots + (shock - roots) * (0.42 + 0.85 * finger);
        let heavy = smoothstep(tip + 0.02, tip - 0.05, rc);
        let rim = (-((rc - tip) / 0.035).powi(2)).exp();
        let wave = (-((r - shock + 0.02) / 0.018).powi(2)).exp();
        let core = (-(r / 0.22).powi(2)).exp();
        let grainy = 0.06 * self.eddies.fbm(p * 14.0, 2);
        let inside = 0.18 + 0.34 * heavy + 0.32 * rim + 0.3 * core + grainy * (0.4 + heavy);
        (behind * inside + 0.14 * wave * behind).clamp(0.0, 1.0)
    }
}
