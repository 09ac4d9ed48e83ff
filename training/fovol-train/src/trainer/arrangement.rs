//! Distribution of a step over CPU threads: clips of a batch side by side, or several threads per clip.
//!
//! Steps of few pixels lose more by waking threads than they gain. For a clip of 12 frames of 128² on two cores, one
//! thread is twice as fast as two.

use crate::Result;
use std::fmt;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// Steps longer than this end the search.
const LONG: Duration = Duration::from_secs(10);
/// Timed steps with each arrangement; the first one warms up.
const TRIES: usize = 3;

/// Number of parts of a batch that run at once, and threads of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrangement {
    /// Parts of a batch, at least 1.
    pub side_by_side: usize,
    /// Threads of each part, at least 1.
    pub threads: usize,
}

impl Arrangement {
    /// Whether `processors` threads suffice.
    pub(super) fn fits(self, processors: usize) -> bool {
        self.side_by_side * self.threads <= processors
    }

    /// Arrangements worth trying with `processors` threads and `clips` clips at once, widest first.
    pub(super) fn candidates(processors: usize, clips: usize) -> Vec<Self> {
        let widest = processors.min(clips).max(1);
        let mut found = Vec::new();
        for side_by_side in if widest > 1 { vec![widest, 1] } else { vec![1] } {
            let most = (processors / side_by_side).max(1);
            let halved = std::iter::successors(Some(most), |&n| (n > 1).then_some(n / 2));
            found.extend(halved.map(|threads| Self { side_by_side, threads }));
        }
        found
    }

    /// Finds the fastest of `candidates`, of which there must be one, by timing `step`. The first wins if its steps
    /// are long.
    ///
    /// # Errors
    /// Errors of `step`.
    pub(super) fn quickest(candidates: &[Self], mut step: impl FnMut(Self) -> Result<()>) -> Result<Self> {
        let mut quickest = (candidates[0], Duration::MAX);
        for &candidate in candidates {
            let time = least_time(|| step(candidate))?;
            if time < quickest.1 {
                quickest = (candidate, time);
            }
            if time > LONG {
                break;
            }
        }
        Ok(quickest.0)
    }
}

/// Shortest time of several steps, or the time of one long step.
fn least_time(mut step: impl FnMut() -> Result<()>) -> Result<Duration> {
    let mut least = Duration::MAX;
    for _ in 0..TRIES {
        let began = Instant::now();
        step()?;
        least = least.min(began.elapsed());
        if least > LONG {
            break;
        }
    }
    Ok(least)
}

/// Text such as "2x1": parts, then threads of each.
impl fmt::Display for Arrangement {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}x{}", self.side_by_side, self.threads)
    }
}

impl FromStr for Arrangement {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers = text.split_once('x').and_then(|(parts, threads)| {
            Some(Self { side_by_side: parts.parse().ok()?, threads: threads.parse().ok()? })
        });
        let sound = numbers.filter(|found| found.side_by_side > 0 && found.threads > 0);
        sound.ok_or_else(|| format!("`{text}` is not like 2x1"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;

    fn texts(candidates: &[Arrangement]) -> Vec<String> {
        candidates.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn candidates_use_the_processors_there_are() {
        assert_eq!(texts(&Arrangement::candidates(1, 4)), ["1x1"]);
        assert_eq!(texts(&Arrangement::candidates(2, 1)), ["1x2", "1x1"]);
        assert_eq!(texts(&Arrangement::candidates(6, 2)), ["2x3", "2x1", "1x6", "1x3", "1x1"]);
        for (processors, clips) in [(1, 1), (3, 2), (16, 5), (64, 64)] {
            let found = Arrangement::candidates(processors, clips);
            assert!(found.iter().all(|one| one.fits(processors) && one.side_by_side <= clips));
        }
    }

    #[test]
    fn the_quickest_is_taken() {
        let candidates = Arrangement::candidates(4, 4);
        for best in candidates.clone() {
            let step = |tried| {
                sleep(Duration::from_millis(if tried == best { 5 } else { 50 }));
                Ok(())
            };
            assert_eq!(Arrangement::quickest(&candidates, step).unwrap(), best);
        }
    }

    #[test]
    fn it_is_written_and_read() {
        for one in Arrangement::candidates(12, 3) {
            assert_eq!(one.to_string().parse(), Ok(one));
        }
        for wrong in ["", "2", "x", "0x1", "2x0", "2x-1", "2x1x1"] {
            assert!(wrong.parse::<Arrangement>().is_err(), "{wrong}");
        }
    }
}
