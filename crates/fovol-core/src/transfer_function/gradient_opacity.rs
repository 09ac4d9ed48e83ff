//! Opacity by gradient in transfer functions.

use crate::{Error, Result};

/// Piecewise-linear factor of the opacity over the length of the gradient of the values.
///
/// Homogeneous regions vanish where the factor of small gradients is 0; borders stay. The factor scales the extinction.
/// The length is in units of v per voxel, where v is the display value of the transfer function. If the edges of a
/// voxel differ, one voxel is their mean. The factor is constant before the first and after the last point. Two points
/// at one length make a step; at the length itself the later point holds.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientOpacity {
    points: Vec<[f64; 2]>,
}

impl GradientOpacity {
    /// Factor through `points` of length and factor, in rising order of length.
    ///
    /// # Errors
    /// No points, lengths that fall, are negative or not finite, or a factor outside [0, 1].
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self> {
        if points.is_empty() {
            return Err(wrong("has no points; give at least one [gradient, factor], or leave it out"));
        }
        for (i, &[length, factor]) in points.iter().enumerate() {
            if !(length >= 0.0 && length.is_finite()) {
                return Err(wrong(format!(
                    "has the gradient {length} at point {i}; gradients are lengths, finite and 0 or more"
                )));
            }
            if !(0.0..=1.0).contains(&factor) {
                return Err(wrong(format!(
                    "has the factor {factor} at point {i}; factors lie between 0 and 1"
                )));
            }
            if i > 0 && length < points[i - 1][0] {
                return Err(wrong(format!(
                    "has a smaller gradient at point {i} than before; sort the points by gradient"
                )));
            }
        }
        Ok(Self { points })
    }

    /// Factor of the points `[gradient, factor]` of a file.
    pub(super) fn of_lists(points: &[Vec<f64>]) -> Result<Self> {
        let two = |(i, numbers): (usize, &Vec<f64>)| {
            <[f64; 2]>::try_from(numbers.as_slice()).map_err(|_| {
                wrong(format!(
                    "has {} numbers at point {i}, but each point is two, [gradient, factor]",
                    numbers.len()
                ))
            })
        };
        Self::new(points.iter().enumerate().map(two).collect::<Result<_>>()?)
    }

    /// Points of length and factor, in rising order of length.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Factor, 0…1, of a gradient of `length`.
    pub fn evaluate(&self, length: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= length);
        if after == 0 {
            return self.points[0][1];
        }
        let [left, factor] = self.points[after - 1];
        let Some(&[right, next]) = self.points.get(after) else { return factor };
        factor + (length - left) / (right - left) * (next - factor)
    }

    /// Whether the factor is 1 everywhere, so that it changes nothing.
    pub fn is_neutral(&self) -> bool {
        self.points.iter().all(|point| point[1] == 1.0)
    }

    /// Length of the gradient above which the factor stays the same.
    pub fn settles_at(&self) -> f64 {
        let last = self.points[self.points.len() - 1];
        let changes = self.points.iter().rposition(|point| point[1] != last[1]);
        self.points[changes.map_or(0, |i| i + 1)][0]
    }

    /// Factor for lengths in a unit that is shorter by `factor`: all lengths are multiplied. Lengths stay finite.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let scaled = |&[length, opacity]: &[f64; 2]| [(length * factor).min(f64::MAX), opacity];
        Self { points: self.points.iter().map(scaled).collect() }
    }
}

fn wrong(problem: impl std::fmt::Display) -> Error {
    Error::TransferFunction(format!("its opacity by gradient {problem}"))
}

#[cfg(test)]
mod tests {
    use super::super::TransferFunction;
    use super::*;
    use proptest::prelude::*;

    fn of(text: &str) -> std::result::Result<TransferFunction, String> {
        serde_json::from_str(text).map_err(|e| e.to_string())
    }

    #[test]
    fn factors_are_linear_between_points_and_constant_outside() {
        let curve =
            GradientOpacity::new(vec![[0.1, 0.0], [0.2, 0.5], [0.2, 0.8], [0.4, 1.0], [0.6, 1.0]]).unwrap();
        for (length, factor) in
            [(0.0, 0.0), (0.15, 0.25), (0.1999, 0.4995), (0.2, 0.8), (0.3, 0.9), (9.0, 1.0)]
        {
            assert!((curve.evaluate(length) - factor).abs() < 1e-9, "{length}");
        }
        assert_eq!((curve.settles_at(), curve.is_neutral()), (0.4, false));
        let constant = GradientOpacity::new(vec![[0.3, 1.0]]).unwrap();
        assert_eq!((constant.settles_at(), constant.is_neutral()), (0.3, true));
        assert!((curve.scaled(10.0).evaluate(1.5) - 0.25).abs() < 1e-9);
    }

    #[test]
    fn json_has_the_unit_of_its_points() {
        let points = r#""points":[[0,0,0,0,0],[1,1,1,1,1]]"#;
        let own = of(&format!(r#"{{{points},"gradient":[[0,0],[0.05,1]]}}"#)).unwrap();
        assert_eq!(own.gradient().unwrap().points(), [[0.0, 0.0], [0.05, 1.0]]);
        let text = serde_json::to_string(&own).unwrap();
        assert!(text.ends_with(r#""gradient":[[0.0,0.0],[0.05,1.0]]}"#), "{text}");
        assert_eq!(of(&text).unwrap(), own);
        // Points in data values have gradients in data values; they are saved as parts of the range.
        let data = of(
            r#"{"points":[[-1000,0,0,0,0],[1000,1,1,1,1]],"range":[-1000,1000],"gradient":[[0,0],[100,1]]}"#,
        )
        .unwrap();
        assert_eq!(data.gradient().unwrap().points(), [[0.0, 0.0], [0.05, 1.0]]);
        let parts = of(&format!(r#"{{{points},"range":[-1000,1000],"gradient":[[0,0],[0.05,1]]}}"#)).unwrap();
        assert_eq!(parts, data);
        assert_eq!(of(&serde_json::to_string(&data).unwrap()).unwrap(), data);
        assert_eq!(of(&format!("{{{points}}}")).unwrap().gradient(), None);
    }

    #[test]
    fn gradients_keep_their_data_values_over_another_range() {
        let curve = GradientOpacity::new(vec![[0.0, 0.0], [0.05, 1.0]]).unwrap();
        let tf = TransferFunction::grey_ramp(1.0).with_range(Some([-1000.0, 1000.0])).unwrap();
        let tf = tf.with_gradient(Some(curve.clone()));
        // 100 data values per voxel are a fifth of 500.
        let over = tf.over([0.0, 500.0]);
        assert_eq!(over.gradient().unwrap().points(), [[0.0, 0.0], [0.2, 1.0]]);
        assert_eq!(tf.over([-1000.0, 1000.0]).gradient(), Some(&curve));
        assert!(tf.over([3.0, 3.0]).gradient().is_some());
        let free = tf.with_range(None).unwrap();
        assert_eq!(free.over([0.0, 7.0]).gradient(), Some(&curve));
        assert_eq!(free.on_log_scale([0.0, 1000.0], 1.0).unwrap().gradient(), Some(&curve));
        assert_eq!(free.with_gradient(None).gradient(), None);
    }

    #[test]
    fn bad_points_are_refused() {
        for (bad, said) in [
            ("[]", "no points"),
            ("[[0]]", "1 numbers at point 0"),
            ("[[0,0],[1,1,1]]", "3 numbers at point 1"),
            ("[[-0.1,0]]", "gradient -0.1 at point 0"),
            ("[[0,0],[0.1,1.5]]", "factor 1.5 at point 1"),
            ("[[0.2,0],[0.1,1]]", "sort the points"),
        ] {
            let error = of(&format!(r#"{{"points":[[0,0,0,0,0]],"gradient":{bad}}}"#)).unwrap_err();
            assert!(error.contains("opacity by gradient") && error.contains(said), "{bad}: {error}");
        }
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(GradientOpacity::new(vec![[bad, 1.0]]).is_err());
            assert!(GradientOpacity::new(vec![[0.0, bad]]).is_err());
        }
    }

    proptest! {
        #[test]
        fn factors_lie_between_0_and_1(
            mut lengths in prop::collection::vec(0.0f64..2.0, 1..8), seed in 0.0f64..1.0, at in 0.0f64..3.0,
        ) {
            lengths.sort_by(f64::total_cmp);
            let points = lengths.iter().enumerate().map(|(i, &length)| [length, (seed * (i + 1) as f64).fract()]);
            let curve = GradientOpacity::new(points.collect()).unwrap();
            prop_assert!((0.0..=1.0).contains(&curve.evaluate(at)));
            let settled = curve.settles_at();
            prop_assert_eq!(curve.evaluate(settled), curve.evaluate(settled + at));
        }
    }
}
