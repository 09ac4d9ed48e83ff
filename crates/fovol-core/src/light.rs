use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Directional light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[f64; 3]", into = "[f64; 3]")]
pub struct Light {
    direction: DVec3,
}

impl Light {
    /// Light from `direction`, a vector of any length from the scene towards the light.
    ///
    /// # Errors
    /// A vector that is zero or not finite.
    pub fn towards(direction: DVec3) -> Result<Self> {
        let unit = direction.try_normalize().ok_or_else(|| Error::Extent {
            what: "light direction".into(),
            found: format!("{},{},{}", direction.x, direction.y, direction.z),
            expected: "a finite vector other than 0,0,0".into(),
        })?;
        Ok(Self { direction: unit })
    }

    /// Unit vector from the scene towards the light.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }
}

impl Default for Light {
    /// From above, a little to the right and in front: (0.5, 1, 0.3) normalised.
    fn default() -> Self {
        Self { direction: DVec3::new(0.5, 1.0, 0.3).normalize() }
    }
}

impl TryFrom<[f64; 3]> for Light {
    type Error = Error;

    fn try_from(direction: [f64; 3]) -> Result<Self> {
        Self::towards(DVec3::from_array(direction))
    }
}

impl From<Light> for [f64; 3] {
    fn from(light: Light) -> Self {
        light.direction.to_array()
    }
}
