//! Contrast sensitivity: a table of castleCSF (Ashraf, Mantiuk, Chapiro and Wuerger, "castleCSF: A contrast
//! sensitivity function of color, area, spatiotemporal frequency, luminance and eccentricity", JOV 24(4), 2024).
//!
//! The table is that of the published metric; `assets/castle_csf` says where it comes from.

use std::f32::consts::LOG2_10;
use std::sync::OnceLock;

/// Nodes along each axis of the table.
const NODES: usize = 32;

/// log₁₀ sensitivities as f32, little end first. Outermost are the channels (achromatic, red-green, violet-yellow,
/// achromatic at 5 Hz), then luminance, then frequency.
const BYTES: &[u8; 4 * NODES * NODES * 4] = include_bytes!("../../assets/castle_csf/sensitivity.f32");

/// Luminance of the first and last node, in cd/m²; nodes are evenly spaced in its logarithm.
const LUMINANCE: [f32; 2] = [0.005, 1e4];

/// Frequency of the first and last node, in cycles per degree; nodes are evenly spaced in its logarithm.
const FREQUENCY: [f32; 2] = [0.1, 64.0];

/// Gain of the sensitivity over the model in dB; fitted to judgements.
const GAIN: f32 = -0.279_742_33;

/// log₂ sensitivity at one frequency, by background luminance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sensitivity(Vec<[f32; 4]>);

impl Sensitivity {
    /// Sensitivity at `rho` cycles per degree. Frequencies beyond the table continue its outermost slopes.
    pub fn new(rho: f64) -> Self {
        let step = (FREQUENCY[1] / FREQUENCY[0]).log2() / (NODES - 1) as f32;
        let along = (rho as f32 / FREQUENCY[0]).log2() / step;
        let below = (along.max(0.0) as usize).min(NODES - 2);
        let part = along - below as f32;
        let at = |channel: usize, luminance: usize| {
            let row = &table()[(channel * NODES + luminance) * NODES..];
            (row[below] + (row[below + 1] - row[below]) * part + GAIN / 20.0) * LOG2_10
        };
        Self((0..NODES).map(|luminance| [0, 1, 2, 3].map(|channel| at(channel, luminance))).collect())
    }

    /// log₂ sensitivity of the four channels on a background of log₂ luminance `log_light`; constant beyond the table.
    #[inline(always)]
    pub fn at(&self, log_light: f32) -> [f32; 4] {
        let low = LUMINANCE[0].log2();
        let scale = (NODES - 1) as f32 / (LUMINANCE[1].log2() - low);
        // The maximum comes first, so that NaN maps to the lowest node.
        let along = ((log_light - low) * scale).max(0.0).min((NODES - 1) as f32);
        let below = (along as usize).min(NODES - 2);
        let part = along - below as f32;
        let (a, b) = (self.0[below], self.0[below + 1]);
        [0, 1, 2, 3].map(|channel| a[channel] + (b[channel] - a[channel]) * part)
    }
}

/// The table's values.
fn table() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| BYTES.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cycles per degree, luminance in cd/m², and the published program's sensitivities.
    const SPOTS: [(f64, f32, [f32; 4]); 6] = [
        (37.7012, 50.0, [5.65761, 18.1171, 3.77449, 6.04378]),
        (4.0, 100.0, [302.094, 184.636, 39.0803, 233.347]),
        (1.0, 0.3, [55.799, 38.0136, 11.2159, 27.0817]),
        (0.1, 12.0, [11.7047, 107.629, 21.7035, 43.1124]),
        (0.5, 2000.0, [72.7611, 369.367, 88.4164, 1092.87]),
        (70.0, 100.0, [1.08342, 10.0004, 2.10736, 2.26868]),
    ];

    #[test]
    fn sensitivities_are_those_of_the_published_program() {
        for (rho, light, expected) in SPOTS {
            let found = Sensitivity::new(rho).at(light.log2()).map(f32::exp2);
            assert!(
                found.iter().zip(expected).all(|(f, e)| (f / e - 1.0).abs() < 1e-4),
                "{found:?} {expected:?}"
            );
        }
    }

    #[test]
    fn beyond_its_luminances_the_table_stays_constant() {
        let slice = Sensitivity::new(2.0);
        assert_eq!(slice.at(-60.0), slice.at(0.005_f32.log2()));
        assert_eq!(slice.at(60.0), slice.at(1e4_f32.log2()));
        assert!(slice.at(f32::NAN)[0].is_finite());
    }
}
