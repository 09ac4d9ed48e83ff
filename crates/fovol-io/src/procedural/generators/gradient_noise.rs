use super::seeded::lattice;
use glam::Vec3;

/// Gradient noise after Perlin, "Improving noise" (2002), with a hash in place of the permutation
/// table, so that it never repeats.
#[derive(Clone, Copy)]
pub(super) struct GradientNoise {
    seed: u32,
}

/// Each octave is turned and shifted against the last, so that their lattices do not line up.
const OCTAVE_SHIFT: Vec3 = Vec3::new(17.13, -9.71, 5.37);
const LACUNARITY: f32 = 2.03;
const GAIN: f32 = 0.5;

impl GradientNoise {
    pub fn new(seed: u64) -> Self {
        Self { seed: (seed ^ (seed >> 32)) as u32 }
    }

    /// The noise at `p`, about −1…1, 0 at lattice points; features of size 1.
    pub fn at(self, p: Vec3) -> f32 {
        let floor = p.floor();
        let cell = floor.as_ivec3();
        let f = p - floor;
        let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
        let corner = |x: i32, y: i32, z: i32| {
            let hash = lattice(self.seed, [cell.x + x, cell.y + y, cell.z + z]);
            gradient(hash, f - Vec3::new(x as f32, y as f32, z as f32))
        };
        let edge = |y: i32, z: i32| mix(corner(0, y, z), corner(1, y, z), fade.x);
        let face = |z: i32| mix(edge(0, z), edge(1, z), fade.y);
        mix(face(0), face(1), fade.z)
    }

    /// Fractal Brownian motion: `octaves` of noise, each half as strong and half as large as the last;
    /// about −1…1.
    pub fn fbm(self, p: Vec3, octaves: u32) -> f32 {
        self.octaves(p, octaves, |n| n)
    }

    /// Ridged noise, 0…1: sharp crests where fractal noise would cross zero.
    pub fn ridged(self, p: Vec3, octaves: u32) -> f32 {
        self.octaves(p, octaves, |n| {
            let crest = 1.0 - n.abs().min(1.0);
            crest * crest
        })
    }

    /// Three independent noises as a vector.
    pub fn vector(self, p: Vec3, octaves: u32) -> Vec3 {
        let axis = |k: u32| Self { seed: self.seed.wrapping_add(k.wrapping_mul(0x9e37_79b9)) };
        Vec3::new(axis(1).fbm(p, octaves), axis(2).fbm(p, octaves), axis(3).fbm(p, octaves))
    }

    /// The weighted mean of `shape(noise)` over octaves.
    #[inline]
    fn octaves(self, p: Vec3, octaves: u32, shape: impl Fn(f32) -> f32) -> f32 {
        let (mut q, mut weight, mut sum, mut total) = (p, 1.0, 0.0, 0.0);
        for _ in 0..octaves {
            sum += weight * shape(self.at(q));
            total += weight;
            weight *= GAIN;
            q = turned(q) * LACUNARITY + OCTAVE_SHIFT;
        }
        sum / total
    }
}

/// A fixed rotation (the 3-4-5 triangle, about two axes).
fn turned(p: Vec3) -> Vec3 {
    let q = Vec3::new(0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y, p.z);
    Vec3::new(q.x, 0.8 * q.y - 0.6 * q.z, 0.6 * q.y + 0.8 * q.z)
}

/// The dot product with one of the 12 directions to the edges of a cube.
#[inline]
fn gradient(hash: u32, d: Vec3) -> f32 {
    let h = hash & 15;
    let u = if h < 8 { d.x } else { d.y };
    let v = if h < 4 {
        d.y
    } else if h == 12 || h == 14 {
        d.x
    } else {
        d.z
    };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_zero_on_the_lattice_bounded_and_continuous() {
        let noise = GradientNoise::new(7);
        let mut largest = 0.0f32;
        for i in 0..20_000 {
            let p = Vec3::new(i as f32 * 0.173, i as f32 * -0.071, i as f32 * 0.037);
            largest = largest.max(noise.at(p).abs());
            let step = (noise.at(p) - noise.at(p + Vec3::splat(1e-3))).abs();
            assert!(step < 0.02, "jump of {step} at {p}");
            assert_eq!(noise.at(p.floor()), 0.0);
        }
        assert!((0.7..=1.1).contains(&largest), "{largest}");
    }

    #[test]
    fn seeds_and_axes_are_independent() {
        let p = Vec3::new(0.3, 0.4, 0.6);
        assert_ne!(GradientNoise::new(1).at(p), GradientNoise::new(2).at(p));
        let v = GradientNoise::new(1).vector(p, 2);
        assert!(v.x != v.y && v.y != v.z);
    }
}
