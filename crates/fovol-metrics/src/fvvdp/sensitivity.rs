//! Contrast sensitivity of the eye: Mantiuk et al., "FovVideoVDP: A visible difference predictor for wide
//! field-of-view video" (ACM TOG 40(4), 2021), section 4.4.
//!
//! A spatial and chromatic model gives the detection of static patterns. The spatio-velocity model of Laird et al.
//! (2006), after Daly (1998), adds the effect of flicker, and cortical magnification the effect of eccentricity.

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Size of a detected pattern (standard deviation), in cycles.
const CYCLES: f64 = 1.5;

/// Temporal frequencies of the sustained and the transient channel, in Hz.
pub(crate) const TEMPORAL: [f64; 2] = [0.0, 5.0];

/// Gain of the sensitivity over the model, as an exponent of 10; fitted to judgements (version 1.2).
const GAIN: f64 = 16.2596 / 20.0;

/// Lower bound of sensitivities.
const FLOOR: f64 = 1e-4;

/// XYZ to the responses of L, M and S cones, by rows; S has its own unit.
const CONES: [[f64; 3]; 3] = [
    [0.187596, 0.585169, -0.0263843],
    [-0.133397, 0.405506, 0.0345021],
    [0.000244379, -0.000542996, 0.0194068],
];

/// XYZ of white (D65) of luminance 1.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.0888];

/// Change in L, M and S of an achromatic pattern.
const PATTERN: [f64; 3] = [0.698, 0.302, 0.019613];

/// Cone contrasts to the mechanisms: achromatic, red-green, violet-yellow.
const MECHANISMS: [[f64; 3]; 3] =
    [[1.0, 0.256197, 6.42e-7], [1.0, -0.933541, 0.00373304], [-0.00130319, -1.1504, 1.0]];

/// Fit of one mechanism: a log-parabola over frequency, and spatial integration over area.
struct Mechanism {
    /// Frequency of the peak in cycles a degree.
    peak: f64,
    bandwidth: f64,
    /// Whether the sensitivity stays constant below the peak.
    low_pass: bool,
    gamma: f64,
    critical_area: f64,
}

impl Mechanism {
    /// Sensitivity at `rho` cycles per degree for a pattern of `area` square degrees; `highest` is the sensitivity at
    /// the peak.
    fn sensitivity(&self, highest: f64, rho: f64, area: f64) -> f64 {
        let octaves = rho.log10() - self.peak.log10();
        let falls = !self.low_pass || rho >= self.peak;
        let parabola = if falls { octaves * octaves / (0.5 * self.bandwidth.exp2()) } else { 0.0 };
        let seen = area.powf(self.gamma) * rho * rho;
        highest * 10_f64.powf(-parabola) * (seen / (self.critical_area + 0.65 * area + seen)).sqrt()
    }
}

/// Contrast sensitivity without the gain.
///
/// `rho` is in cycles per degree, `omega` in Hz, `luminance` in cd/m², `eccentricity` in degrees.
pub(crate) fn sensitivity(rho: f64, omega: f64, luminance: f64, eccentricity: f64) -> f64 {
    // Cortical magnification makes patterns appear smaller away from the fovea: Virsu and Rovamo (1979).
    let magnification = (3.67 / (eccentricity + 3.67)).powf(0.604562);
    let rho = rho / magnification;
    let area = PI * (CYCLES / rho).powi(2);
    spatial(rho, area, luminance) * flicker(rho, omega) / (flicker(rho, 0.0) + 1e-5)
}

/// Spatial and chromatic part, for an achromatic pattern on grey.
fn spatial(rho: f64, area: f64, luminance: f64) -> f64 {
    let background = CONES.map(|row| luminance * dot(row, WHITE));
    let contrast: [f64; 3] = std::array::from_fn(|i| PATTERN[i] / background[i]);
    // The fits are functions of the sum of L and M.
    let y = background[0] + background[1];
    let found = mechanisms(y, rho, area);
    let heard: f64 = (0..3).map(|i| (dot(MECHANISMS[i], contrast) * found[i]).powi(2)).sum();
    heard.sqrt() * 3_f64.sqrt() / dot(contrast, contrast).sqrt()
}

/// Sensitivities of the three mechanisms on a background of `y`, the sum of L and M.
fn mechanisms(y: f64, rho: f64, area: f64) -> [f64; 3] {
    let achromatic = Mechanism {
        peak: 2.3021 * (1.0 + 3317.45 / y).powf(-0.186215),
        bandwidth: 1.07516,
        low_pass: false,
        gamma: 1.1107,
        critical_area: 52.9768,
    };
    let red_green = Mechanism {
        peak: 0.122699,
        bandwidth: 2.70669,
        low_pass: true,
        gamma: 1.72903,
        critical_area: 1.38437,
    };
    let violet_yellow = Mechanism {
        peak: 7.1099e-8,
        bandwidth: 5.3416,
        low_pass: true,
        gamma: 1.47263,
        critical_area: 0.282573,
    };
    let highest = [
        356404.0 * (1.0 + 6.2726 / y).powf(-0.320031) * (1.0 - (1.0 + 895943.0 / y).powf(-7.77919e-5)),
        423.978 * (1.0 + 15.4032 / y).powf(-0.50343),
        11811.9 * (1.0 + 196.342 / y).powf(-0.339396),
    ];
    [
        achromatic.sensitivity(highest[0], rho, area),
        red_green.sensitivity(highest[1], rho, area),
        violet_yellow.sensitivity(highest[2], rho, area),
    ]
}

/// Sensitivity to a pattern of `rho` cycles per degree that flickers at `omega` Hz, modelled as motion.
fn flicker(rho: f64, omega: f64) -> f64 {
    let c = [0.6329, 0.8404, 0.7986];
    let velocity = (omega / rho).max(0.1);
    let k = 6.1 + 7.3 * (c[2] * velocity / 3.0).log10().abs().powi(3);
    let highest = 45.9 / (c[2] * velocity + 2.0);
    let cycles = 2.0 * PI * c[1] * rho;
    k * c[0] * c[1] * c[2] * velocity * cycles * cycles * (-2.0 * cycles / highest).exp()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Nodes along each axis of the table.
///
/// Version 1.2 of the metric uses 32. The formula lies up to 1 % above the interpolated table, and the metric's gain
/// and pooling are fitted to the table. A finer table would give differences up to 1 % larger in JOD than the
/// published program.
const NODES: usize = 32;

/// Axis of the table: node `i` lies at `low + i / scale`.
#[derive(Debug, Clone, Copy)]
struct Axis {
    low: f32,
    scale: f32,
}

impl Axis {
    fn new(low: f64, high: f64) -> Self {
        Self { low: low as f32, scale: ((NODES - 1) as f64 / (high - low)) as f32 }
    }

    fn node(self, i: usize) -> f64 {
        f64::from(self.low) + i as f64 / f64::from(self.scale)
    }

    /// Node below `value` and the fraction towards the next node; constant beyond the ends.
    #[inline(always)]
    fn at(self, value: f32) -> (usize, f32) {
        // The maximum comes first, so that NaN maps to the lowest node.
        let t = ((value - self.low) * self.scale).max(0.0).min((NODES - 1) as f32);
        let i = (t as usize).min(NODES - 2);
        (i, t - i as f32)
    }
}

/// Table of log₂ sensitivity, including the gain, for both temporal channels. Its axes are log₂ frequency, log₂
/// luminance and the square root of eccentricity.
pub(crate) struct SensitivityTable {
    frequency: Axis,
    luminance: Axis,
    eccentricity: Axis,
    /// Frequency outermost, eccentricity innermost.
    nodes: Vec<[f32; 2]>,
}

impl SensitivityTable {
    /// The shared table, made on first use in some 20 ms.
    pub fn shared() -> &'static Self {
        static TABLE: OnceLock<SensitivityTable> = OnceLock::new();
        TABLE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let frequency = Axis::new(-4.0, 6.0);
        let luminance = Axis::new(1e-3_f64.log2(), 1e4_f64.log2());
        let eccentricity = Axis::new(0.0, 120_f64.sqrt());
        let gain = GAIN * 10_f64.log2();
        let mut nodes = Vec::with_capacity(NODES * NODES * NODES);
        for i in 0..NODES * NODES * NODES {
            let rho = frequency.node(i / (NODES * NODES)).exp2();
            let light = luminance.node(i / NODES % NODES).exp2();
            let away = eccentricity.node(i % NODES).powi(2);
            nodes.push(
                TEMPORAL.map(|omega| (sensitivity(rho, omega, light, away).max(FLOOR).log2() + gain) as f32),
            );
        }
        Self { frequency, luminance, eccentricity, nodes }
    }

    /// Slice of the table at one frequency (log₂ of cycles per degree) in the fovea.
    pub fn foveal(&self, log_rho: f32) -> FovealSensitivity {
        let (i, part) = self.frequency.at(log_rho);
        let node = |i: usize, j: usize| self.nodes[(i * NODES + j) * NODES];
        let nodes = (0..NODES).map(|j| mix(node(i, j), node(i + 1, j), part)).collect();
        FovealSensitivity { luminance: self.luminance, nodes }
    }

    /// log₂ sensitivity of both channels, interpolated. `log_rho` and `log_light` are log₂ of frequency and
    /// luminance, `root` is the square root of the eccentricity in degrees.
    #[inline(always)]
    pub fn log_sensitivity(&self, log_rho: f32, log_light: f32, root: f32) -> [f32; 2] {
        let (i, along_i) = self.frequency.at(log_rho);
        let (j, along_j) = self.luminance.at(log_light);
        let (k, along_k) = self.eccentricity.at(root);
        let line = |i: usize, j: usize| {
            let first = (i * NODES + j) * NODES + k;
            mix(self.nodes[first], self.nodes[first + 1], along_k)
        };
        let near = mix(line(i, j), line(i, j + 1), along_j);
        let far = mix(line(i + 1, j), line(i + 1, j + 1), along_j);
        mix(near, far, along_i)
    }
}

/// log₂ sensitivity at one frequency in the fovea.
pub(crate) struct FovealSensitivity {
    luminance: Axis,
    nodes: Vec<[f32; 2]>,
}

impl FovealSensitivity {
    /// log₂ sensitivity of both channels on a background of log₂ luminance `log_light`.
    #[inline(always)]
    pub fn log_sensitivity(&self, log_light: f32) -> [f32; 2] {
        let (j, part) = self.luminance.at(log_light);
        mix(self.nodes[j], self.nodes[j + 1], part)
    }
}

#[inline(always)]
fn mix(a: [f32; 2], b: [f32; 2], part: f32) -> [f32; 2] {
    [a[0] + (b[0] - a[0]) * part, a[1] + (b[1] - a[1]) * part]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frequency, flicker, luminance, eccentricity, and the published table's value there.
    const SPOTS: [([f64; 4], f64); 6] = [
        ([4.0, 0.0, 100.0, 0.0], 56.08),
        ([1.0, 0.0, 100.0, 0.0], 111.28),
        ([16.0, 0.0, 100.0, 0.0], 5.651),
        ([4.0, 0.0, 1.0, 0.0], 14.755),
        ([4.0, 0.0, 100.0, 10.0], 18.225),
        ([4.0, 5.0, 100.0, 0.0], 60.187),
    ];

    #[test]
    fn the_formula_is_within_one_per_cent_of_the_published_values() {
        for ([rho, omega, light, away], expected) in SPOTS {
            let found = sensitivity(rho, omega, light, away);
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        }
    }

    #[test]
    fn the_table_is_the_published_one() {
        let table = SensitivityTable::shared();
        for ([rho, omega, light, away], expected) in SPOTS {
            let (rho, light) = (rho.log2() as f32, light.log2() as f32);
            let channel = usize::from(omega > 0.0);
            let found = table.log_sensitivity(rho, light, away.sqrt() as f32)[channel];
            let found = f64::from(found).exp2() / 10_f64.powf(GAIN);
            assert!((found / expected - 1.0).abs() < 2e-4, "{found} {expected}");
            if away == 0.0 {
                let foveal = table.foveal(rho).log_sensitivity(light)[channel];
                assert!((f64::from(foveal).exp2() / 10_f64.powf(GAIN) / expected - 1.0).abs() < 2e-4);
            }
        }
    }

    #[test]
    fn beyond_its_ends_the_table_stays_constant() {
        let table = SensitivityTable::shared();
        assert_eq!(table.log_sensitivity(9.0, 3.0, 0.0), table.log_sensitivity(6.0, 3.0, 0.0));
        assert_eq!(table.log_sensitivity(1.0, -99.0, 99.0), table.log_sensitivity(1.0, -9.97, 10.96));
        assert!(table.log_sensitivity(f32::NAN, f32::INFINITY, 0.0)[0].is_finite());
    }
}
