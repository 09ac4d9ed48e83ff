//! One picture of a series: where it lies, and what it differs by from others at its place.

use glam::DVec3;

/// Position and directions of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Centre of the first pixel, in LPS and mm.
    pub position: DVec3,
    /// Direction along a row of pixels: voxel axis x.
    pub along_x: DVec3,
    /// Direction down a column of pixels: voxel axis y.
    pub along_y: DVec3,
}

impl Place {
    /// The unit vector at right angles to the picture.
    pub fn normal(&self) -> DVec3 {
        self.along_x.cross(self.along_y).normalize_or_zero()
    }

    /// How far along the normal the picture lies.
    pub fn height(&self) -> f64 {
        self.position.dot(self.normal())
    }

    /// Whether both are turned alike, up to rounded numbers.
    pub fn is_parallel(&self, other: &Self) -> bool {
        let near = |a: DVec3, b: DVec3| (a - b).length() < 2e-3;
        near(self.along_x, other.along_x) && near(self.along_y, other.along_y)
    }
}

/// Attributes that tell pictures at one place apart, as text that can be compared.
///
/// The first ones separate series, the last ones times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Keys {
    /// Kind of the picture: original, magnitude, phase…
    pub image_type: String,
    /// Number or time of the echo.
    pub echo: String,
    /// Name of the stack.
    pub stack: String,
    /// Strength of the diffusion weighting.
    pub diffusion: String,
    /// Number of the segment.
    pub segment: String,
    /// Number of the time point.
    pub temporal: Option<f64>,
    /// Delay after a trigger, in ms.
    pub trigger: Option<f64>,
    /// Number of the acquisition.
    pub acquisition: Option<f64>,
}

/// Scaling from stored numbers to values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Factor.
    pub slope: f64,
    /// Offset.
    pub intercept: f64,
}

impl Scale {
    /// Values are what is stored.
    pub const IDENTITY: Self = Self { slope: 1.0, intercept: 0.0 };
}

/// One picture of a series.
#[derive(Debug, Clone)]
pub struct Plane {
    /// Number of its file among those of the series.
    pub file: usize,
    /// Number of the frame in the file, from 0 on.
    pub frame: usize,
    /// Number that the scanner gave, for the order where there are no positions.
    pub instance: Option<f64>,
    /// Where it lies.
    pub place: Option<Place>,
    /// Where it lies along the normal, for pictures without a position.
    pub location: Option<f64>,
    /// Distance between pixels along x and y.
    pub spacing: [f64; 2],
    /// How values come from stored numbers.
    pub scale: Scale,
    /// What it differs by from others at its place.
    pub keys: Keys,
}
