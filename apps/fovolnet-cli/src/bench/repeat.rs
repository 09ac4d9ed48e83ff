use crate::interrupt;
use anyhow::Result;
use serde::Serialize;
use std::time::Instant;

/// Times of one thing done again and again, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Times {
    pub median_ms: f64,
    pub min_ms: f64,
    pub repeats: usize,
}

/// Does things 0…`tasks` by `run` once to warm up and then `repeats` times, one after the other in turn,
/// so that a slow moment of the machine meets all of them.
pub fn alternating(
    repeats: usize,
    tasks: usize,
    mut run: impl FnMut(usize) -> Result<()>,
) -> Result<Vec<Times>> {
    let mut times = vec![Vec::with_capacity(repeats); tasks];
    for round in 0..=repeats.max(1) {
        for (task, times) in times.iter_mut().enumerate() {
            interrupt::check("nothing was written")?;
            let started = Instant::now();
            run(task)?;
            if round > 0 {
                times.push(started.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    Ok(times.into_iter().map(summary).collect())
}

fn summary(mut times: Vec<f64>) -> Times {
    times.sort_by(f64::total_cmp);
    Times { median_ms: times[times.len() / 2], min_ms: times[0], repeats: times.len() }
}
