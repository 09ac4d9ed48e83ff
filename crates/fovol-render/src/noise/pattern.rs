use super::kernel::{RADIUS, SPACE, TIME};
use super::min_tree::MinTree;
use super::random::hash;
use super::size::NoiseSize;
use fovol_core::stop;

/// Which extreme of the energy a [`Pattern`] finds: the tightest cluster or the largest void.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Seek {
    /// The position with the most energy among those that are on.
    Cluster,
    /// The position with the least energy among those that are off.
    Void,
}

/// Which positions of a volume are on, and which of them is the tightest cluster or the largest void.
///
/// Every position has one key, and the search takes the least key. Bit 63 is set where the position is not sought.
/// Bits 32…62 are its energy; for clusters, [`CEILING`] minus its energy. The low half is a hash that breaks ties.
pub(super) struct Pattern {
    size: NoiseSize,
    seek: Seek,
    keys: MinTree,
}

/// Bit 63 of a key: the position is not sought.
const BARRED: u64 = 1 << 63;
/// More than the energy of any position: all weights together are below 2²⁶.
const CEILING: u64 = 1 << 30;

impl Pattern {
    /// The pattern of the positions that are `on`, \[t\]\[y\]\[x\]. `seed` chooses between equals.
    pub(super) fn new(size: NoiseSize, seed: u64, on: &[bool], seek: Seek) -> Self {
        let key = |at: usize, on: bool| {
            let tie = hash(seed, at as u64) & 0xFFFF_FFFF;
            match (seek, on) {
                (Seek::Cluster, true) => CEILING << 32 | tie,
                (Seek::Cluster, false) => BARRED | CEILING << 32 | tie,
                (Seek::Void, true) => BARRED | tie,
                (Seek::Void, false) => tie,
            }
        };
        let keys = on.iter().enumerate().map(|(at, &on)| key(at, on)).collect();
        let mut pattern = Self { size, seek, keys: MinTree::new(keys) };
        for (at, _) in on.iter().enumerate().filter(|(_, on)| **on) {
            stop::point();
            pattern.spread(at, true);
        }
        pattern.keys.settle();
        pattern
    }

    /// The tightest cluster or the largest void; between equals the seed decides.
    pub(super) fn best(&self) -> usize {
        self.keys.first_smallest()
    }

    /// Whether position `at` is on.
    pub(super) fn is_on(&self, at: usize) -> bool {
        (self.keys.leaves()[at] & BARRED == 0) == (self.seek == Seek::Cluster)
    }

    /// Every position, whether it is on.
    pub(super) fn positions(&self) -> Vec<bool> {
        (0..self.size.len()).map(|at| self.is_on(at)).collect()
    }

    /// Switches position `at` to the other state.
    pub(super) fn switch(&mut self, at: usize) {
        let on = !self.is_on(at);
        self.keys.change(at, 1)[0] ^= BARRED;
        self.spread(at, on);
        self.keys.settle();
    }

    /// Adds the energy that position `at` spreads, or takes it away.
    fn spread(&mut self, at: usize, add: bool) {
        // Energies stay within their 31 bits, so neither sign carries into the neighbouring fields.
        let sign = if add == (self.seek == Seek::Void) { 1 << 32 } else { (1u64 << 32).wrapping_neg() };
        let NoiseSize { width, height, frames } = self.size;
        let (x, y, t) = (at % width, at / width % height, at / (width * height));
        for (dy, weights) in SPACE.iter().enumerate() {
            let row = (t * height + (y + height + dy - RADIUS) % height) * width;
            self.spread_row(row, x, weights, sign);
        }
        for dt in 1..=temporal_radius(frames) {
            for other in [(t + dt) % frames, (t + frames - dt) % frames] {
                let key = &mut self.keys.change((other * height + y) * width + x, 1)[0];
                *key = key.wrapping_add(TIME[dt].wrapping_mul(sign));
            }
        }
    }

    /// Spreads `weights` around column `x` of the row that starts at `row`.
    fn spread_row(&mut self, row: usize, x: usize, weights: &[u64; 2 * RADIUS + 1], sign: u64) {
        let width = self.size.width;
        let first = (x + width - RADIUS) % width;
        // The part before the right edge, then the part that comes in again on the left.
        let (before, after) = weights.split_at(weights.len().min(width - first));
        for (start, part) in [(row + first, before), (row, after)] {
            for (key, weight) in self.keys.change(start, part.len()).iter_mut().zip(part) {
                *key = key.wrapping_add(weight.wrapping_mul(sign));
            }
        }
    }
}

/// Frames further away than this would be reached both ways round.
fn temporal_radius(frames: usize) -> usize {
    RADIUS.min((frames - 1) / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The energy of position `at` by its definition.
    fn energy(size: NoiseSize, on: &[bool], at: usize) -> u64 {
        let place = |i: usize| (i % size.width, i / size.width % size.height, i / size.frame_len());
        let around = |a: usize, b: usize, n: usize| a.abs_diff(b).min(n - a.abs_diff(b));
        let (x, y, t) = place(at);
        (0..size.len())
            .filter(|&i| on[i])
            .map(|i| {
                let (u, v, s) = place(i);
                let [dx, dy, dt] =
                    [around(x, u, size.width), around(y, v, size.height), around(t, s, size.frames)];
                match (dx, dy, dt) {
                    (0..=RADIUS, 0..=RADIUS, 0) => SPACE[RADIUS + dy][RADIUS + dx],
                    (0, 0, 1..=RADIUS) => TIME[dt],
                    _ => 0,
                }
            })
            .sum()
    }

    #[test]
    fn the_best_is_that_of_the_definition_after_many_switches() {
        let size = NoiseSize::new(16, 18, 15).unwrap();
        for seek in [Seek::Cluster, Seek::Void] {
            let on: Vec<bool> = (0..size.len()).map(|i| hash(3, i as u64).is_multiple_of(7)).collect();
            let mut pattern = Pattern::new(size, 9, &on, seek);
            for _ in 0..200 {
                pattern.switch(pattern.best());
            }
            let on = pattern.positions();
            let best = pattern.best();
            let energies: Vec<u64> = (0..size.len()).map(|at| energy(size, &on, at)).collect();
            let sought = |at: &usize| on[*at] == (seek == Seek::Cluster);
            let all = (0..size.len()).filter(sought).map(|at| energies[at]);
            let expected = if seek == Seek::Cluster { all.max() } else { all.min() };
            assert!(sought(&best));
            assert_eq!(Some(energies[best]), expected);
        }
    }
}
