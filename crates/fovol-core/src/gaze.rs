use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Gaze as a function of the frame number, as fractions of the image from its top left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GazePath {
    /// One point for every frame.
    Fixed([f64; 2]),
    /// Piecewise-linear path through (frame, x, y); still before the first and after the last point.
    Scripted(Vec<[f64; 3]>),
    /// Smooth random walk over the middle of the picture that depends on the seed only.
    Wander {
        /// Random seed.
        seed: u64,
    },
}

impl Default for GazePath {
    fn default() -> Self {
        Self::Fixed([0.5, 0.5])
    }
}

/// Sine waves summed along each axis of the walk.
const WAVES: u64 = 4;

impl GazePath {
    /// Path through `stops` of (frame, x, y).
    ///
    /// # Errors
    /// No stops, numbers that are not finite, or frames that do not rise.
    pub fn scripted(stops: Vec<[f64; 3]>) -> Result<Self> {
        let rising = stops.windows(2).all(|pair| pair[1][0] > pair[0][0]);
        if stops.is_empty() || !rising || stops.iter().flatten().any(|x| !x.is_finite()) {
            return Err(Error::CameraPath(
                "a gaze path needs at least one [frame, x, y], with finite numbers and rising frames".into(),
            ));
        }
        Ok(Self::Scripted(stops))
    }

    /// Gaze at frame `i`.
    pub fn gaze(&self, i: u32) -> [f64; 2] {
        let frame = f64::from(i);
        match self {
            Self::Fixed(gaze) => *gaze,
            Self::Scripted(stops) => between(stops, frame),
            Self::Wander { seed } => [wander(*seed, 0, frame), wander(*seed, 1, frame)],
        }
    }
}

fn between(stops: &[[f64; 3]], frame: f64) -> [f64; 2] {
    let after = stops.partition_point(|s| s[0] <= frame);
    let left = stops[after.saturating_sub(1)];
    let right = stops[after.min(stops.len() - 1)];
    let length = right[0] - left[0];
    let f = if length > 0.0 { ((frame - left[0]) / length).clamp(0.0, 1.0) } else { 0.0 };
    [left[1] + f * (right[1] - left[1]), left[2] + f * (right[2] - left[2])]
}

/// Sum of sine waves with random periods of 1 to 6 seconds at 30 frames a second, within [0.1, 0.9].
fn wander(seed: u64, axis: u64, frame: f64) -> f64 {
    let sum: f64 = (0..WAVES)
        .map(|wave| {
            let period = 30.0 + 150.0 * random(seed, 4 * wave + axis);
            (TAU * (frame / period + random(seed, 4 * wave + axis + 2))).sin()
        })
        .sum();
    0.5 + 0.4 * sum / WAVES as f64
}

/// Random number in [0, 1) from (`seed`, `stream`): SplitMix64 (Steele, Lea, Flood 2014).
fn random(seed: u64, stream: u64) -> f64 {
    let mut z = seed.wrapping_add((stream + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_walk_is_smooth_seeded_and_stays_inside() {
        let walk = GazePath::Wander { seed: 7 };
        let mut travelled = 0.0;
        for i in 0..500 {
            let ([ax, ay], [bx, by]) = (walk.gaze(i), walk.gaze(i + 1));
            assert!((0.1..=0.9).contains(&ax) && (0.1..=0.9).contains(&ay));
            let step = (ax - bx).hypot(ay - by);
            assert!(step < 0.12, "a jump of {step} at {i}");
            travelled += step;
        }
        assert!(travelled > 1.0, "it hardly moves: {travelled}");
        assert_ne!(walk.gaze(3), GazePath::Wander { seed: 8 }.gaze(3));
    }

    #[test]
    fn scripts_are_linear_and_held() {
        let path = GazePath::scripted(vec![[0.0, 0.0, 0.0], [10.0, 1.0, 0.5]]).unwrap();
        assert_eq!(path.gaze(5), [0.5, 0.25]);
        assert_eq!(path.gaze(50), [1.0, 0.5]);
        assert!(GazePath::scripted(vec![[1.0, 0.0, 0.0], [1.0, 1.0, 1.0]]).is_err());
    }
}
