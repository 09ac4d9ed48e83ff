//! The choice between gather instructions and plain loads, by a measurement.

use crate::gather_method::GatherMethod;
use std::hint::black_box;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Choice of one instruction set.
pub(crate) struct Choice {
    is_hardware: AtomicBool,
    made: Once,
}

/// How [`super::Avx2`] gathers.
pub(crate) static AVX2: Choice = Choice::new();
/// How [`super::Avx512`] loads pairs of words.
pub(crate) static AVX512: Choice = Choice::new();

/// Words that are gathered from: as many as the table of a transfer function has, in the L1 cache.
const WORDS: usize = 4096;
/// Indices of one pass, which takes a few microseconds.
const INDICES: usize = 2048;
/// Passes of each method. Other programs disturb some of them; the fastest counts.
const PASSES: usize = 32;

/// Words and the indices to gather from them.
pub(crate) struct Sample {
    pub words: Vec<u32>,
    pub indices: Vec<i32>,
}

impl Sample {
    fn new() -> Self {
        let random = |i: usize| (i as u32).wrapping_mul(2_654_435_761) >> 8;
        let index = |i| (random(i) as usize % (WORDS - 1)) as i32;
        Self { words: (0..WORDS).map(random).collect(), indices: (0..INDICES).map(index).collect() }
    }
}

impl Choice {
    const fn new() -> Self {
        Self { is_hardware: AtomicBool::new(false), made: Once::new() }
    }

    /// Whether to use gather instructions. Before [`Self::make`] it is not.
    #[inline(always)]
    pub(crate) fn is_hardware(&self) -> bool {
        self.is_hardware.load(Ordering::Relaxed)
    }

    /// Chooses once: as the process was told, or the faster of two passes over a sample, which return a sum.
    #[inline]
    pub(crate) fn make(&self, hardware: fn(&Sample) -> u32, loads: fn(&Sample) -> u32) {
        if !self.made.is_completed() {
            self.made.call_once(|| {
                let method = GatherMethod::chosen().unwrap_or_else(|| faster(hardware, loads));
                self.is_hardware.store(method == GatherMethod::Hardware, Ordering::Relaxed);
            });
        }
    }
}

/// The faster method. Passes take turns, so that a busy machine disturbs both.
#[cold]
fn faster(hardware: fn(&Sample) -> u32, loads: fn(&Sample) -> u32) -> GatherMethod {
    let sample = Sample::new();
    let time = |pass: fn(&Sample) -> u32| {
        let start = Instant::now();
        black_box(pass(black_box(&sample)));
        start.elapsed()
    };
    let mut fastest = [Duration::MAX; 2];
    for _ in 0..PASSES {
        fastest = [fastest[0].min(time(hardware)), fastest[1].min(time(loads))];
    }
    if fastest[0] < fastest[1] { GatherMethod::Hardware } else { GatherMethod::Loads }
}

/// A sum of `lanes` that depends on their order.
pub(crate) fn in_order(lanes: &[i32]) -> u32 {
    lanes.iter().fold(0, |sum: u32, &lane| sum.rotate_left(5) ^ lane as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::x86::{avx2, avx512, features};

    #[test]
    fn both_methods_give_the_same_words() {
        let sample = Sample::new();
        // SAFETY: asked for first.
        unsafe {
            if features::has_avx2() {
                assert_eq!(avx2::gather::<true>(&sample), avx2::gather::<false>(&sample));
            }
            if features::has_avx512() {
                assert_eq!(avx512::gather::<true>(&sample), avx512::gather::<false>(&sample));
            }
        }
    }

    #[test]
    fn the_faster_method_is_chosen() {
        let busy =
            |sample: &Sample| sample.words.iter().fold(0, |sum: u32, word| (sum ^ word).wrapping_mul(3));
        assert_eq!(faster(|_| 0, busy), GatherMethod::Hardware);
        assert_eq!(faster(busy, |_| 0), GatherMethod::Loads);
    }
}
