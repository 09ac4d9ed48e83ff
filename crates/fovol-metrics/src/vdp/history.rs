//! Frames that temporal filters reach back to.

use std::collections::VecDeque;

/// One colour channel of the last frames, newest first.
#[derive(Debug, Clone, Default)]
pub(crate) struct History(VecDeque<Vec<f32>>);

impl History {
    /// Returns a plane to be filled and pushed: the oldest plane if the window of `length` frames is full, else a new
    /// one.
    pub fn recycle(&mut self, length: usize, pixels: usize) -> Vec<f32> {
        let old = if self.0.len() >= length { self.0.pop_back() } else { None };
        old.unwrap_or_else(|| vec![0.0; pixels])
    }

    pub fn push(&mut self, plane: Vec<f32>) {
        self.0.push_front(plane);
    }

    /// Plane of the present frame.
    ///
    /// # Panics
    /// Before the first frame.
    pub fn newest(&self) -> &[f32] {
        self.plane(0)
    }

    /// Plane of `back` frames ago. Frames before the first equal the first.
    fn plane(&self, back: usize) -> &[f32] {
        &self.0[back.min(self.0.len() - 1)]
    }

    /// Filters the pixels from `start` on with `N` filters, one into each of `out`. `taps[i]` holds their weights for
    /// the frame of `i` frames ago.
    pub fn filter<const N: usize>(&self, taps: &[[f32; N]], start: usize, mut out: [&mut [f32]; N]) {
        out.iter_mut().for_each(|out| out.fill(0.0));
        for (back, weights) in taps.iter().enumerate() {
            let plane = &self.plane(back)[start..];
            for (out, weight) in out.iter_mut().zip(weights) {
                for (sum, value) in out.iter_mut().zip(plane) {
                    *sum += weight * value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_frame_stands_for_those_before_it() {
        let mut history = History::default();
        let taps = [[0.5, 1.0], [0.3, 0.0], [0.2, -1.0]];
        for value in [1.0, 2.0, 3.0, 4.0] {
            let mut plane = history.recycle(taps.len(), 1);
            plane.fill(value);
            history.push(plane);
        }
        assert_eq!(history.0, [[4.0], [3.0], [2.0]]);
        let mut first = History::default();
        first.push(vec![5.0]);
        let (mut steady, mut change) = ([7.0], [7.0]);
        first.filter(&taps, 0, [&mut steady, &mut change]);
        assert!((steady[0] - 5.0).abs() < 1e-5 && change[0] == 0.0);
    }
}
