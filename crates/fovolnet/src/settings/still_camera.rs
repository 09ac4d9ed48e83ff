use super::parse;
use fovol_core::Camera;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Still camera as seven numbers: eye, target and vertical field of view. They are checked when they are used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 7]", into = "[f64; 7]")]
pub struct StillCamera {
    /// Position of the eye in world space.
    pub eye: DVec3,
    /// Point at the centre of the picture.
    pub target: DVec3,
    /// Vertical field of view in degrees.
    pub fovy: f64,
}

impl StillCamera {
    /// Camera with these numbers, which may be unusable; see [`Camera::check`].
    pub fn camera(&self) -> Camera {
        Camera::at(self.eye, self.target, self.fovy)
    }
}

impl From<&Camera> for StillCamera {
    fn from(camera: &Camera) -> Self {
        Self { eye: camera.eye, target: camera.target, fovy: camera.fovy }
    }
}

impl From<[f64; 7]> for StillCamera {
    fn from([ex, ey, ez, tx, ty, tz, fovy]: [f64; 7]) -> Self {
        Self { eye: DVec3::new(ex, ey, ez), target: DVec3::new(tx, ty, tz), fovy }
    }
}

impl From<StillCamera> for [f64; 7] {
    fn from(StillCamera { eye, target, fovy }: StillCamera) -> Self {
        [eye.x, eye.y, eye.z, target.x, target.y, target.z, fovy]
    }
}

impl fmt::Display for StillCamera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&<[f64; 7]>::from(*self).map(|number| number.to_string()).join(","))
    }
}

impl FromStr for StillCamera {
    type Err = String;

    /// Parses `EX,EY,EZ,TX,TY,TZ,FOVY`.
    fn from_str(text: &str) -> Result<Self, String> {
        parse::numbers::<7>(text).map(Self::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_read_back() {
        let camera = StillCamera::from([0.3, -0.5, 1.7, 0.0, 0.25, 0.0, 35.0]);
        assert_eq!(camera.to_string(), "0.3,-0.5,1.7,0,0.25,0,35");
        assert_eq!(camera.to_string().parse(), Ok(camera));
        assert!("1,2,3".parse::<StillCamera>().unwrap_err().contains("7 finite numbers"));
    }
}
