use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// One corner of a piecewise-linear transfer function: `[v, r, g, b, a]` in JSON.
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
    /// A corner at `value` with `colour` and `opacity`, all 0…1.
    pub const fn new(value: f64, colour: [f64; 3], opacity: f64) -> Self {
        Self { value, colour, opacity }
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

/// Piecewise-linear RGBA over the display value v in [0, 1].
///
/// Constant before the first and after the last corner. Two corners at one value make a step;
/// at the value itself the later one holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Points", into = "Points")]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
}

#[derive(Serialize, Deserialize)]
struct Points {
    points: Vec<ControlPoint>,
}

impl TryFrom<Points> for TransferFunction {
    type Error = Error;

    fn try_from(p: Points) -> Result<Self> {
        Self::new(p.points)
    }
}

impl From<TransferFunction> for Points {
    fn from(tf: TransferFunction) -> Self {
        Self { points: tf.points }
    }
}

impl TransferFunction {
    /// A transfer function through `points`, in rising order of value.
    ///
    /// # Errors
    /// No points, values that fall, or numbers outside [0, 1].
    pub fn new(points: Vec<ControlPoint>) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::TransferFunction(
                "it has no points; give at least one [v, r, g, b, a]".into(),
            ));
        }
        for (i, p) in points.iter().enumerate() {
            if !(0.0..=1.0).contains(&p.value) {
                return Err(Error::TransferFunction(format!(
                    "point {i} has v = {}, but v runs from 0 to 1 over the shown range (--range LO,HI): write (value - LO)/(HI - LO)",
                    p.value
                )));
            }
            if <[f64; 5]>::from(*p).iter().any(|x| !(0.0..=1.0).contains(x)) {
                return Err(Error::TransferFunction(format!(
                    "point {i} has a colour or opacity outside [0, 1]; r, g, b and a all lie between 0 and 1"
                )));
            }
            if i > 0 && p.value < points[i - 1].value {
                return Err(Error::TransferFunction(format!(
                    "point {i} has a smaller value than the one before; sort the points by v"
                )));
            }
        }
        Ok(Self { points })
    }

    /// A grey ramp: black and transparent at 0, white and opacity `opacity` at 1.
    pub fn grey_ramp(opacity: f64) -> Self {
        Self {
            points: vec![
                ControlPoint::new(0.0, [0.0; 3], 0.0),
                ControlPoint::new(1.0, [1.0; 3], opacity.clamp(0.0, 1.0)),
            ],
        }
    }

    /// The corners, in rising order.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// Colour and opacity `[r, g, b, a]` at display value `v` (clamped to [0, 1]; NaN reads as 0).
    pub fn evaluate(&self, v: f64) -> [f64; 4] {
        let v = if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        let after = self.points.partition_point(|p| p.value <= v);
        let rgba = |p: &ControlPoint| [p.colour[0], p.colour[1], p.colour[2], p.opacity];
        if after == 0 {
            return rgba(&self.points[0]);
        }
        let left = &self.points[after - 1];
        let Some(right) = self.points.get(after) else { return rgba(left) };
        let f = (v - left.value) / (right.value - left.value);
        let (a, b) = (rgba(left), rgba(right));
        std::array::from_fn(|c| a[c] + f * (b[c] - a[c]))
    }

    /// The largest opacity over the closed interval [`lo`, `hi`] of display values.
    pub fn max_opacity(&self, lo: f64, hi: f64) -> f64 {
        let ends = self.evaluate(lo)[3].max(self.evaluate(hi)[3]);
        // A step seen from its left side: the earlier corner's opacity is approached, so it counts.
        self.points
            .iter()
            .filter(|p| p.value >= lo && p.value <= hi)
            .fold(ends, |most, p| most.max(p.opacity))
    }

    /// The steepest change of opacity or colour per unit of v; infinite where the function has a step.
    pub fn steepest_slope(&self) -> f64 {
        self.points.windows(2).fold(0.0, |most: f64, pair| {
            let (a, b): ([f64; 5], [f64; 5]) = (pair[0].into(), pair[1].into());
            let rise = (1..5).map(|c| (b[c] - a[c]).abs()).fold(0.0, f64::max);
            if rise == 0.0 { most } else { most.max(rise / (b[0] - a[0])) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points() -> impl Strategy<Value = Vec<ControlPoint>> {
        prop::collection::vec(prop::array::uniform5(0.0f64..=1.0), 1..12).prop_map(|mut all| {
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            all.into_iter().map(ControlPoint::from).collect()
        })
    }

    #[test]
    fn a_step_belongs_to_its_right_side() {
        let tf = TransferFunction::new(vec![
            ControlPoint::new(0.0, [0.0; 3], 0.0),
            ControlPoint::new(0.5, [0.0; 3], 0.0),
            ControlPoint::new(0.5, [1.0; 3], 0.8),
        ])
        .unwrap();
        assert_eq!(tf.evaluate(0.4999)[3], 0.0);
        assert_eq!(tf.evaluate(0.5)[3], 0.8);
        assert_eq!(tf.steepest_slope(), f64::INFINITY);
        assert_eq!(tf.max_opacity(0.0, 0.499), 0.0);
    }

    #[test]
    fn bad_functions_are_refused() {
        assert!(TransferFunction::new(vec![]).is_err());
        let p = |v, a| ControlPoint::new(v, [0.5; 3], a);
        assert!(TransferFunction::new(vec![p(0.5, 0.0), p(0.2, 0.0)]).is_err());
        assert!(TransferFunction::new(vec![p(0.5, 1.5)]).is_err());
        assert!(TransferFunction::new(vec![p(f64::NAN, 0.5)]).is_err());
        let real = TransferFunction::new(vec![p(-1000.0, 0.0)]).unwrap_err().to_string();
        assert!(real.contains("v = -1000") && real.contains("the shown range"), "{real}");
    }

    #[test]
    fn json_is_the_documented_shape() {
        let tf: TransferFunction = serde_json::from_str(r#"{"points":[[0,0,0,0,0],[1,1,1,1,0.5]]}"#).unwrap();
        assert_eq!(tf.evaluate(0.5), [0.5, 0.5, 0.5, 0.25]);
        assert_eq!(
            serde_json::to_string(&tf).unwrap(),
            r#"{"points":[[0.0,0.0,0.0,0.0,0.0],[1.0,1.0,1.0,1.0,0.5]]}"#
        );
    }

    proptest! {
        #[test]
        fn max_opacity_bounds_every_value(points in points(), a in 0.0f64..=1.0, b in 0.0f64..=1.0, f in 0.0f64..=1.0) {
            let tf = TransferFunction::new(points).unwrap();
            let (lo, hi) = (a.min(b), a.max(b));
            prop_assert!(tf.evaluate(lo + f * (hi - lo))[3] <= tf.max_opacity(lo, hi) + 1e-12);
        }

        #[test]
        fn corners_are_met(points in points()) {
            let tf = TransferFunction::new(points.clone()).unwrap();
            for (i, p) in points.iter().enumerate() {
                let last_of_its_value = points.get(i + 1).is_none_or(|next| next.value > p.value);
                if last_of_its_value {
                    prop_assert!((tf.evaluate(p.value)[3] - p.opacity).abs() < 1e-12);
                }
            }
        }
    }
}
