//! L_t: differences between frames.

use super::flow::{confidence, warp};
use super::pictures::{means, zeros};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use tch::Tensor;

/// Pairs of frames whose differences are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pairs {
    /// Each frame with all earlier frames, as in the paper.
    #[default]
    All,
    /// Each frame with its predecessor.
    Adjacent,
}

impl Pairs {
    /// Number of pairs in a clip of `length` frames.
    pub fn count(self, length: usize) -> usize {
        match self {
            Self::All => length * length.saturating_sub(1) / 2,
            Self::Adjacent => length.saturating_sub(1),
        }
    }

    /// First frame that frame `i` is compared with; the last is i − 1.
    fn first(self, i: usize) -> usize {
        match self {
            Self::All => 0,
            Self::Adjacent => i.saturating_sub(1),
        }
    }
}

/// Σ_i Σ_{j<i} mean |(y_i − y_j) − (r_i − r_j)| over the `pairs` with i in `frames`, per clip: \[N\]. Not divided by
/// the number of pairs.
///
/// `errors` are y − r of frames 0, 1, … up to the last of `frames` at least, \[N, 3, H, W\]. The sums over the parts
/// of a clip add up to the sum over the whole. Both frames of a pair receive gradients; detach the errors of frames
/// that should not.
///
/// # Panics
/// If there are fewer errors than frames, or none.
pub fn difference_sum(errors: &[Tensor], frames: Range<usize>, pairs: Pairs) -> Tensor {
    // The gradient of Σ|e_i − e_j| is a sum of signs, and its dot product with the errors is the sum itself. So none
    // of the T·(T − 1)/2 pairs has to stay in memory.
    let slopes = tch::no_grad(|| slopes(errors, frames, pairs));
    let terms = errors.iter().zip(slopes).filter_map(|(error, slope)| Some(means(&(error * slope?))));
    terms.reduce(|sum, term| sum + term).unwrap_or_else(|| zeros(&errors[0]))
}

/// Gradients of Σ|e_i − e_j| with respect to each of `errors`; `None` where zero.
fn slopes(errors: &[Tensor], frames: Range<usize>, pairs: Pairs) -> Vec<Option<Tensor>> {
    let mut slopes: Vec<Option<Tensor>> = errors.iter().map(|_| None).collect();
    for i in frames {
        for j in pairs.first(i)..i {
            let sign = (&errors[i] - &errors[j]).sign();
            for (at, slope) in [(j, -&sign), (i, sign)] {
                slopes[at] = Some(match slopes[at].take() {
                    Some(sum) => sum + slope,
                    None => slope,
                });
            }
        }
    }
    slopes
}

/// Mean |y_i − warp(y_{i−1})| of frames \[N, 3, H, W\], per clip: \[N\]. Pixels that are not confident count as 0.
///
/// `motion` \[N, 2, H, W\] points from frame i to frame i − 1 ([`warp`]); `confident` is \[N, 1, H, W\]. Both frames
/// receive gradients.
pub fn flow_difference(
    output: &Tensor,
    previous: &Tensor,
    motion: &Tensor,
    confident: Option<&Tensor>,
) -> Tensor {
    let difference = (output - warp(previous, motion)).abs();
    means(&confident.map_or_else(|| difference.shallow_clone(), |confident| &difference * confident))
}

/// Mask of [`confidence`] as 0 and 1, in the kind of `reference`.
pub(super) fn confident_pixels(reference: &Tensor, previous: &Tensor, motion: &Tensor, most: f64) -> Tensor {
    tch::no_grad(|| confidence(reference, previous, motion, most).to_kind(reference.kind()))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{EXACT, pair, pictures, value, worst_slope};
    use super::*;

    fn errors(length: usize) -> Vec<Tensor> {
        let error = |t: usize| {
            let (output, reference) = pair([2, 5, 6], t as f64);
            output - reference
        };
        (0..length).map(error).collect()
    }

    /// The formula of the paper, written out.
    fn literally(errors: &[Tensor], pairs: Pairs) -> Tensor {
        let mut sum = zeros(&errors[0]);
        for i in 1..errors.len() {
            for j in 0..i {
                if pairs == Pairs::All || j + 1 == i {
                    sum += means(&(&errors[i] - &errors[j]).abs());
                }
            }
        }
        sum
    }

    #[test]
    fn differences_are_those_of_the_paper_with_their_gradients() {
        let errors = errors(5);
        for pairs in [Pairs::All, Pairs::Adjacent] {
            let leaves =
                || errors.iter().map(|e| e.detach().copy().set_requires_grad(true)).collect::<Vec<_>>();
            let (ours, theirs) = (leaves(), leaves());
            let found = difference_sum(&ours, 0..5, pairs);
            let expected = literally(&theirs, pairs);
            assert!((value(&found) - value(&expected)).abs() < 1e-12);
            found.mean(None).backward();
            expected.mean(None).backward();
            for (a, b) in ours.iter().zip(&theirs) {
                assert!(a.grad().allclose(&b.grad(), 1e-12, 1e-12, false));
            }
            let worst = worst_slope(&errors, |errors| difference_sum(errors, 0..5, pairs));
            assert!(worst < 1e-6, "{worst:e}");
        }
        assert_eq!([Pairs::All.count(16), Pairs::Adjacent.count(16), Pairs::All.count(1)], [120, 15, 0]);
    }

    #[test]
    fn parts_of_a_clip_add_up() {
        let errors = errors(6);
        for pairs in [Pairs::All, Pairs::Adjacent] {
            let parts = [0..2, 2..3, 3..6].map(|part| value(&difference_sum(&errors, part, pairs)));
            let whole = value(&difference_sum(&errors, 0..6, pairs));
            assert!((parts.iter().sum::<f64>() - whole).abs() < 1e-12);
        }
        assert_eq!(value(&difference_sum(&errors, 0..1, Pairs::All)), 0.0);
    }

    #[test]
    fn the_flow_term_has_gradients_in_both_frames() {
        let [now, before] = [1.0, 2.0].map(|t| pictures([2, 6, 7], t, EXACT));
        let motion = pictures([2, 6, 7], 3.0, EXACT).narrow(1, 0, 2) * 4.0 - 2.1;
        let confident = pictures([2, 6, 7], 4.0, EXACT).narrow(1, 0, 1).gt(0.4).to_kind(now.kind());
        for confident in [None, Some(&confident)] {
            let worst = worst_slope(&[now.shallow_clone(), before.shallow_clone()], |frames| {
                flow_difference(&frames[0], &frames[1], &motion, confident)
            });
            assert!(worst < 1e-6, "{worst:e}");
        }
        let none = confident.zeros_like();
        assert_eq!(value(&flow_difference(&now, &before, &motion, Some(&none))), 0.0);
    }
}
