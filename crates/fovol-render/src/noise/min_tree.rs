/// Children of one node.
const FAN: usize = 16;

/// Numbers that change a few at a time, and where the smallest of them is: a tournament tree.
///
/// `levels[0]` are the numbers themselves; each further level has the smallest of every 16 of the level
/// below, up to one single number.
pub(super) struct MinTree {
    levels: Vec<Vec<u64>>,
    /// Nodes that [`Self::settle`] still has to renew, as indices into `levels[1]`.
    stale: Vec<usize>,
}

impl MinTree {
    /// The tree over `leaves`, of which there must be some.
    pub(super) fn new(leaves: Vec<u64>) -> Self {
        let mut levels = vec![leaves];
        loop {
            let below = &levels[levels.len() - 1];
            let above: Vec<u64> = below.chunks(FAN).map(smallest).collect();
            let is_root = above.len() == 1;
            levels.push(above);
            if is_root {
                return Self { levels, stale: Vec::new() };
            }
        }
    }

    /// The numbers.
    pub(super) fn leaves(&self) -> &[u64] {
        &self.levels[0]
    }

    /// Numbers `from`…`from + len − 1`, to be changed. [`Self::first_smallest`] knows of the changes after
    /// the next [`Self::settle`].
    pub(super) fn change(&mut self, from: usize, len: usize) -> &mut [u64] {
        self.stale.extend(from / FAN..(from + len).div_ceil(FAN));
        &mut self.levels[0][from..from + len]
    }

    /// Brings the tree up to date with its leaves.
    pub(super) fn settle(&mut self) {
        for level in 1..self.levels.len() {
            // Changes come in rising runs, so removing equal neighbours removes almost all repetitions.
            self.stale.dedup();
            let (lower, upper) = self.levels.split_at_mut(level);
            let (below, nodes) = (&lower[level - 1], &mut upper[0]);
            for node in &mut self.stale {
                let end = below.len().min((*node + 1) * FAN);
                nodes[*node] = smallest(&below[*node * FAN..end]);
                *node /= FAN;
            }
        }
        self.stale.clear();
    }

    /// Where the smallest number is; the first of equals.
    pub(super) fn first_smallest(&self) -> usize {
        let root = self.levels[self.levels.len() - 1][0];
        self.levels.iter().rev().skip(1).fold(0, |node, level| {
            let children = level[node * FAN..].iter().take(FAN);
            node * FAN + children.take_while(|&&child| child != root).count()
        })
    }
}

fn smallest(numbers: &[u64]) -> u64 {
    // Four at once: a single chain of comparisons would wait for itself.
    let mut least = [u64::MAX; 4];
    let mut fours = numbers.chunks_exact(4);
    for four in &mut fours {
        least = std::array::from_fn(|i| least[i].min(four[i]));
    }
    least.iter().chain(fours.remainder()).copied().fold(u64::MAX, u64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_smallest_is_found_after_any_changes(
            leaves in prop::collection::vec(0u64..50, 1..700),
            changes in prop::collection::vec((any::<prop::sample::Index>(), 0u64..50), 0..60),
        ) {
            let mut naive = leaves.clone();
            let mut tree = MinTree::new(leaves);
            for (at, value) in changes {
                let at = at.index(naive.len());
                naive[at] = value;
                tree.change(at, 1)[0] = value;
                tree.settle();
                let least = naive.iter().min().unwrap();
                prop_assert_eq!(tree.first_smallest(), naive.iter().position(|v| v == least).unwrap());
            }
        }
    }
}
