use super::domain::Domain;
use super::gradient_noise::GradientNoise;
use super::grain::Grain;
use super::shapes::{
    Scanner, bar, blend, cuboid, cylinder, ellipsoid, mirrored, smoothstep, sphere, torus, without,
};
use fovol_core::{Result, Volume};
use glam::{Vec2, Vec3};

// Hounsfield units.
const AIR: f32 = -1000.0;
const FAT: f32 = -90.0;
const SKIN: f32 = 20.0;
const MUSCLE: f32 = 55.0;
const BRAIN: f32 = 36.0;
const FLUID: f32 = 6.0;
const MARROW: f32 = 350.0;
const BONE: f32 = 1150.0;
const ENAMEL: f32 = 2500.0;

/// The middle of the cranium and the radii of the skin over it.
const CRANIUM: Vec3 = Vec3::new(0.0, 0.25, -0.08);
const SCALP: Vec3 = Vec3::new(0.6, 0.66, 0.74);

/// A head in computed tomography, face towards +z, in Hounsfield units.
pub(super) fn make(domain: &Domain) -> Result<Volume> {
    let head = Head {
        scanner: Scanner::new(1.8 * domain.voxel()),
        tissue: GradientNoise::new(domain.seed(0)),
        folds: GradientNoise::new(domain.seed(1)),
    };
    let grain = Grain::new(domain.seed(2));
    let values = domain.sample(|site| {
        let noisy = head.density(site.centre) + 14.0 * grain.at(site.index);
        noisy.round().clamp(-1024.0, 3071.0) as i16
    })?;
    Volume::from_values(domain.grid(), values)
}

struct Head {
    scanner: Scanner,
    tissue: GradientNoise,
    folds: GradientNoise,
}

impl Head {
    fn density(&self, p: Vec3) -> f32 {
        let m = mirrored(p);
        let skin = skin(p, m);
        if skin > 0.05 {
            return AIR;
        }
        let put = |value, distance, material| self.scanner.put(value, distance, material);
        let mottled = self.tissue.fbm(p * 9.0, 3);
        let mut value = put(AIR, skin, SKIN);
        value = put(value, skin + 0.022, FAT + 40.0 * mottled);
        value = put(value, skin + 0.05 + 0.03 * mottled, MUSCLE + 15.0 * mottled);
        value = self.eyes(value, m);
        value = self.airways(value, p, m);
        value = self.skull(value, p, m, mottled);
        value = self.brain(value, p, m);
        value = put(value, spine(p), BONE - 300.0 + 300.0 * mottled);
        self.jaws(value, p, m)
    }

    fn eyes(&self, value: f32, m: Vec3) -> f32 {
        let centre = Vec3::new(0.2, 0.03, 0.53);
        let value = self.scanner.put(value, sphere(m, centre, 0.1), FLUID + 10.0);
        let lens = ellipsoid(m, centre + Vec3::Z * 0.075, Vec3::new(0.04, 0.04, 0.018));
        let nerve = bar(m, [centre - Vec3::Z * 0.1, Vec3::new(0.05, 0.02, 0.2)], [0.02, 0.02]);
        let value = self.scanner.put(value, nerve, BRAIN);
        self.scanner.put(value, lens, 110.0)
    }

    /// Nose, mouth, throat and windpipe.
    fn airways(&self, value: f32, p: Vec3, m: Vec3) -> f32 {
        let passage = ellipsoid(m, Vec3::new(0.055, -0.16, 0.4), Vec3::new(0.035, 0.13, 0.33));
        let nostril = bar(m, [Vec3::new(0.05, -0.26, 0.76), Vec3::new(0.05, -0.2, 0.55)], [0.024, 0.03]);
        let throat = bar(p, [Vec3::new(0.0, -0.2, 0.12), Vec3::new(0.0, -0.5, 0.02)], [0.07, 0.06]);
        let windpipe = bar(p, [Vec3::new(0.0, -0.5, 0.02), Vec3::new(0.0, -1.2, 0.02)], [0.06, 0.07]);
        let mouth = ellipsoid(p, Vec3::new(0.0, -0.37, 0.34), Vec3::new(0.15, 0.022, 0.2));
        let air = passage.min(nostril).min(throat).min(windpipe).min(mouth);
        let cartilage = windpipe.abs() - 0.012;
        let value = self.scanner.put(value, cartilage.max(p.y + 0.62), 140.0);
        self.scanner.put(value, air, AIR)
    }

    fn skull(&self, value: f32, p: Vec3, m: Vec3, mottled: f32) -> f32 {
        let bone = skull_bone(p, m);
        // Spongy marrow lies between two hard plates where the bone is thick.
        let value = self.scanner.put(value, bone, BONE + 150.0 * mottled);
        let spongy = self.tissue.ridged(p * 22.0, 2);
        let value = self.scanner.put(value, bone + 0.024, MARROW + 500.0 * spongy);
        self.scanner.put(value, sinuses(p, m), AIR)
    }

    fn brain(&self, value: f32, p: Vec3, m: Vec3) -> f32 {
        let cavity = brain_cavity(p);
        if cavity > 0.05 {
            return value;
        }
        let value = self.scanner.put(value, cavity, FLUID);
        // Sulci: thin clefts, wound by noise, that fade with depth; the falx parts the hemispheres.
        let wound = p + self.folds.vector(p * 2.5, 2) * 0.16;
        let cleft = self.folds.ridged(wound * 5.5, 1);
        let depth = smoothstep(0.0, -0.16, cavity);
        let grey = cavity + 0.018 + 0.09 * smoothstep(0.8, 1.0, cleft) * (1.0 - depth);
        let parted = without(grey, m.x - 0.012 + 0.03 * depth);
        let white = 4.0 * smoothstep(-0.05, -0.1, cavity + 0.03 * cleft);
        let value = self.scanner.put(value, parted.max(-0.2 - p.y), BRAIN + 4.0 - white);
        let horn = |a: Vec3, b: Vec3| bar(m, [a, b], [0.045, 0.03]);
        let ventricle = horn(Vec3::new(0.06, 0.26, 0.16), Vec3::new(0.12, 0.3, -0.2))
            .min(horn(Vec3::new(0.12, 0.3, -0.2), Vec3::new(0.17, 0.16, -0.38)))
            .min(horn(Vec3::new(0.12, 0.3, -0.2), Vec3::new(0.26, 0.08, -0.02)));
        self.scanner.put(value, ventricle, FLUID)
    }

    /// Lower jaw and both rows of teeth.
    fn jaws(&self, value: f32, p: Vec3, m: Vec3) -> f32 {
        let joints = [
            Vec3::new(0.38, -0.08, 0.06),
            Vec3::new(0.34, -0.44, 0.1),
            Vec3::new(0.23, -0.59, 0.38),
            Vec3::new(0.0, -0.63, 0.52),
        ];
        let radii = [0.035, 0.05, 0.058, 0.065];
        let jaw = (0..3).fold(f32::INFINITY, |shape, i| {
            let part = bar(m, [joints[i], joints[i + 1]], [radii[i], radii[i + 1]]);
            if i == 0 { part } else { blend(shape, part, 0.05) }
        });
        let value = self.scanner.put(value, jaw, BONE + 200.0);
        let value = self.scanner.put(value, jaw + 0.03, MARROW);
        let teeth = row_of_teeth(p, -0.375, 1.0).min(row_of_teeth(p, -0.46, -1.0));
        let value = self.scanner.put(value, teeth, ENAMEL);
        self.scanner.put(value, teeth + 0.018, 1700.0)
    }
}

fn skin(p: Vec3, m: Vec3) -> f32 {
    let cranium = ellipsoid(p, CRANIUM, SCALP);
    let face = ellipsoid(p, Vec3::new(0.0, -0.2, 0.24), Vec3::new(0.42, 0.5, 0.43));
    let chin = ellipsoid(p, Vec3::new(0.0, -0.57, 0.4), Vec3::new(0.24, 0.18, 0.23));
    let cheek = bar(m, [Vec3::new(0.36, -0.1, 0.12), Vec3::new(0.28, -0.48, 0.16)], [0.13, 0.12]);
    let neck = bar(p, [Vec3::new(0.0, -0.3, -0.18), Vec3::new(0.0, -1.4, -0.22)], [0.36, 0.38]);
    let face = blend(blend(face, cheek, 0.12), chin, 0.16);
    let shape = blend(blend(cranium, face, 0.15), neck, 0.2);
    let bridge = bar(p, [Vec3::new(0.0, 0.06, 0.62), Vec3::new(0.0, -0.2, 0.76)], [0.05, 0.065]);
    let wing = sphere(m, Vec3::new(0.06, -0.21, 0.7), 0.06);
    let lips = ellipsoid(m, Vec3::new(0.0, -0.37, 0.64), Vec3::new(0.15, 0.055, 0.06));
    let brow = bar(m, [Vec3::new(0.05, 0.15, 0.62), Vec3::new(0.28, 0.14, 0.53)], [0.05, 0.04]);
    let shape = blend(blend(shape, blend(bridge, wing, 0.06), 0.07), lips, 0.05);
    let shape = blend(shape, brow, 0.08);
    let socket = ellipsoid(m, Vec3::new(0.2, 0.03, 0.72), Vec3::new(0.13, 0.08, 0.1));
    let shape = -blend(-shape, socket, 0.08);
    let lid = sphere(m, Vec3::new(0.2, 0.03, 0.53), 0.115);
    let parted_lips = ellipsoid(p, Vec3::new(0.0, -0.375, 0.72), Vec3::new(0.13, 0.008, 0.06));
    without(blend(shape, lid, 0.03), parted_lips).min(ear(m))
}

fn ear(m: Vec3) -> f32 {
    let shell = ellipsoid(m, Vec3::new(0.61, -0.02, -0.12), Vec3::new(0.05, 0.2, 0.12));
    without(shell, ellipsoid(m, Vec3::new(0.67, -0.01, -0.1), Vec3::new(0.045, 0.14, 0.075)))
}

/// The inside of the cranium, closed below by the base of the skull.
fn brain_cavity(p: Vec3) -> f32 {
    let vault = ellipsoid(p, CRANIUM, SCALP - 0.125);
    vault.max(-0.12 - p.y + 0.25 * p.z)
}

fn skull_bone(p: Vec3, m: Vec3) -> f32 {
    let vault = ellipsoid(p, CRANIUM, SCALP - 0.06).max(-0.2 - p.y + 0.25 * p.z);
    let face = cuboid(p, Vec3::new(0.0, -0.12, 0.36), Vec3::new(0.3, 0.26, 0.22), 0.14);
    let cheek = sphere(m, Vec3::new(0.31, -0.12, 0.46), 0.075);
    let arch = bar(m, [Vec3::new(0.34, -0.12, 0.44), Vec3::new(0.47, -0.1, 0.02)], [0.04, 0.028]);
    let mastoid = bar(m, [Vec3::new(0.4, -0.1, -0.1), Vec3::new(0.37, -0.3, -0.08)], [0.1, 0.05]);
    let ridge = bar(m, [Vec3::new(0.06, 0.13, 0.58), Vec3::new(0.32, 0.11, 0.46)], [0.04, 0.04]);
    let solid = blend(blend(vault, face, 0.06), cheek, 0.08);
    let solid = blend(blend(solid, arch, 0.05).min(ridge), mastoid, 0.05);

    let orbit = bar(m, [Vec3::new(0.2, 0.02, 0.7), Vec3::new(0.1, 0.01, 0.25)], [0.16, 0.03]);
    let nose = ellipsoid(p, Vec3::new(0.0, -0.16, 0.6), Vec3::new(0.085, 0.14, 0.3));
    let palate = ellipsoid(p, Vec3::new(0.0, -0.42, 0.26), Vec3::new(0.2, 0.13, 0.27));
    let spinal = cylinder(p, Vec3::new(0.0, -0.25, -0.16), 1, 0.1, 0.2);
    let back = cuboid(p, Vec3::new(0.0, -0.35, 0.05), Vec3::new(0.26, 0.2, 0.16), 0.08);
    let hollow = brain_cavity(p).min(orbit).min(nose).min(palate).min(spinal).min(back);
    without(solid, hollow)
}

fn sinuses(p: Vec3, m: Vec3) -> f32 {
    let cheek = ellipsoid(m, Vec3::new(0.2, -0.2, 0.42), Vec3::new(0.085, 0.1, 0.11));
    let brow = ellipsoid(m, Vec3::new(0.08, 0.19, 0.553), Vec3::new(0.06, 0.05, 0.016));
    let behind_nose = ellipsoid(m, Vec3::new(0.05, -0.04, 0.2), Vec3::new(0.045, 0.05, 0.06));
    let canal = bar(m, [Vec3::new(0.6, -0.04, -0.1), Vec3::new(0.4, -0.06, -0.1)], [0.022, 0.02]);
    // Air cells of the mastoid: many small ones.
    let cell = Vec3::new((m.x * 28.0).sin(), (p.y * 31.0).sin(), (p.z * 29.0).sin());
    let cells = sphere(m, Vec3::new(0.39, -0.16, -0.09), 0.065).max(0.25 * (0.4 - cell.x * cell.y * cell.z));
    cheek.min(brow).min(behind_nose).min(canal).min(cells)
}

/// Seven vertebrae with canal and spinous process.
fn spine(p: Vec3) -> f32 {
    let pitch = 0.125;
    let step = ((-0.33 - p.y) / pitch).round().clamp(0.0, 6.0);
    let centre = Vec3::new(0.0, -0.33 - step * pitch, -0.1 - 0.012 * step);
    let body = cylinder(p, centre, 1, 0.1, 0.045);
    let arch = torus(p, centre - Vec3::Z * 0.13, 1, 0.07, 0.028);
    let process = bar(p, [centre - Vec3::Z * 0.19, centre + Vec3::new(0.0, -0.05, -0.33)], [0.03, 0.02]);
    let wing = bar(mirrored(p), [centre, centre + Vec3::new(0.19, -0.01, -0.08)], [0.035, 0.025]);
    blend(blend(body, arch, 0.03), process.min(wing), 0.03)
}

/// Teeth along a parabola at the height `y`; `up` is 1 for roots that point up and −1 for down.
fn row_of_teeth(p: Vec3, y: f32, up: f32) -> f32 {
    const PITCH: f32 = 0.056;
    let arch = |x: f32| Vec2::new(x, 0.57 - 6.2 * x * x);
    // Position along the arch by its chord from the middle, wide teeth or not.
    let along = (p.x / PITCH - 0.5).round() + 0.5;
    let mut nearest = f32::INFINITY;
    for step in [-1.0, 0.0, 1.0] {
        let x = ((along + step) * PITCH).clamp(-4.5 * PITCH, 4.5 * PITCH);
        let foot = arch(x * 0.92);
        let size = 0.019 + 0.006 * (x.abs() / (4.5 * PITCH));
        let crown = Vec3::new(foot.x, y, foot.y);
        let root = crown + Vec3::Y * 0.085 * up;
        let tooth = bar(p, [crown - Vec3::Y * 0.012 * up, root], [size, 0.35 * size]);
        nearest = nearest.min(tooth);
    }
    // Molars stand straight behind one another.
    for k in 0..5 {
        let crown = Vec3::new(0.245 + 0.006 * k as f32, y, 0.17 - 0.062 * (k as f32 - 2.0));
        let m = mirrored(p);
        nearest = nearest.min(bar(m, [crown, crown + Vec3::Y * 0.08 * up], [0.029, 0.012]));
    }
    nearest
}
