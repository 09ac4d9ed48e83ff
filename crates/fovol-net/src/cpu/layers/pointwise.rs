//! Pointwise layers. They work in place, and several layers run one after the other on each row.

use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::samples::Samples;
use fovol_simd::{Simd, SimdOp};
use rayon::prelude::*;

/// Pointwise operation on a picture x.
#[derive(Debug, Clone, Copy)]
pub enum Change<'a> {
    /// x + more.
    Add(&'a Tensor),
    /// x + this picture, unfolded by [`depth_to_space`](crate::cpu::layers::reshape::depth_to_space).
    AddUnfolded(&'a Tensor),
    /// mask · colour + (1 − mask) · x.
    Bypass { colour: &'a Tensor, mask: &'a Tensor },
    /// mask · colour + (1 − mask) · x, with colour and mask in one map, the mask last.
    Keep(&'a Tensor),
    /// Replaces x by samples at their pixels.
    Sampled(&'a Samples),
    /// factor · x + offset.
    Scale { factor: f32, offset: f32 },
    /// Clamps x to 0…1.
    Clamp,
}

/// Applies `changes` to `picture`, in order.
pub fn change(changes: &[Change<'_>], picture: &mut Tensor) {
    let (width, channels) = (picture.width, picture.channels);
    let rows = picture.data.par_chunks_mut(width * channels).enumerate();
    rows.for_each(|(y, row)| change_row(changes, y, channels, row));
}

/// Applies `changes` to row `y` of a picture.
pub fn change_row(changes: &[Change<'_>], y: usize, channels: usize, row: &mut [f32]) {
    for change in changes {
        Simd::best().vectorised(RowChange { change, y, channels, row: &mut *row });
    }
}

struct RowChange<'a> {
    change: &'a Change<'a>,
    y: usize,
    channels: usize,
    row: &'a mut [f32],
}

impl SimdOp for RowChange<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { change, y, channels, row } = self;
        match *change {
            Change::Add(more) => row.iter_mut().zip(more.row(y)).for_each(|(to, v)| *to += v),
            Change::AddUnfolded(more) => add_unfolded(more, y, channels, row),
            Change::Bypass { colour, mask } => {
                let pixels = row.chunks_exact_mut(channels).zip(colour.row(y).chunks_exact(channels));
                for ((to, colour), &m) in pixels.zip(mask.row(y)) {
                    to.iter_mut().zip(colour).for_each(|(to, c)| *to = m * c + (1.0 - m) * *to);
                }
            }
            Change::Keep(known) => {
                let pixels = row.as_chunks_mut::<3>().0.iter_mut().zip(known.row(y).as_chunks::<4>().0);
                for (to, &[r, g, b, m]) in pixels {
                    *to = [m * r + (1.0 - m) * to[0], m * g + (1.0 - m) * to[1], m * b + (1.0 - m) * to[2]];
                }
            }
            Change::Sampled(samples) => {
                let pixels = row.as_chunks_mut::<3>().0;
                samples.row(y).iter().for_each(|sample| pixels[sample.x as usize] = sample.colour);
            }
            Change::Scale { factor, offset } => row.iter_mut().for_each(|to| *to = *to * factor + offset),
            // NaN becomes 0.
            Change::Clamp => row.iter_mut().for_each(|to| *to = if *to > 0.0 { to.min(1.0) } else { 0.0 }),
        }
    }
}

#[inline(always)]
fn add_unfolded(more: &Tensor, y: usize, channels: usize, row: &mut [f32]) {
    let cells = row.chunks_exact_mut(2 * channels).zip(more.row(y / 2).chunks_exact(4 * channels));
    let above = 2 * (y % 2);
    for (to, from) in cells {
        for k in 0..channels {
            to[k] += from[4 * k + above];
            to[channels + k] += from[4 * k + above + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::layers::reshape;
    use proptest::prelude::*;

    fn random(seed: u64, [height, width, channels]: [usize; 3]) -> Tensor {
        let parameter =
            crate::plan::Parameter { name: "x".into(), shape: vec![height * width * channels, 5] };
        let mut map = Tensor::zeros(height, width, channels);
        let values = crate::weights::random::values(&parameter, seed);
        map.data.iter_mut().zip(values).for_each(|(to, v)| *to = v);
        map
    }

    proptest! {
        #[test]
        fn folded_and_joined_maps_give_what_apart_they_would(
            half in (1usize..6, 1usize..20), seed in 0u64..1000,
        ) {
            let [height, width] = [2 * half.0, 2 * half.1];
            let picture = random(seed, [height, width, 3]);
            let folded = random(seed + 1, [half.0, half.1, 12]);
            let (colour, mut mask) = (random(seed + 2, [height, width, 3]), random(seed + 3, [height, width, 1]));
            mask.data.iter_mut().for_each(|v| *v = f32::from(u8::from(*v > 0.0)));
            let [mut unfolded, mut known] = [Tensor::default(), Tensor::default()];
            reshape::depth_to_space(&folded, &mut unfolded);
            reshape::join(&colour, &mask, &mut known);
            let [mut a, mut b] = [picture.clone(), picture];
            change(&[Change::Add(&unfolded)], &mut a);
            change(&[Change::Bypass { colour: &colour, mask: &mask }], &mut a);
            change(&[Change::Clamp], &mut a);
            change(&[Change::AddUnfolded(&folded), Change::Keep(&known), Change::Clamp], &mut b);
            prop_assert_eq!(a, b);
        }
    }
}
