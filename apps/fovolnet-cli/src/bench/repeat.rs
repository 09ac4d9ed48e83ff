use crate::interrupt;
use anyhow::Result;
use serde::Serialize;
use std::time::Instant;

/// How long one thing took once, in milliseconds.
#[derive(Debug, Clone, Copy)]
pub struct Lap {
    /// From when it was asked for to when it was done.
    pub ms: f64,
    /// By the clock of the device that did it, if it has one: without what asking and waiting take.
    pub device_ms: Option<f64>,
}

impl Lap {
    /// What has passed since `started`, of something that was done here.
    pub fn since(started: Instant) -> Self {
        Self { ms: started.elapsed().as_secs_f64() * 1e3, device_ms: None }
    }

    /// What only it itself took, as far as that is known.
    fn net_ms(self) -> f64 {
        self.device_ms.unwrap_or(self.ms)
    }
}

/// Times of one thing done again and again, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Times {
    pub median_ms: f64,
    pub min_ms: f64,
    /// The median by the clock of the device, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_median_ms: Option<f64>,
    pub repeats: usize,
}

impl Times {
    /// Of things done at least once.
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

    /// The median by the clock of the device, or from asking to being done where it has none.
    pub fn net_ms(&self) -> f64 {
        self.device_median_ms.unwrap_or(self.median_ms)
    }
}

/// Does things 0…`tasks` by `run` once to warm up and then `repeats` times, one after the other in turn,
/// so that a slow moment of the machine meets all of them.
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
