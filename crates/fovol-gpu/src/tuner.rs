/// Chooses the quickest of several ways to do the same: plays each in turn, and keeps the one of the least median time.
///
/// Devices differ too much for a rule. What is chosen can be kept for the next run; see [`crate::Choices`].
#[derive(Debug, Clone)]
pub struct Tuner<C> {
    trials: Vec<Trial<C>>,
    chosen: Option<Chosen<C>>,
}

#[derive(Debug, Clone)]
struct Trial<C> {
    candidate: C,
    /// Milliseconds of its plays but the first, which warms up.
    times: Vec<f64>,
    is_warm: bool,
    is_out: bool,
}

#[derive(Debug, Clone)]
struct Chosen<C> {
    candidate: C,
    /// Milliseconds that it was chosen by.
    ms: f64,
    /// Times since.
    recent: Vec<f64>,
}

/// Plays of a candidate that are timed.
const PLAYS: usize = 3;
/// Factor of the best time from which on one play ends the trial of a candidate.
const HOPELESS: f64 = 2.0;
/// Times after which the choice is looked at again.
const RECENT: usize = 64;
/// Factors of the time that a choice was made by, between which it stays.
const STAYS: std::ops::RangeInclusive<f64> = 0.67..=1.5;

impl<C: Copy + PartialEq> Tuner<C> {
    /// Tuner that tries `candidates`, of which there is at least one, in this order.
    pub fn new(candidates: impl IntoIterator<Item = C>) -> Self {
        let trial = |candidate| Trial { candidate, times: Vec::new(), is_warm: false, is_out: false };
        Self { trials: candidates.into_iter().map(trial).collect(), chosen: None }
    }

    /// Begins with a `candidate` that was chosen before by its `ms` milliseconds.
    #[must_use]
    pub fn beginning_with(self, candidate: C, ms: f64) -> Self {
        Self { chosen: Some(Chosen { candidate, ms, recent: Vec::new() }), ..self }
    }

    /// Candidate to play next.
    pub fn next(&self) -> C {
        let open = || self.trials.iter().find(|trial| !trial.is_over());
        match &self.chosen {
            Some(chosen) => chosen.candidate,
            None => open().unwrap_or(&self.trials[0]).candidate,
        }
    }

    /// Candidate that was chosen, and the milliseconds that it was chosen by; `None` during trials.
    pub fn chosen(&self) -> Option<(C, f64)> {
        self.chosen.as_ref().map(|chosen| (chosen.candidate, chosen.ms))
    }

    /// Learns that `candidate` took `ms` milliseconds. Returns whether another one is chosen now.
    pub fn learn(&mut self, candidate: C, ms: f64) -> bool {
        if let Some(chosen) = &mut self.chosen {
            if chosen.candidate == candidate && chosen.has_changed(ms) {
                self.begin_anew();
            }
            return false;
        }
        let best = self.trials.iter().flat_map(|trial| &trial.times).copied().fold(f64::INFINITY, f64::min);
        let Some(trial) = self.trials.iter_mut().find(|trial| trial.candidate == candidate) else {
            return false;
        };
        if !trial.is_warm {
            trial.is_warm = true;
            return false;
        }
        trial.times.push(ms);
        trial.is_out |= ms > HOPELESS * best;
        if !self.trials.iter().all(Trial::is_over) {
            return false;
        }
        let finished = self.trials.iter().filter(|trial| !trial.is_out);
        let timed = finished.map(|trial| (trial.candidate, median(&trial.times)));
        let quickest = timed.min_by(|a, b| a.1.total_cmp(&b.1));
        let (candidate, ms) = quickest.expect("the quickest one is never out");
        self.chosen = Some(Chosen { candidate, ms, recent: Vec::new() });
        true
    }

    fn begin_anew(&mut self) {
        *self = Self::new(self.trials.iter().map(|trial| trial.candidate));
    }
}

impl<C> Trial<C> {
    fn is_over(&self) -> bool {
        self.is_out || self.times.len() >= PLAYS
    }
}

impl<C> Chosen<C> {
    /// Adds a time; whether the times have left those that the choice was made by.
    fn has_changed(&mut self, ms: f64) -> bool {
        self.recent.push(ms);
        if self.recent.len() < RECENT {
            return false;
        }
        let factor = median(&self.recent) / self.ms;
        self.recent.clear();
        !STAYS.contains(&factor)
    }
}

fn median(times: &[f64]) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Plays candidates that take `times` until one is chosen; returns it, and the number of plays.
    fn played(times: &[f64]) -> (usize, usize) {
        let mut tuner = Tuner::new(0..times.len());
        for plays in 1.. {
            let candidate = tuner.next();
            if tuner.learn(candidate, times[candidate]) {
                return (tuner.next(), plays);
            }
        }
        unreachable!()
    }

    proptest! {
        #[test]
        fn the_quickest_is_chosen_soon(times in prop::collection::vec(0.1f64..9.0, 1..7)) {
            let (chosen, plays) = played(&times);
            prop_assert!(times.iter().all(|time| *time >= times[chosen]));
            prop_assert!(plays <= 4 * times.len());
        }
    }

    #[test]
    fn hopeless_candidates_are_played_twice() {
        assert_eq!(played(&[1.0, 5.0, 0.9, 7.0]), (2, 4 + 2 + 4 + 2));
    }

    #[test]
    fn other_times_begin_the_trials_again() {
        let mut tuner = Tuner::new(["a", "b"]).beginning_with("b", 1.0);
        for _ in 0..RECENT {
            assert_eq!(tuner.next(), "b");
            assert!(!tuner.learn("b", 1.2));
        }
        assert_eq!(tuner.chosen(), Some(("b", 1.0)));
        (0..RECENT).for_each(|_| assert!(!tuner.learn("b", 2.0)));
        assert_eq!((tuner.chosen(), tuner.next()), (None, "a"));
    }

    #[test]
    fn frames_in_flight_may_come_late() {
        let mut tuner = Tuner::new(["a", "b"]);
        // Four frames of the first one are under way when its trial ends.
        (0..4).for_each(|_| assert!(!tuner.learn("a", 2.0)));
        assert!(!tuner.learn("a", 2.0));
        assert_eq!(tuner.next(), "b");
        (0..3).for_each(|_| assert!(!tuner.learn("b", 1.0)));
        assert!(tuner.learn("b", 1.0));
        assert_eq!(tuner.chosen(), Some(("b", 1.0)));
    }
}
