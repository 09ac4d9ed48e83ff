use super::cellular_noise::CellularNoise;
use super::domain::{Domain, Site};
use super::gradient_noise::GradientNoise;
use super::grain::Grain;
use super::shapes::{Scanner, bar, blend, ellipsoid, smoothstep, sphere, without};
use super::spine_curve::{Beside, SpineCurve};
use fovol_core::{Result, Volume};
use glam::{Vec2, Vec3};

// Attenuations, 0…65535.
const AIR: f32 = 300.0;
const FLESH: f32 = 15_000.0;
const SKIN: f32 = 24_000.0;
const BONE: f32 = 44_000.0;

/// Corners of the body (x, y, radius) from the nose to the root of the tail.
const BODY: [[f32; 3]; 9] = [
    [-0.92, 0.1, 0.035],
    [-0.82, 0.14, 0.1],
    [-0.67, 0.17, 0.145],
    [-0.5, 0.13, 0.12],
    [-0.34, 0.12, 0.18],
    [-0.06, 0.18, 0.25],
    [0.24, 0.12, 0.17],
    [0.42, 0.06, 0.085],
    [0.6, -0.06, 0.062],
];
const CURL_CENTRE: Vec2 = Vec2::new(0.47, -0.36);

/// Distances from the nose between which there are ribs, and a skull.
const RIBS: [f32; 2] = [0.5, 1.16];
const SKULL_END: f32 = 0.36;
const VERTEBRA: f32 = 0.05;

/// A chameleon-like lizard, seen from its side: a thin skin with scales, ribs, vertebrae, skull and
/// limbs, lungs full of air. Values are attenuations, 0…65535.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let reptile = Reptile {
        scanner: Scanner::new(1.7 * domain.voxel()),
        beside: beside(domain),
        row: domain.grid().dims()[0],
        scales: CellularNoise::new(domain.seed(0)),
        tissue: GradientNoise::new(domain.seed(1)),
        grain: Grain::new(domain.seed(2)),
    };
    let values = domain.sample(|site| {
        let noisy = reptile.attenuation(site) + 350.0 * reptile.grain.at(site.index);
        // `as` saturates.
        noisy.round() as u16
    })?;
    Volume::from_values(domain.grid(), values)
}

/// The body is symmetric about a plane, so where a voxel lies beside the spine does not depend on z.
fn beside(domain: &Domain) -> Vec<Beside> {
    let curve = SpineCurve::new(&BODY, CURL_CENTRE, 2.1);
    let (xs, ys) = (domain.centres(0), domain.centres(1));
    ys.iter().flat_map(|&y| xs.iter().map(move |&x| Vec2::new(x, y))).map(|p| curve.beside(p)).collect()
}

struct Reptile {
    scanner: Scanner,
    beside: Vec<Beside>,
    row: usize,
    scales: CellularNoise,
    tissue: GradientNoise,
    grain: Grain,
}

/// A voxel in the body's own terms.
#[derive(Clone, Copy)]
struct Spot {
    /// The position, mirrored to the left half.
    m: Vec3,
    beside: Beside,
    /// Distance from the spine, with the flattening of the body undone.
    around: f32,
}

impl Reptile {
    fn attenuation(&self, site: Site) -> f32 {
        let [x, y, _] = site.index;
        let beside = self.beside[y * self.row + x];
        let m = site.centre.with_z(site.centre.z.abs());
        let around = Vec2::new(beside.up, m.z / flatness(beside)).length();
        let spot = Spot { m, beside, around };
        let body = body(spot);
        if body > 0.05 {
            return AIR;
        }
        let outside = body - self.bumps(site.centre, body);
        let put = |value, distance, material| self.scanner.put(value, distance, material);
        let mottled = self.tissue.fbm(site.centre * 12.0, 3);
        let value = put(AIR, outside, SKIN * (1.0 + 0.25 * mottled));
        let value = put(value, body + 0.016, FLESH * (0.8 + 0.5 * mottled));
        let value = put(value, lungs(spot), 1_500.0);
        put(value, bones(spot), BONE + 9_000.0 * mottled)
    }

    /// How far scales stand out from the skin, in units of the cube.
    fn bumps(&self, p: Vec3, body: f32) -> f32 {
        // Only the surface has scales; deep inside they would be wasted work.
        if body.abs() > 0.03 {
            return 0.0;
        }
        let large = smoothstep(0.0, 0.45, self.scales.inside(p * 34.0));
        0.011 * (large - 0.6)
    }
}

/// The ratio of a body's width to its height: round at the tail, flat at the trunk.
fn flatness(beside: Beside) -> f32 {
    0.95 - 0.4 * smoothstep(0.08, 0.2, beside.radius)
}

fn body(spot: Spot) -> f32 {
    let Spot { m, beside, around } = spot;
    let trunk = (around - beside.radius) * flatness(beside).max(0.7);
    let casque = bar(m, [Vec3::new(-0.68, 0.26, 0.0), Vec3::new(-0.53, 0.42, 0.0)], [0.06, 0.022]);
    let turret = sphere(m, eye(), 0.062);
    let head = blend(blend(trunk, casque, 0.1), turret, 0.035);
    let mouth = ellipsoid(m, Vec3::new(-0.86, 0.075, 0.0), Vec3::new(0.13, 0.007, 0.2));
    let crest = {
        // Spikes along the back, smaller towards the tail.
        let spike = 0.5 - ((beside.along / 0.05).fract() - 0.5).abs();
        let height = 0.06 * spike * smoothstep(0.02, 0.2, beside.radius);
        Vec2::new((beside.up - beside.radius - height).max(0.0), m.z - 0.006).max(Vec2::ZERO).length()
            + (beside.up - beside.radius - height).max(m.z - 0.006).min(0.0)
    };
    let back =
        if beside.up > 0.0 && beside.along > SKULL_END { head.min(crest.max(-beside.up)) } else { head };
    let limbs = LIMBS.iter().fold(back, |shape, limb| blend(shape, limb.flesh(m), 0.05));
    without(limbs, mouth)
}

fn eye() -> Vec3 {
    Vec3::new(-0.745, 0.2, 0.085)
}

fn lungs(spot: Spot) -> f32 {
    let sac = ellipsoid(spot.m, Vec3::new(-0.16, 0.13, 0.05), Vec3::new(0.24, 0.1, 0.055));
    sac.max(0.03 - spot.m.z * 0.6 - 0.02)
}

fn bones(spot: Spot) -> f32 {
    let limbs = LIMBS.iter().fold(f32::INFINITY, |shape, limb| shape.min(limb.bone(spot.m)));
    let shoulder = bar(spot.m, [Vec3::new(-0.36, 0.2, 0.07), Vec3::new(-0.34, 0.02, 0.1)], [0.02, 0.013]);
    limbs.min(shoulder).min(vertebrae(spot)).min(ribs(spot)).min(skull(spot))
}

/// Beads along the back with a blade on each.
fn vertebrae(Spot { m, beside, .. }: Spot) -> f32 {
    if beside.along < SKULL_END {
        return f32::INFINITY;
    }
    let within = ((beside.along / VERTEBRA).fract() - 0.5).abs() * VERTEBRA;
    let line = 0.42 * beside.radius;
    let thickness = (0.2 * beside.radius).clamp(0.007, 0.032) * (1.15 - 12.0 * within);
    let bead = Vec2::new(beside.up - line, m.z).length() - thickness;
    let blade = (m.z - 0.006).max((beside.up - 0.6 * beside.radius).abs() - 0.24 * beside.radius);
    bead.min(blade.max(within - 0.012))
}

/// Hoops that hang from the spine.
fn ribs(Spot { beside, around, .. }: Spot) -> f32 {
    // They lean backwards on the way down.
    let along = beside.along + 0.25 * (beside.up - 0.42 * beside.radius);
    if !(RIBS[0]..RIBS[1]).contains(&along) {
        return f32::INFINITY;
    }
    let within = ((along / VERTEBRA).fract() - 0.5).abs() * VERTEBRA;
    let hoop = Vec2::new((around - 0.8 * beside.radius) * 0.7, within).length() - 0.0115;
    hoop.max(beside.up - 0.5 * beside.radius).max(-0.7 * beside.radius - beside.up)
}

/// A shell under the skin of the head with holes for the eyes, and the gap of the mouth.
fn skull(Spot { m, beside, around }: Spot) -> f32 {
    if beside.along > SKULL_END + 0.05 {
        return f32::INFINITY;
    }
    let inside = (around - 0.8 * beside.radius) * 0.7;
    let shell = without(inside, inside + 0.022).max(beside.along - SKULL_END);
    let crest = bar(m, [Vec3::new(-0.68, 0.25, 0.0), Vec3::new(-0.54, 0.4, 0.0)], [0.022, 0.01]);
    let socket = sphere(m, eye(), 0.058);
    let gap = ellipsoid(m, Vec3::new(-0.82, 0.07, 0.0), Vec3::new(0.2, 0.016, 0.3));
    without(without(shell, socket), gap).min(crest)
}

/// A leg: hip, knee, heel and the tips of two bundles of toes.
struct Limb {
    joints: [Vec3; 3],
    toes: [Vec3; 2],
}

const LIMBS: [Limb; 2] = [
    Limb {
        joints: [Vec3::new(-0.34, 0.03, 0.1), Vec3::new(-0.24, -0.2, 0.27), Vec3::new(-0.4, -0.45, 0.2)],
        toes: [Vec3::new(-0.52, -0.52, 0.15), Vec3::new(-0.37, -0.57, 0.27)],
    },
    Limb {
        joints: [Vec3::new(0.22, 0.04, 0.08), Vec3::new(0.06, -0.18, 0.27), Vec3::new(0.16, -0.45, 0.2)],
        toes: [Vec3::new(0.05, -0.54, 0.15), Vec3::new(0.19, -0.57, 0.27)],
    },
];

impl Limb {
    fn flesh(&self, p: Vec3) -> f32 {
        let [hip, knee, heel] = self.joints;
        let leg = blend(bar(p, [hip, knee], [0.075, 0.045]), bar(p, [knee, heel], [0.048, 0.032]), 0.03);
        self.toes.iter().fold(leg, |leg, &toe| blend(leg, bar(p, [heel, toe], [0.036, 0.022]), 0.03))
    }

    fn bone(&self, p: Vec3) -> f32 {
        let [hip, knee, heel] = self.joints;
        // Shafts are narrow in the middle, knobs sit at the joints.
        let shaft = bar(p, [hip, knee], [0.019, 0.014]).min(bar(p, [knee, heel], [0.014, 0.011]));
        let knobs = sphere(p, hip, 0.03).min(sphere(p, knee, 0.024)).min(sphere(p, heel, 0.019));
        self.toes
            .iter()
            .fold(blend(shaft, knobs, 0.02), |leg, &toe| leg.min(bar(p, [heel, toe], [0.01, 0.007])))
    }
}
