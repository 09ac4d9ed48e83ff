use crate::noise::{FrameNoise, Noise};
use crate::thresholds::Thresholds;
use bytemuck::{Pod, Zeroable};
use fovol_core::{Fovea, FrameSize};
use rayon::prelude::*;
use std::ops::Range;

/// The inputs of one frame's mask: a pixel is sampled where its density exceeds its noise.
#[derive(Debug, Clone, Copy)]
pub struct MaskSource<'a> {
    /// How densely pixels are sampled, and around which point.
    pub fovea: &'a Fovea,
    /// The noise that densities are compared with.
    pub noise: &'a Noise,
    /// The number of the frame.
    pub frame: u32,
}

/// One frame's mask, as its shader reads it. Twin of `MaskSettings` in shaders/mask.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MaskSettings {
    base_limit: u32,
    hashed: u32,
    fovea_from: [u32; 2],
    fovea_size: [u32; 2],
    seed: [u32; 2],
}

impl MaskSettings {
    /// The settings of a frame with this noise and these limits.
    pub fn new(noise: &FrameNoise<'_>, limits: &Limits) -> Self {
        let seed = noise.seed();
        let word = |shift: u32| seed.map_or(0, |seed| (seed >> shift) as u32);
        Self {
            base_limit: limits.base,
            hashed: u32::from(seed.is_some()),
            fovea_from: limits.from,
            fovea_size: limits.size,
            seed: [word(0), word(32)],
        }
    }
}

/// The number of ranks below the density of every pixel: one number outside a rectangle around the fovea, and one for
/// each pixel inside.
///
/// Densities are f64. Comparing integers instead makes the masks of GPU and CPU equal, bit for bit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    base: u32,
    from: [u32; 2],
    size: [u32; 2],
    values: Vec<u32>,
}

impl Limits {
    /// The limits of `fovea` among `levels` ranks.
    pub fn new(fovea: &Fovea, size: FrameSize, levels: u32) -> Self {
        let thresholds = Thresholds::new(fovea, size, levels);
        let rows: Vec<f64> = (0..size.height).map(|y| fovea.falloff_y(y, size)).collect();
        let base = thresholds.limits(0..1, 0.0).sum();
        // Limits rise with both factors: where the largest of one does not raise the other's, nothing does.
        let highest_row = rows.iter().copied().fold(0.0, f64::max);
        let columns = span(thresholds.limits(0..size.width as usize, highest_row).map(|limit| limit != base));
        let raised = |&falloff: &f64| thresholds.limits(columns.clone(), falloff).any(|limit| limit != base);
        let rows_raised = span(rows.iter().map(raised));
        let mut values = vec![0; columns.len() * rows_raised.len()];
        let parts = values.par_chunks_mut(columns.len().max(1)).zip(&rows[rows_raised.clone()]);
        parts.for_each(|(row, &falloff)| {
            row.iter_mut()
                .zip(thresholds.limits(columns.clone(), falloff))
                .for_each(|(to, limit)| *to = limit);
        });
        Self {
            base,
            from: [columns.start, rows_raised.start].map(|at| at as u32),
            size: [columns.len(), rows_raised.len()].map(|length| length as u32),
            values,
        }
    }

    /// The limits inside the rectangle, row by row.
    pub fn values(&self) -> &[u32] {
        &self.values
    }
}

/// The positions from the first that `holds` to the last.
fn span(holds: impl Iterator<Item = bool>) -> Range<usize> {
    let mut span = 0..0;
    for (i, _) in holds.enumerate().filter(|&(_, holds)| holds) {
        span = if span.is_empty() { i..i + 1 } else { span.start..i + 1 };
    }
    span
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::sampled;
    use crate::gpu::shader::MASK;
    use crate::noise::NoiseKind;
    use fovol_gpu::assert_twins;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn limits_decide_as_the_specification(
            w in 1u32..200, h in 1u32..60, base in 0.0f64..1.0, sigma in 0.0f64..0.3,
            gx in -0.2f64..1.2, gy in -0.2f64..1.2, t in 0u32..200, kind in 0usize..3,
        ) {
            let size = FrameSize::new(w, h).unwrap();
            let fovea = Fovea { base, sigma, gaze: [gx, gy] };
            let noise = Noise::new(NoiseKind::ALL[kind], 3);
            let frame = noise.frame(t);
            let limits = Limits::new(&fovea, size, frame.levels());
            for y in 0..h {
                for x in 0..w {
                    let at = [x.wrapping_sub(limits.from[0]), y.wrapping_sub(limits.from[1])];
                    let inside = at[0] < limits.size[0] && at[1] < limits.size[1];
                    let limit = if inside { limits.values[(at[1] * limits.size[0] + at[0]) as usize] } else { limits.base };
                    prop_assert_eq!(frame.rank(x, y) < limit, sampled(&fovea, size, &noise, t, [x, y]));
                }
            }
        }
    }

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(
            MASK,
            "MaskSettings",
            MaskSettings { base_limit, hashed, fovea_from, fovea_size, seed }
        );
    }

    #[test]
    fn a_frame_without_fovea_has_one_limit() {
        let fovea = Fovea { sigma: 0.0, ..Fovea::default() };
        let limits = Limits::new(&fovea, FrameSize::default(), 1 << 20);
        assert_eq!((limits.size, limits.values.len()), ([0, 0], 0));
        // The rectangle of a small fovea is a small part of the frame.
        let limits = Limits::new(&Fovea::default(), FrameSize::default(), 1 << 20);
        assert!(limits.values.len() * 10 < FrameSize::default().pixels());
    }
}
