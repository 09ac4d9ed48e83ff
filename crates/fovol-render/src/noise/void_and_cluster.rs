//! Void-and-cluster ranks (Ulichney 1993), extended to time.
//!
//! As in spatio-temporal blue noise (Wolfe, Morrical, Akenine-Möller, Ramamoorthi 2022), two positions of the volume
//! repel each other if they share a frame or a pixel.
//!
//! Energies are whole numbers and ties are broken by a hash, so the ranks are the same on every machine,
//! bit for bit.

use super::pattern::{Pattern, Seek};
use super::random::hash;
use super::size::NoiseSize;
use fovol_core::stop;

/// The seed of the ranks that the program carries.
pub const STBN_SEED: u64 = 2022;

/// The ranks of a volume of noise, \[t\]\[y\]\[x\]: a permutation of 0…len − 1.
///
/// 128×128×64 takes seconds.
pub fn ranks(size: NoiseSize, seed: u64) -> Vec<u32> {
    let initial = relaxed(size, seed);
    let mut ranks = vec![0u32; size.len()];
    let count = initial.iter().filter(|&&on| on).count();
    // From the initial pattern down: the tightest cluster goes first and has the highest rank of these.
    let mut pattern = Pattern::new(size, seed, &initial, Seek::Cluster);
    rank_in_turn(&mut ranks, &mut pattern, (0..count).rev());
    // From the initial pattern up to half: the largest void goes first.
    let mut pattern = Pattern::new(size, seed, &initial, Seek::Void);
    rank_in_turn(&mut ranks, &mut pattern, count..size.len() / 2);
    // From half on the free positions are the minority: their tightest cluster goes first.
    let free: Vec<bool> = pattern.positions().iter().map(|on| !on).collect();
    let mut pattern = Pattern::new(size, seed, &free, Seek::Cluster);
    rank_in_turn(&mut ranks, &mut pattern, size.len() / 2..size.len());
    ranks
}

/// The memory that it takes to make the [`ranks`] of `size`, in bytes; somewhat less than the truth.
pub fn bytes_of_making_ranks(size: NoiseSize) -> u64 {
    // The order of positions, and the energies of two patterns.
    3 * (size.len() * size_of::<u64>()) as u64
}

/// Gives each rank of `order` to the position that `pattern` seeks at that time, and switches it.
fn rank_in_turn(ranks: &mut [u32], pattern: &mut Pattern, order: impl Iterator<Item = usize>) {
    for rank in order {
        stop::point();
        let at = pattern.best();
        pattern.switch(at);
        ranks[at] = rank as u32;
    }
}

/// The initial pattern: a tenth of the positions at random, moved from the tightest cluster to the largest
/// void until they are the same place.
///
/// This ends: a move never adds energy, and one that keeps it goes to a position that wins the tie, so no
/// pattern comes twice.
fn relaxed(size: NoiseSize, seed: u64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..size.len()).collect();
    order.sort_unstable_by_key(|&i| {
        stop::point();
        (hash(seed ^ 0x5EED, i as u64), i)
    });
    let mut on = vec![false; size.len()];
    order[..size.len() / 10].iter().for_each(|&i| on[i] = true);
    let mut clusters = Pattern::new(size, seed, &on, Seek::Cluster);
    let mut voids = Pattern::new(size, seed, &on, Seek::Void);
    loop {
        stop::point();
        let tightest = clusters.best();
        clusters.switch(tightest);
        voids.switch(tightest);
        let largest = voids.best();
        clusters.switch(largest);
        voids.switch(largest);
        if tightest == largest {
            return clusters.positions();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_a_permutation_that_the_seed_chooses() {
        let size = NoiseSize::new(16, 24, 8).unwrap();
        let mut sorted = ranks(size, 1);
        assert_ne!(sorted, ranks(size, 2));
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &r)| i == r as usize));
    }
}
