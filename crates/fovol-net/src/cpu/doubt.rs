//! How far what was known before is believed, judged by the samples of this frame.

use super::map::Map;
use crate::plan::{DOUBT_EPSILON, DOUBT_SHARE};
use rayon::prelude::*;

/// The pictures that samples are compared with.
#[derive(Debug, Clone, Copy)]
pub struct Expected<'a> {
    /// What the samples of earlier frames give.
    pub prior: &'a Map,
    /// What those of this frame give; of it the means of squares of 2^`halvings` pixels are taken.
    pub fresh: &'a Map,
    /// How often the resolution is halved.
    pub halvings: u32,
}

/// Writes to `out` for each sample of `colour` the mean square by which it differs from the prior, that by which it
/// differs from the mean of its surroundings, less by how many more than two samples these have, and 0; all times `mask`.
pub fn doubt(colour: &Map, mask: &Map, expected: &Expected<'_>, out: &mut Map) {
    let edge = 1 << expected.halvings;
    let width = colour.width;
    out.resize([colour.height, width, 3]);
    out.data.par_chunks_mut(edge * width * 3).enumerate().for_each(|(band, rows)| {
        let y = band * edge;
        let means = means_of_squares(expected.fresh, y, edge);
        let shares = shares_of_squares(mask, y, edge);
        for (row, to) in rows.chunks_exact_mut(3 * width).enumerate() {
            let pixels = to.as_chunks_mut::<3>().0.iter_mut().zip(colour.row(y + row).as_chunks::<3>().0);
            let known = expected.prior.row(y + row).as_chunks::<3>().0.iter().zip(mask.row(y + row));
            for (x, ((to, colour), (prior, &m))) in pixels.zip(known).enumerate() {
                let squares = [prior, &means[x / edge]].map(|expected| mean_square(colour, expected));
                *to = [m * squares[0], m * squares[1] * shares[x / edge], 0.0];
            }
        }
    });
}

/// The means of the squares of `edge`² pixels of `picture` from row `y` on.
fn means_of_squares(picture: &Map, y: usize, edge: usize) -> Vec<[f32; 3]> {
    let mut means = vec![[0.0; 3]; picture.width / edge];
    for y in y..y + edge {
        for (x, pixel) in picture.row(y).as_chunks::<3>().0.iter().enumerate() {
            (0..3).for_each(|c| means[x / edge][c] += pixel[c]);
        }
    }
    let share = 1.0 / (edge * edge) as f32;
    means.iter_mut().flatten().for_each(|mean| *mean *= share);
    means
}

/// Two for the samples in each of the squares of `edge`² pixels from row `y` on, at most 1: the more there are, the
/// nearer the next one is, and the better this frame knows itself.
fn shares_of_squares(mask: &Map, y: usize, edge: usize) -> Vec<f32> {
    let mut counts = vec![0.0; mask.width / edge];
    for y in y..y + edge {
        mask.row(y).iter().enumerate().for_each(|(x, m)| counts[x / edge] += m);
    }
    counts.into_iter().map(|count| 2.0 / count.max(2.0)).collect()
}

fn mean_square(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 3.0
}

/// Writes `input` · v / (v + [`DOUBT_SHARE`] e) to `out`: e and v are what [`doubt`] gives, spread over the frame, the
/// latter with [`DOUBT_EPSILON`] more.
pub fn trust(input: &Map, doubts: &Map, out: &mut Map) {
    let c = input.channels;
    out.resize([input.height, input.width, c]);
    out.data.par_chunks_mut(input.width * c).enumerate().for_each(|(y, row)| {
        let pixels = row.chunks_exact_mut(c).zip(input.row(y).chunks_exact(c));
        for ((to, from), &[e, v, _]) in pixels.zip(doubts.row(y).as_chunks::<3>().0) {
            let v = v + DOUBT_EPSILON;
            let share = v / (v + DOUBT_SHARE * e);
            to.iter_mut().zip(from).for_each(|(to, &from)| *to = from * share);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_samples_agree_with_is_believed() {
        let picture = |value: f32| Map { data: vec![value; 8 * 8 * 3], height: 8, width: 8, channels: 3 };
        let mask = Map { data: vec![1.0; 64], height: 8, width: 8, channels: 1 };
        let mut colour = picture(0.5);
        // A chequerboard: what is around says little.
        colour.data.chunks_exact_mut(3).enumerate().for_each(|(i, p)| p.fill(((i + i / 8) % 2) as f32));
        let share = |prior: &Map| {
            let (mut doubts, mut out) = (Map::default(), Map::default());
            doubt(&colour, &mask, &Expected { prior, fresh: &colour, halvings: 3 }, &mut doubts);
            trust(&mask, &doubts, &mut out);
            out.data[0]
        };
        assert_eq!(share(&colour.clone()), 1.0);
        // Of 64 samples each has a thirty-second of the variance.
        assert!((share(&picture(0.5)) - 1.0 / 9.0).abs() < 1e-3);
        assert!(share(&picture(9.0)) < 0.001);
    }
}
