//! A stack: pictures of one size and direction, each at a place of its own, at one or more times.

use super::plane::Plane;

/// Pictures that make a volume, at one time or more.
pub struct Stack {
    /// The pictures of each time, along the normal.
    pub times: Vec<Vec<Plane>>,
    /// What tells it apart from others of its series; empty where it is the only one.
    pub part: String,
    /// What is to be said of it.
    pub notes: Vec<String>,
}

impl Stack {
    /// The number of slices.
    pub fn depth(&self) -> usize {
        self.times.first().map_or(0, Vec::len)
    }

    /// The first picture.
    pub fn first(&self) -> &Plane {
        &self.times[0][0]
    }
}
