use super::fourier::{CubeTransform, wave_number};
use super::seeded::{Draws, mix};
use glam::Vec3;
use rayon::prelude::*;
use rustfft::num_complex::Complex32;

/// A vector field as Fourier coefficients of its three components, or as values.
pub(super) type Components = [Vec<Complex32>; 3];

/// Incompressible flow in a periodic box of edge 2π: a pseudo-spectral solver of
/// ∂u/∂t = P(u × ω) + ν∇²u, where P removes the divergence and with it the pressure.
///
/// After Canuto et al., *Spectral Methods in Fluid Dynamics*: rotational form, waves of |k| ≥ n/3 set
/// to zero against aliasing (the 2/3 rule), fourth-order Runge–Kutta with viscosity as an exact
/// integrating factor. Velocity and vorticity are both real, so one complex transform carries both.
pub(super) struct Flow {
    n: usize,
    viscosity: f32,
    transform: CubeTransform,
    /// Fourier coefficients of the velocity, x fastest.
    pub velocity: Components,
    spare: Vec<Complex32>,
}

/// The Courant number: how far the fastest wave may be carried in one step, in radians.
/// Runge–Kutta of fourth order is stable up to 2.8.
const COURANT: f32 = 2.0;

impl Flow {
    /// The flow with the velocity `at(x, y, z)`, 0 ≤ x, y, z < 2π, made free of divergence.
    #[cfg(test)]
    pub fn from_velocity(n: usize, viscosity: f32, at: impl Fn(Vec3) -> Vec3) -> Self {
        let mut flow = Self::at_rest(n, viscosity);
        let step = std::f32::consts::TAU / n as f32;
        for axis in 0..3 {
            for (i, value) in flow.velocity[axis].iter_mut().enumerate() {
                let position = Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32) * step;
                *value = at(position)[axis].into();
            }
            flow.transform.forward(&mut flow.velocity[axis], &mut flow.spare);
        }
        flow.project();
        flow
    }

    /// A random flow of root mean square speed 1 per component, most of whose energy is in waves of
    /// length 2π/`peak`: E(k) ∝ k⁴·exp(−2(k/peak)²). The same seed gives the same large waves for
    /// every `n`.
    pub fn random(n: usize, viscosity: f32, peak: f32, seed: u64) -> Self {
        let mut flow = Self::at_rest(n, viscosity);
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    let k = [x, y, z].map(|i| wave_number(i, n));
                    if is_leading(k) && is_kept(k, n) {
                        flow.set_wave(k, random_wave(k, peak, seed));
                    }
                }
            }
        }
        flow.project();
        let scale = (1.5 / flow.energy()).sqrt() as f32;
        for component in &mut flow.velocity {
            component.iter_mut().for_each(|c| *c *= scale);
        }
        flow
    }

    fn at_rest(n: usize, viscosity: f32) -> Self {
        let zeros = || vec![Complex32::default(); n * n * n];
        Self {
            n,
            viscosity,
            transform: CubeTransform::new(n),
            velocity: std::array::from_fn(|_| zeros()),
            spare: zeros(),
        }
    }

    /// Sets the coefficients of the waves `k` and −`k`, which are conjugate in a real field.
    fn set_wave(&mut self, k: [i32; 3], amplitude: [Complex32; 3]) {
        let index = |k: [i32; 3]| {
            let [x, y, z] = k.map(|k| k.rem_euclid(self.n as i32) as usize);
            (z * self.n + y) * self.n + x
        };
        let (here, opposite) = (index(k), index(k.map(|k| -k)));
        for axis in 0..3 {
            self.velocity[axis][here] = amplitude[axis];
            self.velocity[axis][opposite] = amplitude[axis].conj();
        }
    }

    fn project(&mut self) {
        let n = self.n;
        for_each_wave(n, &mut self.velocity, |k, u| if is_kept(k, n) { solenoidal(k, u) } else { ZERO });
    }

    /// Kinetic energy per unit mass: the mean of ½|u|².
    pub fn energy(&self) -> f64 {
        0.5 * self.velocity.iter().map(|component| sum_of_squares(component)).sum::<f64>()
    }

    /// The Fourier coefficients of the vorticity, i·k × u.
    pub fn vorticity(&self) -> Components {
        let mut vorticity = self.velocity.clone();
        for_each_wave(self.n, &mut vorticity, curl);
        vorticity
    }

    /// Advances the flow by `duration`.
    pub fn run(&mut self, duration: f32) {
        let mut left = duration;
        while left > 0.0 {
            let (slope, speed) = self.advection(&self.velocity.clone());
            let fastest = speed * (self.n / 3) as f32;
            let dt = if fastest > 0.0 { (COURANT / fastest).min(left) } else { left };
            self.step(&slope, dt);
            // What rounding leaves over is no step.
            left = if left - dt < 1e-6 * duration { 0.0 } else { left - dt };
        }
    }

    /// One Runge–Kutta step. With E = exp(−νk²·dt/2), slopes a, b, c, d:
    /// u ← E²u + dt/6·(E²a + 2E(b + c) + d).
    fn step(&mut self, a: &Components, dt: f32) {
        let (n, half) = (self.n, 0.5 * dt);
        let decay = Decay::new(n, self.viscosity * half);
        let mut stage = self.velocity.clone();
        combine(&mut stage, a, n, |k, u, a| decay.at(k) * (u + a * half));
        let b = self.advection(&stage).0;
        stage.clone_from(&self.velocity);
        combine(&mut stage, &b, n, |k, u, b| decay.at(k) * u + b * half);
        let c = self.advection(&stage).0;
        stage.clone_from(&self.velocity);
        combine(&mut stage, &c, n, |k, u, c| decay.at(k) * (decay.at(k) * u + c * dt));
        let d = self.advection(&stage).0;
        let sixth = dt / 6.0;
        combine(&mut self.velocity, a, n, |k, u, a| decay.at(k) * decay.at(k) * (u + a * sixth));
        combine(&mut self.velocity, &b, n, |k, u, b| u + decay.at(k) * b * (2.0 * sixth));
        combine(&mut self.velocity, &c, n, |k, u, c| u + decay.at(k) * c * (2.0 * sixth));
        combine(&mut self.velocity, &d, n, |_, u, d| u + d * sixth);
    }

    /// P(u × ω) of the coefficients `velocity`, and the largest |u_x| + |u_y| + |u_z|.
    fn advection(&mut self, velocity: &Components) -> (Components, f32) {
        // u + i·ω: both are real, so the inverse transform keeps them apart.
        let mut both = velocity.clone();
        for_each_wave(self.n, &mut both, |k, u| {
            let w = curl(k, u);
            std::array::from_fn(|axis| u[axis] + Complex32::i() * w[axis])
        });
        for component in &mut both {
            self.transform.inverse(component, &mut self.spare);
        }
        let speed = fastest(&both);
        let [mut xy, mut z, y] = both;
        cross_products(&mut xy, &mut z, &y);
        self.transform.forward(&mut xy, &mut self.spare);
        self.transform.forward(&mut z, &mut self.spare);
        let mut slope = [xy.clone(), y, z];
        self.separate(&xy, &mut slope);
        let n = self.n;
        for_each_wave(n, &mut slope, |k, s| if is_kept(k, n) { solenoidal(k, s) } else { ZERO });
        (slope, speed)
    }

    /// Splits the transform of x + i·y into those of the real fields x and y, which are conjugate at
    /// opposite waves.
    fn separate(&self, packed: &[Complex32], components: &mut Components) {
        let n = self.n;
        let opposite = |i: usize| if i == 0 { 0 } else { n - i };
        for_each_slab(n, components, &|kz, [x, y, _]| {
            for ky in 0..n {
                let row = (opposite(kz) * n + opposite(ky)) * n;
                for kx in 0..n {
                    let i = ky * n + kx;
                    let (here, there) = (packed[kz * n * n + i], packed[row + opposite(kx)].conj());
                    x[i] = (here + there) * 0.5;
                    y[i] = (here - there) * Complex32::new(0.0, -0.5);
                }
            }
        });
    }
}

const ZERO: [Complex32; 3] = [Complex32::new(0.0, 0.0); 3];

/// Whether a wave survives the 2/3 rule.
fn is_kept(k: [i32; 3], n: usize) -> bool {
    k.iter().all(|k| 3 * k.unsigned_abs() < n as u32)
}

/// True for one of each pair of opposite waves; false for the mean flow.
fn is_leading([x, y, z]: [i32; 3]) -> bool {
    (z, y, x) > (0, 0, 0)
}

fn random_wave(k: [i32; 3], peak: f32, seed: u64) -> [Complex32; 3] {
    let key = k.iter().fold(seed, |key, &k| mix(key ^ k as u32 as u64));
    let mut draws = Draws::new(key);
    let length = k.iter().map(|&k| (k * k) as f32).sum::<f32>().sqrt();
    // E(k) is spread over a sphere of area 4πk².
    let amplitude = length * (-(length / peak).powi(2)).exp();
    std::array::from_fn(|_| Complex32::new(draws.normal(), draws.normal()) * amplitude)
}

/// The part of `u` across `k`: without divergence.
fn solenoidal(k: [i32; 3], u: [Complex32; 3]) -> [Complex32; 3] {
    let k = k.map(|k| k as f32);
    let square = k.iter().map(|k| k * k).sum::<f32>();
    if square == 0.0 {
        return u;
    }
    let along = (u[0] * k[0] + u[1] * k[1] + u[2] * k[2]) / square;
    std::array::from_fn(|axis| u[axis] - along * k[axis])
}

/// i·k × u.
fn curl(k: [i32; 3], u: [Complex32; 3]) -> [Complex32; 3] {
    let [x, y, z] = k.map(|k| Complex32::new(0.0, k as f32));
    [y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]]
}

/// Replaces the components of every wave.
fn for_each_wave(
    n: usize,
    components: &mut Components,
    change: impl Fn([i32; 3], [Complex32; 3]) -> [Complex32; 3] + Sync,
) {
    for_each_slab(n, components, &|iz, [x, y, z]| {
        for iy in 0..n {
            for ix in 0..n {
                let (i, k) = (iy * n + ix, [ix, iy, iz].map(|i| wave_number(i, n)));
                [x[i], y[i], z[i]] = change(k, [x[i], y[i], z[i]]);
            }
        }
    });
}

/// `to ← change(k, to, from)` for every coefficient of every component.
fn combine(
    to: &mut Components,
    from: &Components,
    n: usize,
    change: impl Fn([usize; 3], Complex32, Complex32) -> Complex32 + Sync,
) {
    for_each_slab(n, to, &|z, slabs| {
        for (to, from) in slabs.into_iter().zip(from) {
            let from = &from[z * n * n..(z + 1) * n * n];
            for y in 0..n {
                for x in 0..n {
                    let i = y * n + x;
                    to[i] = change([x, y, z], to[i], from[i]);
                }
            }
        }
    });
}

/// Calls `change` with each z and the slabs of the components there, on all threads.
///
/// Not generic: what distributes the work is large, and compiled once for all changes.
fn for_each_slab(
    n: usize,
    [x, y, z]: &mut Components,
    change: &(dyn Fn(usize, [&mut [Complex32]; 3]) + Sync),
) {
    let slab = n * n;
    let slabs = x.par_chunks_mut(slab).zip(y.par_chunks_mut(slab)).zip(z.par_chunks_mut(slab));
    slabs.enumerate().for_each(|(iz, ((x, y), z))| change(iz, [x, y, z]));
}

/// exp(−k²·t) as a product over the axes.
struct Decay(Vec<f32>);

impl Decay {
    fn new(n: usize, t: f32) -> Self {
        Self((0..n).map(|i| (-(wave_number(i, n) as f32).powi(2) * t).exp()).collect())
    }

    #[inline]
    fn at(&self, [x, y, z]: [usize; 3]) -> f32 {
        self.0[x] * self.0[y] * self.0[z]
    }
}

/// The largest |u_x| + |u_y| + |u_z|, where u is the real part.
fn fastest([x, y, z]: &Components) -> f32 {
    let speed = |i: usize| x[i].re.abs() + y[i].re.abs() + z[i].re.abs();
    (0..x.len()).into_par_iter().with_min_len(4096).map(speed).reduce(|| 0.0, f32::max)
}

/// Turns u + i·ω of three components into (u × ω)_x + i·(u × ω)_y, in place of the first, and
/// (u × ω)_z, in place of the second.
fn cross_products(x: &mut [Complex32], y: &mut [Complex32], z: &[Complex32]) {
    let cross = |((x, y), z): ((&mut Complex32, &mut Complex32), &Complex32)| {
        let (u, w) = (Vec3::new(x.re, y.re, z.re), Vec3::new(x.im, y.im, z.im));
        let c = u.cross(w);
        *x = Complex32::new(c.x, c.y);
        *y = Complex32::new(c.z, 0.0);
    };
    x.par_iter_mut().zip(y).zip(z).with_min_len(4096).for_each(cross);
}

/// Σ|c|², added in order, so that the result does not depend on the number of threads.
fn sum_of_squares(values: &[Complex32]) -> f64 {
    values.iter().map(|c| f64::from(c.norm_sqr())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn divergence(flow: &Flow) -> f64 {
        let n = flow.n;
        let [x, y, z] = &flow.velocity;
        let square = |i: usize| {
            let k = [i % n, i / n % n, i / n / n].map(|i| wave_number(i, n) as f32);
            f64::from((x[i] * k[0] + y[i] * k[1] + z[i] * k[2]).norm_sqr())
        };
        (0..x.len()).map(square).sum::<f64>().sqrt()
    }

    #[test]
    fn a_random_flow_has_speed_1_and_no_divergence_before_and_after() {
        let mut flow = Flow::random(24, 0.02, 3.0, 11);
        assert!((flow.energy() - 1.5).abs() < 1e-5);
        assert!(divergence(&flow) < 1e-5, "{}", divergence(&flow));
        flow.run(0.3);
        assert!(divergence(&flow) < 1e-5, "{}", divergence(&flow));
    }

    #[test]
    fn viscosity_takes_energy_at_every_step_and_without_it_none_is_lost() {
        let mut flow = Flow::random(24, 0.03, 3.0, 5);
        let mut energy = flow.energy();
        for _ in 0..8 {
            flow.run(0.1);
            assert!(flow.energy() < energy);
            energy = flow.energy();
        }
        let mut ideal = Flow::random(24, 0.0, 3.0, 5);
        ideal.run(0.2);
        assert!((ideal.energy() - 1.5).abs() < 2e-3, "{}", ideal.energy());
    }

    /// An exact solution (Taylor and Green 1937), carried along by a steady wind: the decay tests
    /// viscosity, the way it has come tests advection.
    #[test]
    fn two_dimensional_taylor_green_vortices_decay_and_drift_exactly() {
        let (viscosity, duration, wind) = (0.1, 1.5, Vec3::new(0.7, -0.4, 0.3));
        let vortices = |p: Vec3| Vec3::new(p.x.sin() * p.y.cos(), -p.x.cos() * p.y.sin(), 0.0);
        let mut flow = Flow::from_velocity(16, viscosity, |p| wind + vortices(p));
        flow.run(duration);
        let decay = (-2.0 * viscosity * duration).exp();
        let expected = Flow::from_velocity(16, 0.0, |p| wind + vortices(p - wind * duration) * decay);
        for (found, expected) in flow.velocity.iter().flatten().zip(expected.velocity.iter().flatten()) {
            assert!((found - expected).norm() < 1e-4, "{found} {expected}");
        }
    }

    /// Brachet et al. 1983: enstrophy ½⟨ω²⟩ starts at 3/8 and changes little at first, so the energy
    /// 1/8 falls at the rate 2ν·3/8.
    #[test]
    fn three_dimensional_taylor_green_vortices_start_to_decay_at_the_known_rate() {
        let viscosity = 0.05;
        let initial =
            |p: Vec3| Vec3::new(p.x.sin() * p.y.cos() * p.z.cos(), -p.x.cos() * p.y.sin() * p.z.cos(), 0.0);
        let mut flow = Flow::from_velocity(32, viscosity, initial);
        assert!((flow.energy() - 0.125).abs() < 1e-6);
        flow.run(0.1);
        let expected = 0.125 - 2.0 * f64::from(viscosity) * 0.375 * 0.1;
        assert!((flow.energy() - expected).abs() < 1e-4, "{} {expected}", flow.energy());
    }

    /// Waves that both grids can hold start alike and, while viscosity keeps them smooth, stay alike.
    #[test]
    fn a_resolved_flow_does_not_depend_on_the_grid() {
        let start = |n| Flow::random(n, 0.15, 1.2, 3);
        let (mut coarse, mut fine) = (start(24), start(36));
        coarse.run(0.5);
        fine.run(0.5);
        assert!((coarse.energy() - fine.energy()).abs() < 1e-3 * fine.energy());
    }
}
