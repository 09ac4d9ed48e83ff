mod control_point;
mod gradient_opacity;
mod nan;

pub use control_point::ControlPoint;
pub use gradient_opacity::GradientOpacity;

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Piecewise-linear RGBA function of the display value v in [0, 1].
///
/// The function is constant before the first and after the last control point. Two points at one value make a step;
/// at the value itself the later point holds. With a [range](Self::range), v covers these data values instead of the
/// displayed range; [`TransferFunction::over`] converts. NaN can have a colour of its own and is transparent
/// otherwise. Opacity can also depend on the gradient of the values, see [`GradientOpacity`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Points", into = "Points")]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    range: Option<[f64; 2]>,
    /// Colour and opacity of NaN.
    nan: Option<[f64; 4]>,
    gradient: Option<GradientOpacity>,
}

#[derive(Serialize, Deserialize)]
struct Points {
    /// Control points `[v, r, g, b, a]`; their length is checked later, so that the message can name the point.
    points: Vec<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    range: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    nan: Option<[f64; 4]>,
    /// Points of [`GradientOpacity`], in the unit of v.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gradient: Option<Vec<Vec<f64>>>,
}

impl TryFrom<Points> for TransferFunction {
    type Error = Error;

    fn try_from(p: Points) -> Result<Self> {
        let points = p.points.iter().enumerate().map(ControlPoint::of_numbers).collect::<Result<_>>()?;
        let gradient = p.gradient.map(|points| GradientOpacity::of_lists(&points)).transpose()?;
        let function = match p.range {
            Some(range) => in_range(points, gradient, range),
            None => Ok(Self::new(points)?.with_gradient(gradient)),
        };
        match p.nan {
            Some(nan) => function?.with_nan(nan),
            None => function,
        }
    }
}

impl From<TransferFunction> for Points {
    fn from(tf: TransferFunction) -> Self {
        let points = tf.points.iter().map(|&point| <[f64; 5]>::from(point).to_vec()).collect();
        let gradient = tf.gradient.map(|curve| curve.points().iter().map(|point| point.to_vec()).collect());
        Self { points, range: tf.range, nan: tf.nan, gradient }
    }
}

/// Transfer function of `points` and `gradient` over the data values `range`. Values of points are fractions of the
/// range, or data values if one lies outside [0, 1] or if the first and the last are the ends of the range.
fn in_range(
    mut points: Vec<ControlPoint>,
    mut gradient: Option<GradientOpacity>,
    range: [f64; 2],
) -> Result<TransferFunction> {
    let [lo, hi] = checked_range(range)?;
    let ends = [points.first(), points.last()].map(|p| p.map(|p| p.value));
    let has_ends = ends == [Some(lo), Some(hi)];
    if has_ends || points.iter().any(|p| !(0.0..=1.0).contains(&p.value)) {
        if let Some((i, p)) = points.iter().enumerate().find(|(_, p)| !(lo..=hi).contains(&p.value)) {
            return Err(Error::TransferFunction(format!(
                "point {i} has the value {}, outside its range {lo} to {hi}; widen the range",
                p.value
            )));
        }
        points.iter_mut().for_each(|p| p.value = ((p.value - lo) / (hi - lo)).clamp(0.0, 1.0));
        gradient = gradient.map(|curve| curve.scaled((hi - lo).recip()));
    }
    TransferFunction::new(points)?.with_gradient(gradient).with_range(Some(range))
}

fn checked_range([lo, hi]: [f64; 2]) -> Result<[f64; 2]> {
    if lo < hi && (hi - lo).is_finite() {
        return Ok([lo, hi]);
    }
    Err(Error::TransferFunction(format!(
        "its range is {lo} to {hi}; give two finite data values, the lower one first"
    )))
}

impl TransferFunction {
    /// Transfer function through `points`, in rising order of value.
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
                    "point {i} has v = {}, but v runs from 0 to 1 over the shown range (--range LO,HI); for data values add \"range\":[LO,HI] beside \"points\", or write (value - LO)/(HI - LO)",
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
        Ok(Self { points, range: None, nan: None, gradient: None })
    }

    /// Replaces the control points and keeps everything else.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn with_points(self, points: Vec<ControlPoint>) -> Result<Self> {
        Ok(Self { points: Self::new(points)?.points, ..self })
    }

    /// Sets the data values that v covers; `None` is the displayed range.
    ///
    /// # Errors
    /// A range that is not finite and rising.
    pub fn with_range(mut self, range: Option<[f64; 2]>) -> Result<Self> {
        self.range = range.map(checked_range).transpose()?;
        Ok(self)
    }

    /// Data values of v = 0 and v = 1; `None` if v covers the displayed range.
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }

    /// Converts the function to the `shown` data values, so that every colour stays at its data value. A function
    /// without a [range](Self::range) stays unchanged.
    pub fn over(&self, shown: [f64; 2]) -> Self {
        let Some([lo, hi]) = self.range.filter(|range| *range != shown) else {
            return Self { range: None, ..self.clone() };
        };
        let [from, to] = shown;
        let own = |v: f64| (from + v * (to - from) - lo) / (hi - lo);
        let at = |v: f64| {
            let [r, g, b, a] = self.evaluate(own(v));
            ControlPoint::new(v, [r, g, b], a)
        };
        if to <= from {
            // All values are equal.
            return Self { points: vec![at(0.0)], range: None, ..self.clone() };
        }
        let moved = self.points.iter().map(|p| {
            let value = (lo + p.value * (hi - lo) - from) / (to - from);
            // Points at an end stay there in spite of rounding.
            let end = value.round();
            let value = if (value - end).abs() < SNAP && (end == 0.0 || end == 1.0) { end } else { value };
            ControlPoint { value, ..*p }
        });
        let (mut before, mut after) = (false, false);
        let mut points: Vec<ControlPoint> = moved
            .inspect(|p| {
                before |= p.value < 0.0;
                after |= p.value > 1.0;
            })
            .filter(|p| (0.0..=1.0).contains(&p.value))
            .collect();
        if points.is_empty() || (before && points[0].value > 0.0) {
            points.insert(0, at(0.0));
        }
        if after && points[points.len() - 1].value < 1.0 {
            points.push(at(1.0));
        }
        let gradient = self.gradient.as_ref().map(|curve| curve.scaled((hi - lo) / (to - from)));
        Self { points, range: None, nan: self.nan, gradient }
    }

    /// Converts a function over logarithms of values to one over linear values in `shown`. Logarithms run from the
    /// `least` positive value to the upper end; values up to `least` get the colour of v = 0. The function's own
    /// range is dropped. Gradients stay those of linear values.
    ///
    /// # Errors
    /// [`Error::TransferFunction`] where no positive value is shown.
    pub fn on_log_scale(&self, shown: [f64; 2], least: f64) -> Result<Self> {
        let [from, to] = shown;
        let is_positive = least > 0.0 && to > least && to.is_finite() && from < to;
        if !is_positive {
            return Err(Error::TransferFunction(format!(
                "a logarithmic scale needs positive values, but {from} to {to} are shown; use a linear scale, or another range"
            )));
        }
        let decades = (to / least).log10();
        let linear = |v: f64| ((least * 10f64.powf(v * decades) - from) / (to - from)).clamp(0.0, 1.0);
        let logarithm = |v: f64| {
            let x = from + v * (to - from);
            if x > least { ((x / least).log10() / decades).clamp(0.0, 1.0) } else { 0.0 }
        };
        let mut breaks = vec![0.0, 1.0];
        breaks.extend(self.points.iter().map(|p| linear(p.value)));
        let function = Self::of_curve(&breaks, |v| self.evaluate(logarithm(v)))?;
        Ok(Self { nan: self.nan, gradient: self.gradient.clone(), ..function })
    }

    /// Approximates `curve` (v in [0, 1] to RGBA) to a fifth of an 8-bit step.
    ///
    /// The curve may have jumps or kinks only at `breaks`, in any order. They should include 0 and 1, since the curve
    /// is ignored beyond the outermost ones.
    ///
    /// # Errors
    /// Errors of [`Self::new`].
    pub fn of_curve(breaks: &[f64], curve: impl Fn(f64) -> [f64; 4]) -> Result<Self> {
        let mut breaks: Vec<f64> = breaks.iter().copied().filter(|v| (0.0..=1.0).contains(v)).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        let mut points = Vec::new();
        let mut push = |v: f64, [r, g, b, a]: [f64; 4]| {
            let point = ControlPoint::new(v, [r, g, b].map(|c| c.clamp(0.0, 1.0)), a.clamp(0.0, 1.0));
            if points.last() != Some(&point) {
                points.push(point);
            }
        };
        if let Some(&first) = breaks.first() {
            push(first, curve(first));
        }
        for pair in breaks.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            // Limits from inside: a jump may lie at the ends themselves.
            let inset = (b - a) * INSET;
            let (start, end) = (curve(a + inset), curve(b - inset));
            // The curve's value at the break holds there; the other side of a jump begins right after it.
            let jumps = distance(curve(a), start) > TOLERANCE;
            push(if jumps { a.next_up() } else { a }, start);
            refine(&curve, (a, start), (b, end), DEPTH, &mut push);
            push(b, end);
            if distance(curve(b), end) > TOLERANCE {
                push(b, curve(b));
            }
        }
        Self::new(points)
    }

    /// Grey ramp: black and transparent at 0, white with opacity `opacity` at 1.
    pub fn grey_ramp(opacity: f64) -> Self {
        Self {
            points: vec![
                ControlPoint::new(0.0, [0.0; 3], 0.0),
                ControlPoint::new(1.0, [1.0; 3], opacity.clamp(0.0, 1.0)),
            ],
            range: None,
            nan: None,
            gradient: None,
        }
    }

    /// Control points in rising order.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// Colour and opacity `[r, g, b, a]` at display value `v`, clamped to [0, 1], or of NaN.
    pub fn evaluate(&self, v: f64) -> [f64; 4] {
        if v.is_nan() {
            return self.nan();
        }
        let v = v.clamp(0.0, 1.0);
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

    /// Largest opacity over the closed interval [`lo`, `hi`] of display values.
    pub fn max_opacity(&self, lo: f64, hi: f64) -> f64 {
        let ends = self.evaluate(lo)[3].max(self.evaluate(hi)[3]);
        // At a step, values just below approach the earlier point's opacity, so it counts.
        self.points
            .iter()
            .filter(|p| p.value >= lo && p.value <= hi)
            .fold(ends, |most, p| most.max(p.opacity))
    }

    /// Steepest change of opacity or colour per unit of v; infinite at a step.
    pub fn steepest_slope(&self) -> f64 {
        self.points.windows(2).fold(0.0, |most: f64, pair| {
            let (a, b): ([f64; 5], [f64; 5]) = (pair[0].into(), pair[1].into());
            let rise = (1..5).map(|c| (b[c] - a[c]).abs()).fold(0.0, f64::max);
            if rise == 0.0 { most } else { most.max(rise / (b[0] - a[0])) }
        })
    }

    /// Sets the opacity by gradient; `None` removes it.
    #[must_use]
    pub fn with_gradient(mut self, gradient: Option<GradientOpacity>) -> Self {
        self.gradient = gradient;
        self
    }

    /// Opacity by gradient, if set.
    pub fn gradient(&self) -> Option<&GradientOpacity> {
        self.gradient.as_ref()
    }

    /// Opacity by gradient, if it changes anything.
    pub fn gradient_opacity(&self) -> Option<&GradientOpacity> {
        self.gradient.as_ref().filter(|gradient| !gradient.is_neutral())
    }
}

/// Display values closer to 0 or 1 than this snap to it.
const SNAP: f64 = 1e-12;

/// Largest error of the approximation of a curve.
const TOLERANCE: f64 = 0.2 / 255.0;

/// Distance from a break at which one-sided limits are taken, as a fraction of the distance to the next break.
const INSET: f64 = 1e-9;

/// Most bisections between two breaks.
const DEPTH: u32 = 13;

/// Places where a piece of a curve is tested for straightness.
const LOOKS: [f64; 7] = [0.07, 0.21, 0.35, 0.5, 0.64, 0.79, 0.93];

fn distance(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
}

/// Pushes the points that `curve` needs strictly between `left` and `right`.
fn refine(
    curve: &impl Fn(f64) -> [f64; 4],
    left: (f64, [f64; 4]),
    right: (f64, [f64; 4]),
    depth: u32,
    push: &mut impl FnMut(f64, [f64; 4]),
) {
    let between = |f: f64| left.0 + f * (right.0 - left.0);
    let is_straight = LOOKS.into_iter().all(|f| {
        let line = std::array::from_fn(|c| left.1[c] + f * (right.1[c] - left.1[c]));
        distance(curve(between(f)), line) <= TOLERANCE
    });
    let v = between(0.5);
    if is_straight || depth == 0 || v <= left.0 || v >= right.0 {
        return;
    }
    let middle = (v, curve(v));
    refine(curve, left, middle, depth - 1, push);
    push(middle.0, middle.1);
    refine(curve, middle, right, depth - 1, push);
}

#[cfg(test)]
mod tests;
