use fovol_core::Camera;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

/// A random camera path around the origin, with fast, slow and still stretches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Journey {
    /// Azimuth and elevation in degrees and distance in world units at the start.
    start: [f64; 3],
    /// Change per frame at full speed: degrees, degrees, and the logarithm of the distance.
    speed: [f64; 3],
    /// The camera's target at the start, and its shift per frame at full speed.
    target: [[f64; 3]; 2],
    /// Frames at which the speed changes, and the fraction of full speed from there on.
    phases: Vec<(usize, f64)>,
    /// The vertical field of view in degrees.
    fovy: f64,
}

/// Vertical fields of view to draw from, in degrees.
const FOVY: [f64; 3] = [35.0, 35.0, 50.0];

impl Journey {
    /// Draws a path of `length` frames.
    pub fn draw(random: &mut impl Rng, length: usize) -> Self {
        let signed = |random: &mut dyn FnMut() -> f64, most: f64| (2.0 * random() - 1.0) * most;
        let mut unit = || random.random::<f64>();
        // Up to 4 degrees a frame: the speed of a user who turns a volume to see all sides.
        let pace = unit() * 4.0;
        let start = [360.0 * unit(), signed(&mut unit, 70.0), 1.0 + 1.9 * unit()];
        let speed = [signed(&mut unit, pace), signed(&mut unit, 0.6 * pace), signed(&mut unit, 0.02)];
        let target = [0.15, 0.004].map(|most| [(); 3].map(|()| signed(&mut unit, most)));
        let mut phases = vec![(0, if unit() < 0.15 { 0.0 } else { 1.0 })];
        while unit() < 0.4 {
            let at = (unit() * length as f64) as usize;
            phases.push((at, if unit() < 0.4 { 0.0 } else { 1.5 * unit() }));
        }
        phases.sort_by_key(|phase| phase.0);
        let fovy = FOVY[(unit() * FOVY.len() as f64) as usize];
        Self { start, speed, target, phases, fovy }
    }

    /// The cameras of the first `length` frames.
    pub fn cameras(&self, length: usize) -> Vec<Camera> {
        let mut travelled = 0.0;
        (0..length)
            .map(|t| {
                let camera = self.camera(travelled);
                travelled += self.phases.iter().rfind(|phase| phase.0 <= t).map_or(1.0, |phase| phase.1);
                camera
            })
            .collect()
    }

    /// The camera after `travelled` frames at full speed.
    fn camera(&self, travelled: f64) -> Camera {
        let [azimuth, elevation, distance] = self.start;
        let elevation = (elevation + self.speed[1] * travelled).clamp(-85.0, 85.0);
        let distance = distance * (self.speed[2] * travelled).exp();
        let mut camera =
            Camera::on_sphere(azimuth + self.speed[0] * travelled, elevation, distance, self.fovy);
        for a in 0..3 {
            camera.target[a] = self.target[0][a] + self.target[1][a] * travelled;
        }
        camera
    }
}
