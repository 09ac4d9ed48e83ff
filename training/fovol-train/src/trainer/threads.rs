//! With how many threads a step is quickest. Steps of few pixels lose more by waking threads than these gain: one thread
//! is twice as quick as two for a clip of 12 frames of 128² on two processors.

use crate::Result;
use std::time::{Duration, Instant};

/// Steps that take longer are of so many pixels that all threads are worth it, and too long to try what else is.
const LONG: Duration = Duration::from_secs(10);
/// Steps with each number of threads; the first wakes them.
const TRIES: usize = 3;

/// Takes `step` with all threads that torch has now, with half as many and so on down to one; leaves torch with as many
/// as were quickest and returns their number.
///
/// # Errors
/// Those of `step`.
pub(super) fn choose(mut step: impl FnMut() -> Result<()>) -> Result<i32> {
    let all = tch::get_num_threads();
    let numbers = std::iter::successors(Some(all), |&number| (number > 1).then_some(number / 2));
    let mut quickest = (all, Duration::MAX);
    for number in numbers {
        tch::set_num_threads(number);
        let time = least_time(&mut step)?;
        if time < quickest.1 {
            quickest = (number, time);
        }
        if time > LONG {
            break;
        }
    }
    tch::set_num_threads(quickest.0);
    Ok(quickest.0)
}

/// The least time of some steps, of one that is long.
fn least_time(step: &mut impl FnMut() -> Result<()>) -> Result<Duration> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;

    #[test]
    fn the_quickest_number_is_left() {
        // Threads of torch are of the whole process; as many as are known to be there.
        let before = tch::get_num_threads();
        tch::set_num_threads(4);
        for best in [4, 2, 1] {
            tch::set_num_threads(4);
            let step = || {
                let distance = (tch::get_num_threads() - best).unsigned_abs();
                sleep(Duration::from_millis(5 + 20 * u64::from(distance)));
                Ok(())
            };
            assert_eq!(choose(step).unwrap(), best);
            assert_eq!(tch::get_num_threads(), best);
        }
        tch::set_num_threads(before);
    }
}
