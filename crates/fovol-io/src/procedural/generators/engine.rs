use super::domain::Domain;
use super::gradient_noise::GradientNoise;
use super::grain::Grain;
use super::shapes::{Scanner, bar, blend, cuboid, cylinder, mirrored, torus, without};
use fovol_core::{Result, Volume};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

const AIR: f32 = 6.0;
const RUBBER: f32 = 48.0;
const ALUMINIUM: f32 = 118.0;
const STEEL: f32 = 205.0;

/// Where the two cylinders stand, left and right.
const BORE_X: f32 = 0.36;

/// A two-cylinder engine in an industrial scanner: a cast block with cooling fins and channels, steel
/// liners, pistons, crankshaft, bolts and a gasket. Values are attenuations, 0…255.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let engine = Engine {
        scanner: Scanner::new(1.6 * domain.voxel()),
        casting: GradientNoise::new(domain.seed(0)),
        grain: Grain::new(domain.seed(1)),
        // Pistons run half a turn apart; the seed says where they stand.
        turn: (domain.seed(2) % 360) as f32 / 360.0 * TAU,
    };
    let values = domain.sample(|site| {
        let noise = 3.0 * engine.grain.at(site.index) + ring_artefact(site.centre);
        (engine.attenuation(site.centre) + noise).round() as u8
    })?;
    Volume::from_values(domain.grid(), values)
}

/// Faint rings around the axis of rotation, from detector columns that differ.
fn ring_artefact(p: Vec3) -> f32 {
    let r = Vec2::new(p.x, p.z).length();
    1.5 * (r * 90.0).sin() * (r * 37.0).cos()
}

struct Engine {
    scanner: Scanner,
    casting: GradientNoise,
    grain: Grain,
    turn: f32,
}

impl Engine {
    fn attenuation(&self, p: Vec3) -> f32 {
        if p.x.abs().max(p.y.abs()).max(p.z.abs()) > 0.97 {
            return AIR;
        }
        let put = |value, distance, material| self.scanner.put(value, distance, material);
        // Cast metal is not the same everywhere, and has pores.
        let cast = ALUMINIUM + 7.0 * self.casting.fbm(p * 9.0, 2);
        let mut value = put(AIR, block(p), cast);
        value = put(value, gasket(p), RUBBER);
        value = put(value, liners(p), STEEL - 15.0);
        for (side, phase) in [(-1.0, 0.0), (1.0, 0.5 * TAU)] {
            value = self.piston(value, p, side * BORE_X, self.turn + phase);
        }
        value = put(value, crankshaft(p, self.turn), STEEL);
        value = put(value, bolts(p), STEEL + 10.0);
        put(value, ports(p), ALUMINIUM + 25.0)
    }

    /// Piston, pin and connecting rod of the cylinder at `x`, the crank at `angle`.
    fn piston(&self, value: f32, p: Vec3, x: f32, angle: f32) -> f32 {
        let crank = Vec3::new(x, -0.5 + 0.13 * angle.cos(), 0.13 * angle.sin());
        let crown = Vec3::new(x, 0.22 + 0.13 * angle.cos(), 0.0);
        let skirt = cylinder(p, crown, 1, 0.2, 0.13);
        let hollow = cylinder(p, crown - Vec3::Y * 0.08, 1, 0.165, 0.12);
        let mut groove = f32::INFINITY;
        for k in 0..3 {
            groove = groove.min(torus(p, crown + Vec3::Y * (0.09 - 0.045 * k as f32), 1, 0.2, 0.011));
        }
        let pin = cylinder(p, crown - Vec3::Y * 0.03, 0, 0.045, 0.17);
        let rod = bar(p, [crown - Vec3::Y * 0.03, crank], [0.04, 0.055]);
        let value = self.scanner.put(value, without(skirt, hollow), ALUMINIUM + 15.0);
        let value = self.scanner.put(value, groove, STEEL);
        let value = self.scanner.put(value, rod, STEEL - 25.0);
        self.scanner.put(value, pin, STEEL)
    }
}

/// The casting: head, cylinders with cooling fins, crankcase and feet, without all its cavities.
fn block(p: Vec3) -> f32 {
    let m = mirrored(p);
    let cylinders = cuboid(p, Vec3::new(0.0, 0.22, 0.0), Vec3::new(0.7, 0.4, 0.36), 0.08);
    let case = cuboid(p, Vec3::new(0.0, -0.45, 0.0), Vec3::new(0.78, 0.3, 0.44), 0.12);
    let head = cuboid(p, Vec3::new(0.0, 0.74, 0.0), Vec3::new(0.78, 0.11, 0.46), 0.03);
    let feet = cuboid(m, Vec3::new(0.68, -0.82, 0.0), Vec3::new(0.16, 0.06, 0.5), 0.02);
    let body = blend(blend(cylinders, case, 0.08), feet, 0.06).min(head).min(fins(p));

    let bore = cylinder(m, Vec3::new(BORE_X, 0.2, 0.0), 1, 0.24, 0.6);
    let chamber = cuboid(p, Vec3::new(0.0, -0.47, 0.0), Vec3::new(0.7, 0.24, 0.36), 0.1);
    let body = without(without(body, bore), chamber);
    let channel = cylinder(m, Vec3::new(BORE_X, 0.3, 0.0), 1, 0.31, 0.2).max(-cylinder(
        m,
        Vec3::new(BORE_X, 0.3, 0.0),
        1,
        0.275,
        0.5,
    ));
    let foot_holes = cylinder(m.with_z(p.z.abs()), Vec3::new(0.74, -0.82, 0.36), 1, 0.05, 0.2);
    let oil = cylinder(p, Vec3::new(0.0, -0.05, 0.28), 0, 0.03, 0.9);
    let window = cylinder(p, Vec3::new(0.0, -0.45, 0.44), 2, 0.17, 0.2);
    without(without(without(without(body, channel), foot_holes), oil), window)
}

/// Thin plates around the upper block.
fn fins(p: Vec3) -> f32 {
    let pitch = 0.085;
    let nearest = ((p.y - 0.1) / pitch).round().clamp(0.0, 5.0) * pitch + 0.1;
    cuboid(p, Vec3::new(0.0, nearest, 0.0), Vec3::new(0.84, 0.016, 0.5), 0.01)
}

fn gasket(p: Vec3) -> f32 {
    let sheet = cuboid(p, Vec3::new(0.0, 0.626, 0.0), Vec3::new(0.78, 0.014, 0.46), 0.004);
    without(sheet, cylinder(mirrored(p), Vec3::new(BORE_X, 0.62, 0.0), 1, 0.24, 0.1))
}

fn liners(p: Vec3) -> f32 {
    let centre = Vec3::new(BORE_X, 0.22, 0.0);
    let m = mirrored(p);
    without(cylinder(m, centre, 1, 0.24, 0.4), cylinder(m, centre, 1, 0.21, 1.0))
}

fn crankshaft(p: Vec3, turn: f32) -> f32 {
    let mut shape = cylinder(p, Vec3::new(0.0, -0.5, 0.0), 0, 0.055, 0.92);
    for (side, phase) in [(-1.0, 0.0), (1.0, 0.5 * TAU)] {
        let (sin, cos) = (turn + phase).sin_cos();
        let throw = Vec3::new(side * BORE_X, -0.5 + 0.13 * cos, 0.13 * sin);
        shape = shape.min(cylinder(p, throw, 0, 0.06, 0.12));
        for web in [-0.13, 0.13] {
            let centre = Vec3::new(throw.x + web, -0.5 - 0.05 * cos, -0.05 * sin);
            shape = shape.min(cylinder(p, centre, 0, 0.19, 0.028));
        }
    }
    // A pulley outside, with a groove for the belt.
    let hub = Vec3::new(0.88, -0.5, 0.0);
    shape.min(without(cylinder(p, hub, 0, 0.3, 0.045), torus(p, hub, 0, 0.31, 0.04)))
}

/// Six head bolts with hexagonal heads, and two spark plugs.
fn bolts(p: Vec3) -> f32 {
    let mut q = p.abs();
    q.y = p.y;
    // Those in the middle row stand between the cylinders.
    let at = Vec2::new(if q.x > 0.35 { 0.7 } else { 0.0 }, 0.37);
    let shank = cylinder(q, Vec3::new(at.x, 0.6, at.y), 1, 0.035, 0.3);
    let head = hexagon(Vec2::new(q.x - at.x, q.z - at.y), 0.062).max((p.y - 0.885).abs() - 0.04);
    let plug_at = Vec3::new(BORE_X, 0.8, 0.0);
    let plug = cylinder(mirrored(p), plug_at, 1, 0.04, 0.15);
    shank.min(head).min(plug)
}

/// A hexagon in the plane, `apothem` from its middle to its sides.
fn hexagon(p: Vec2, apothem: f32) -> f32 {
    let q = p.abs();
    q.y.max(q.x * 0.866_025_4 + q.y * 0.5) - apothem
}

/// Pipes for intake (behind) and exhaust (in front) of each cylinder.
fn ports(p: Vec3) -> f32 {
    let m = mirrored(p);
    let pipe = |z: f32| {
        let ends = [Vec3::new(BORE_X, 0.72, 0.3 * z), Vec3::new(BORE_X, 0.62, 0.95 * z)];
        without(bar(m, ends, [0.12, 0.13]), bar(m, ends, [0.085, 0.1])).max(z * p.z - 0.9)
    };
    pipe(-1.0).min(pipe(1.0)).max(0.44 - p.z.abs())
}
