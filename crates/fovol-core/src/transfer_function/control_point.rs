use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Control point of a piecewise-linear transfer function: `[v, r, g, b, a]` in JSON.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 5]", into = "[f64; 5]")]
pub struct ControlPoint {
    /// Display value, 0…1.
    pub value: f64,
    /// Display (sRGB) colour, 0…1 per channel.
    pub colour: [f64; 3],
    /// Opacity per reference length (one voxel), 0…1.
    pub opacity: f64,
}

impl ControlPoint {
    /// Control point at `value` with `colour` and `opacity`, all 0…1.
    pub const fn new(value: f64, colour: [f64; 3], opacity: f64) -> Self {
        Self { value, colour, opacity }
    }

    /// Control point of the `numbers` of point `i`.
    pub(super) fn of_numbers((i, numbers): (usize, &Vec<f64>)) -> Result<Self> {
        let five = <[f64; 5]>::try_from(numbers.as_slice());
        five.map(Self::from).map_err(|_| {
            Error::TransferFunction(format!(
                "point {i} has {} numbers, but each point is five, [v, r, g, b, a]",
                numbers.len()
            ))
        })
    }
}

impl From<[f64; 5]> for ControlPoint {
    fn from([value, r, g, b, opacity]: [f64; 5]) -> Self {
        Self { value, colour: [r, g, b], opacity }
    }
}

impl From<ControlPoint> for [f64; 5] {
    fn from(p: ControlPoint) -> Self {
        [p.value, p.colour[0], p.colour[1], p.colour[2], p.opacity]
    }
}
