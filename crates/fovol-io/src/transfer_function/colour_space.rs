//! The spaces that other programs interpolate colours in.

pub use super::cie::Colour;
use super::cie::{from_lab, to_lab};
use super::ciede2000;
use super::prolab::{from_prolab, to_prolab};

/// Where colours between two corners come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Display RGB.
    Rgb,
    /// Hue, saturation, value.
    Hsv {
        /// Whether hue goes the shorter way round, through red where need be, or straight from one number to the other.
        wraps: bool,
    },
    /// CIE L*a*b*, white D65.
    Lab,
    /// The way of the least CIEDE2000 distances through RGB.
    Ciede2000,
    /// ProLab, a projective space.
    ProLab,
    /// Polar L*a*b* through white (Moreland, "Diverging Color Maps for Scientific Visualization", 2009).
    Diverging,
    /// The right corner's colour.
    Step,
}

/// Colours between two corners.
#[derive(Debug, Clone)]
pub struct Segment {
    space: Interpolation,
    ends: [Colour; 2],
    /// Stops of the way with the share of it that lies before each, for [`Interpolation::Ciede2000`].
    stops: Vec<(f64, Colour)>,
}

impl Segment {
    /// The display colour at `f` of the segment, 0…1.
    pub fn colour(&self, f: f64) -> Colour {
        let [a, b] = self.ends;
        if self.space != Interpolation::Ciede2000 {
            return self.space.between(a, b, f);
        }
        let right = self.stops.partition_point(|stop| stop.0 < f).clamp(1, self.stops.len() - 1);
        let ((from, a), (to, b)) = (self.stops[right - 1], self.stops[right]);
        let f = if to > from { ((f - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        from_lab(mix(to_lab(a), to_lab(b), f))
    }

    /// Where in the segment colours turn sharply.
    pub fn bends(&self) -> Vec<f64> {
        match self.space {
            Interpolation::Diverging => vec![0.5],
            _ => self.stops.iter().map(|stop| stop.0).collect(),
        }
    }
}

impl Interpolation {
    /// ParaView's name of a space, hue wrapping round where `wraps`; none for names that are not known.
    pub fn named(name: &str, wraps: bool) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "rgb" => Self::Rgb,
            "hsv" => Self::Hsv { wraps },
            "hsvwrap" | "hsv wrap" => Self::Hsv { wraps: true },
            "lab" | "cielab" => Self::Lab,
            "lab/ciede2000" | "labciede2000" | "lab_ciede2000" | "ciede2000" => Self::Ciede2000,
            "prolab" => Self::ProLab,
            "diverging" => Self::Diverging,
            "step" => Self::Step,
            _ => return None,
        })
    }

    /// The colours between `a` and `b`.
    pub fn segment(self, a: Colour, b: Colour) -> Segment {
        let stops = if self == Self::Ciede2000 { ciede2000::way(a, b) } else { Vec::new() };
        Segment { space: self, ends: [a, b], stops }
    }

    /// The display colour at `f` between `a` and `b`.
    fn between(self, a: Colour, b: Colour, f: f64) -> Colour {
        match self {
            Self::Rgb | Self::Ciede2000 => mix(a, b, f),
            Self::Lab => from_lab(mix(to_lab(a), to_lab(b), f)),
            Self::ProLab => from_prolab(mix(to_prolab(a), to_prolab(b), f)),
            Self::Hsv { wraps } => {
                let (mut p, mut q) = (to_hsv(a), to_hsv(b));
                if wraps && (p[0] - q[0]).abs() > 0.5 {
                    if p[0] < q[0] { p[0] += 1.0 } else { q[0] += 1.0 }
                }
                from_hsv(mix(p, q, f))
            }
            Self::Diverging => diverging(a, b, f),
            Self::Step => b,
        }
    }
}

fn mix(a: Colour, b: Colour, f: f64) -> Colour {
    std::array::from_fn(|c| a[c] + f * (b[c] - a[c]))
}

fn to_hsv([r, g, b]: Colour) -> Colour {
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let range = high - low;
    let hue = if range == 0.0 {
        0.0
    } else if high == r {
        ((g - b) / range).rem_euclid(6.0) / 6.0
    } else if high == g {
        ((b - r) / range + 2.0) / 6.0
    } else {
        ((r - g) / range + 4.0) / 6.0
    };
    [hue, if high == 0.0 { 0.0 } else { range / high }, high]
}

fn from_hsv([h, s, v]: Colour) -> Colour {
    let channel = |n: f64| {
        let k = (n + h * 6.0).rem_euclid(6.0);
        v - v * s * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

/// L*a*b* in polar form: magnitude, saturation angle, hue angle.
fn to_msh(rgb: Colour) -> Colour {
    let [l, a, b] = to_lab(rgb);
    let m = (l * l + a * a + b * b).sqrt();
    let s = if m > 0.001 { (l / m).clamp(-1.0, 1.0).acos() } else { 0.0 };
    [m, s, if s > 0.001 { b.atan2(a) } else { 0.0 }]
}

fn from_msh([m, s, h]: Colour) -> Colour {
    from_lab([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

fn diverging(a: Colour, b: Colour, f: f64) -> Colour {
    let (mut p, mut q) = (to_msh(a), to_msh(b));
    let mut f = f;
    let apart = (p[2] - q[2]).abs();
    let apart = apart.min(std::f64::consts::TAU - apart);
    if p[1] > 0.05 && q[1] > 0.05 && apart > std::f64::consts::FRAC_PI_3 {
        // Two saturated colours of different hue: through white.
        let middle = [p[0].max(q[0]).max(88.0), 0.0, 0.0];
        if f < 0.5 {
            (q, f) = (middle, 2.0 * f);
        } else {
            (p, f) = (middle, 2.0 * f - 1.0);
        }
    }
    if p[1] < 0.05 && q[1] > 0.05 {
        p[2] = spun(q, p[0]);
    } else if q[1] < 0.05 && p[1] > 0.05 {
        q[2] = spun(p, q[0]);
    } else if (p[2] - q[2]).abs() > std::f64::consts::PI {
        // Hues on both sides of the cut at ±π are neighbours.
        q[2] += std::f64::consts::TAU.copysign(p[2] - q[2]);
    }
    from_msh(mix(p, q, f))
}

/// The hue that an unsaturated colour of magnitude `m` takes on the way from `saturated`.
fn spun([m0, s, h]: Colour, m: f64) -> f64 {
    if m0 >= m {
        return h;
    }
    let spin = s * (m * m - m0 * m0).sqrt() / (m0 * s.sin());
    if h > -std::f64::consts::FRAC_PI_3 { h + spin } else { h - spin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ends_are_met_in_every_space(a in prop::array::uniform3(0.0f64..=1.0), b in prop::array::uniform3(0.0f64..=1.0)) {
            for space in [
                Interpolation::Rgb,
                Interpolation::Hsv { wraps: true },
                Interpolation::Hsv { wraps: false },
                Interpolation::Lab,
                Interpolation::ProLab,
                Interpolation::Diverging,
            ] {
                let (start, end) = (space.segment(a, b).colour(0.0), space.segment(a, b).colour(1.0));
                // Near white, Moreland's space turns the hue of an end towards the other one's: a move of at
                // most 2 M sin 0.05 in L*a*b*.
                let is_turned = |colour: Colour| space == Interpolation::Diverging && to_msh(colour)[1] < 0.05;
                let near = |found: Colour, wanted: Colour| {
                    let tolerance = if is_turned(wanted) { 0.12 } else { 2e-3 };
                    (0..3).all(|c| (found[c] - wanted[c]).abs() < tolerance)
                };
                prop_assert!(near(start, a) && near(end, b), "{space:?} {start:?} {end:?}");
            }
        }
    }
}
