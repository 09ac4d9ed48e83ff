use crate::interrupt;
use anyhow::Result;
use serde::Serialize;
use std::time::Instant;

/// Time of one run, in milliseconds.
#[derive(Debug, Clone, Copy)]
pub struct Lap {
    /// Time from the request to the end.
    pub ms: f64,
    /// Time by the device's clock, which excludes submitting and waiting; `None` without such a clock.
    pub device_ms: Option<f64>,
}

impl Lap {
    /// Time since `started` of work on the host.
    pub fn since(started: Instant) -> Self {
        Self { ms: started.elapsed().as_secs_f64() * 1e3, device_ms: None }
    }

    /// Time of the work alone: by the device's clock if there is one.
    fn net_ms(self) -> f64 {
        self.device_ms.unwrap_or(self.ms)
    }
}

/// Times of repeated runs, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Times {
    pub median_ms: f64,
    pub min_ms: f64,
    /// Median by the device's clock, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_median_ms: Option<f64>,
    pub repeats: usize,
}

impl Times {
    /// Summary of `laps`, which must not be empty.
    pub fn of(laps: &[Lap]) -> Self {
        let sorted = |of: fn(&Lap) -> f64| {
            let mut values: Vec<f64> = laps.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let [all, net] = [sorted(|lap| lap.ms), sorted(|lap| lap.net_ms())];
        let is_timed = laps.iter().all(|lap| lap.device_ms.is_some());
        Self {
            median_ms: all[all.len() / 2],
            min_ms: all[0],
            device_median_ms: is_timed.then(|| net[net.len() / 2]),
            repeats: laps.len(),
        }
    }

    /// Median by the device's clock if it has one, else from request to end.
    pub fn net_ms(&self) -> f64 {
        self.device_median_ms.unwrap_or(self.median_ms)
    }
}

/// Times the tasks 0…`tasks` by `run`: once for warm-up, then `repeats` times. Tasks take turns, so that a slow moment
/// of the machine affects all of them.
pub fn alternating(
    repeats: usize,
    tasks: usize,
    mut run: impl FnMut(usize) -> Result<Lap>,
) -> Result<Vec<Times>> {
    let mut laps = vec![Vec::with_capacity(repeats); tasks];
    for round in 0..=repeats.max(1) {
        for (task, laps) in laps.iter_mut().enumerate() {
            interrupt::check("nothing was written")?;
            let lap = run(task)?;
            if round > 0 {
                laps.push(lap);
            }
        }
    }
    Ok(laps.iter().map(|laps| Times::of(laps)).collect())
}
