use super::seeded::Draws;
use glam::Vec3;

/// A stretch of vessel: two ends and their radii, in units of the cube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vessel {
    pub ends: [Vec3; 2],
    pub radii: [f32; 2],
}

/// Vessels thinner than this end.
const THINNEST: f32 = 0.0032;

/// A branch still to grow.
struct Tip {
    at: Vec3,
    heading: Vec3,
    radius: f32,
    /// Distance to the next fork.
    length: f32,
}

/// Grows trees of vessels from `stems` arteries at the floor of the cube.
///
/// Radii at a fork follow Murray's law (1926), r³ = r₁³ + r₂³; branches wander, keep to a ball and
/// leave each other's way by chance alone.
pub(super) fn grow(stems: usize, seed: u64) -> Vec<Vessel> {
    let mut draws = Draws::new(seed);
    let mut tips: Vec<Tip> = (0..stems).map(|stem| root(stem, stems, &mut draws)).collect();
    let mut vessels = Vec::new();
    while let Some(tip) = tips.pop() {
        let end = extend(tip, &mut vessels, &mut draws);
        if end.radius > THINNEST {
            tips.extend(fork(&end, &mut draws));
        }
    }
    vessels
}

fn root(stem: usize, stems: usize, draws: &mut Draws) -> Tip {
    let angle = (stem as f32 + draws.between(0.1, 0.6)) / stems as f32 * std::f32::consts::TAU;
    let at = Vec3::new(0.3 * angle.cos(), -0.97, 0.3 * angle.sin());
    let heading = Vec3::new(-0.15 * at.x, 1.0, -0.15 * at.z).normalize();
    Tip { at, heading, radius: draws.between(0.028, 0.036), length: draws.between(0.35, 0.6) }
}

/// Lets a tip wander for its length in short straight stretches; returns where it ends.
fn extend(mut tip: Tip, vessels: &mut Vec<Vessel>, draws: &mut Draws) -> Tip {
    let step = (tip.radius * 1.5).clamp(0.012, 0.04);
    let wander = draws.between(0.12, 0.3);
    let mut swerve = draws.direction();
    while tip.length > 0.0 {
        swerve = (swerve + 0.5 * draws.direction()).normalize_or(Vec3::Y);
        // Outside the ball, back towards its middle.
        let outward = (tip.at.length() - 0.8).max(0.0) * 2.5;
        let inward = -tip.at.normalize_or_zero() * outward;
        tip.heading = (tip.heading + wander * swerve + inward).normalize_or(Vec3::Y);
        let next = (tip.at + tip.heading * step).clamp(Vec3::splat(-0.98), Vec3::splat(0.98));
        let narrower = tip.radius * 0.997;
        vessels.push(Vessel { ends: [tip.at, next], radii: [tip.radius, narrower] });
        tip = Tip { at: next, radius: narrower, length: tip.length - step, ..tip };
    }
    tip
}

fn fork(tip: &Tip, draws: &mut Draws) -> [Tip; 2] {
    // The share of the flow that the larger branch takes.
    let share = draws.between(0.5, 0.88);
    let side = tip.heading.cross(draws.direction()).normalize_or(Vec3::X);
    let branch = |share: f32, turn: f32, draws: &mut Draws| {
        let radius = tip.radius * share.cbrt();
        let length = (radius * draws.between(9.0, 22.0)).max(0.05);
        let heading = (tip.heading + side * turn).normalize_or(Vec3::Y);
        Tip { at: tip.at, heading, radius, length }
    };
    // The smaller the branch, the farther it turns.
    [branch(share, 0.9 * (1.0 - share), draws), branch(1.0 - share, -1.1 * share, draws)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_stay_in_the_cube_and_thin_out() {
        let vessels = grow(3, 1);
        assert!(vessels.len() > 1000, "{}", vessels.len());
        for vessel in &vessels {
            assert!(vessel.ends.iter().all(|end| end.abs().max_element() <= 0.98));
            assert!(vessel.radii[1] <= vessel.radii[0]);
        }
    }
}
