//! Tasks whose lengths differ.

use rayon::iter::{ParallelBridge, ParallelIterator};

/// Does `task` for each of `items`, and returns what it makes in their order.
///
/// Each thread takes the next item when it is done with one, so that none is left with a long row of them at the end. `memory` makes
/// what a thread uses again from item to item.
pub fn in_turn<I: Send, M, T: Send>(
    items: impl Iterator<Item = I> + Send,
    memory: impl Fn() -> M + Sync + Send,
    task: impl Fn(&mut M, I) -> T + Sync + Send,
) -> Vec<T> {
    let numbered = items.enumerate().par_bridge();
    let mut made: Vec<(usize, T)> =
        numbered.map_init(memory, |memory, (number, item)| (number, task(memory, item))).collect();
    made.sort_unstable_by_key(|(number, _)| *number);
    made.into_iter().map(|(_, made)| made).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        let squares = in_turn(0..1000, Vec::new, |seen, i| {
            seen.push(i);
            i * i
        });
        assert!(squares.into_iter().eq((0..1000).map(|i| i * i)));
    }
}
