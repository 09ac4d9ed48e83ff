use crate::{Camera, Error, Result};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Keyframe of a camera path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Keyframe {
    /// Frame number.
    pub frame: f64,
    /// Camera at this frame.
    #[serde(flatten)]
    pub camera: Camera,
}

/// Camera as a function of the frame number. It never depends on the number of frames rendered.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraPath {
    /// 0.72° of azimuth a frame at elevation 20°, distance 1.9; field of view 35°.
    #[default]
    Orbit,
    /// The paper's fly-through: azimuth 0.72°·i, elevation 35°·sin(4πi/500), distance
    /// 1.9 + 0.8·cos(6πi/500); field of view 35°.
    Flythrough,
    /// One camera for every frame.
    Still(Camera),
    /// Rotation about the vertical axis through the target.
    Turntable {
        /// Camera of frame 0.
        start: Camera,
        /// Azimuth per frame in degrees; +z turns towards +x.
        degrees: f64,
    },
    /// Catmull–Rom spline through keyframes; still before the first and after the last.
    Keyframes(Vec<Keyframe>),
}

const FOVY: f64 = 35.0;

impl CameraPath {
    /// Path through `keyframes`.
    ///
    /// # Errors
    /// No keyframes, frames that do not rise, or a camera that cannot be used.
    pub fn through(keyframes: Vec<Keyframe>) -> Result<Self> {
        if keyframes.is_empty() {
            return Err(Error::CameraPath("it has no keyframes; give at least one".into()));
        }
        for (i, key) in keyframes.iter().enumerate() {
            key.camera.check()?;
            let rises = i == 0 || key.frame > keyframes[i - 1].frame;
            if !key.frame.is_finite() || !rises {
                return Err(Error::CameraPath(format!(
                    "keyframe {i} is at frame {}, which does not come after the one before; sort them by frame",
                    key.frame
                )));
            }
        }
        Ok(Self::Keyframes(keyframes))
    }

    /// The camera of frame `i`.
    pub fn camera(&self, i: u32) -> Camera {
        let frame = f64::from(i);
        match self {
            Self::Orbit => Camera::on_sphere(0.72 * frame, 20.0, 1.9, FOVY),
            Self::Flythrough => Camera::on_sphere(
                0.72 * frame,
                35.0 * (4.0 * PI * frame / 500.0).sin(),
                1.9 + 0.8 * (6.0 * PI * frame / 500.0).cos(),
                FOVY,
            ),
            Self::Still(camera) => *camera,
            Self::Turntable { start, degrees } => {
                let turn = DQuat::from_rotation_y((degrees * frame).to_radians());
                Camera { eye: start.target + turn * (start.eye - start.target), ..*start }
            }
            Self::Keyframes(keys) => between(keys, frame),
        }
    }
}

fn between(keys: &[Keyframe], frame: f64) -> Camera {
    let after = keys.partition_point(|k| k.frame <= frame);
    if after == 0 {
        return keys[0].camera;
    }
    if after == keys.len() {
        return keys[after - 1].camera;
    }
    let at = |i: isize| &keys[i.clamp(0, keys.len() as isize - 1) as usize].camera;
    let left = after as isize - 1;
    let cameras = [at(left - 1), at(left), at(left + 1), at(left + 2)];
    let (a, b) = (keys[after - 1].frame, keys[after].frame);
    let f = (frame - a) / (b - a);
    let camera = Camera::at(
        catmull_rom(cameras.map(|c| c.eye), f),
        catmull_rom(cameras.map(|c| c.target), f),
        cameras[1].fovy + f * (cameras[2].fovy - cameras[1].fovy),
    );
    // A spline may move the eye through its target. Holding the last keyframe's camera avoids a division by zero.
    if camera.check().is_ok() { camera } else { *cameras[1] }
}

/// Uniform Catmull–Rom spline between `p[1]` (f = 0) and `p[2]` (f = 1).
fn catmull_rom(p: [DVec3; 4], f: f64) -> DVec3 {
    0.5 * (2.0 * p[1]
        + f * ((p[2] - p[0])
            + f * ((2.0 * p[0] - 5.0 * p[1] + 4.0 * p[2] - p[3]) + f * (3.0 * (p[1] - p[2]) + p[3] - p[0]))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbit_and_flythrough_start_as_specified() {
        let orbit = CameraPath::Orbit.camera(0);
        assert!((orbit.eye.length() - 1.9).abs() < 1e-12);
        assert!((orbit.eye.y - 1.9 * 20f64.to_radians().sin()).abs() < 1e-12);
        let fly = CameraPath::Flythrough.camera(0);
        assert!((fly.eye - DVec3::new(0.0, 0.0, 2.7)).length() < 1e-12);
        assert!(CameraPath::Orbit.camera(10).eye.x > 0.0);
    }

    #[test]
    fn a_turntable_goes_round_its_target() {
        let start = Camera::at(DVec3::new(0.5, 1.0, 3.0), DVec3::new(0.5, 0.0, 0.0), 35.0);
        let path = CameraPath::Turntable { start, degrees: 90.0 };
        assert!((path.camera(0).eye - start.eye).length() < 1e-12);
        assert!((path.camera(1).eye - DVec3::new(3.5, 1.0, 0.0)).length() < 1e-12);
        assert!((path.camera(4).eye - start.eye).length() < 1e-12);
        assert_eq!(path.camera(3).target, start.target);
    }

    #[test]
    fn keyframes_are_met_and_held() {
        let key = |frame, azimuth| Keyframe { frame, camera: Camera::on_sphere(azimuth, 10.0, 2.0, 40.0) };
        let path = CameraPath::through(vec![key(5.0, 0.0), key(10.0, 30.0), key(20.0, 90.0)]).unwrap();
        assert_eq!(path.camera(0), path.camera(5));
        assert!((path.camera(10).eye - Camera::on_sphere(30.0, 10.0, 2.0, 40.0).eye).length() < 1e-12);
        assert_eq!(path.camera(99), path.camera(20));
    }

    #[test]
    fn unsorted_keyframes_are_refused() {
        let key = |frame| Keyframe { frame, camera: Camera::on_sphere(0.0, 10.0, 2.0, 40.0) };
        assert!(CameraPath::through(vec![key(5.0), key(5.0)]).is_err());
        assert!(CameraPath::through(vec![]).is_err());
        assert!(CameraPath::through(vec![key(f64::NAN)]).is_err());
    }
}
