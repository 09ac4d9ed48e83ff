use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Cosine annealing of the learning rate per epoch, without warm-up or restarts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Cosine {
    /// Learning rate of epoch 0.
    pub first: f64,
    /// Learning rate from epoch `epochs` on.
    pub last: f64,
    /// Length in epochs.
    pub epochs: u32,
}

impl Cosine {
    /// Learning rate of `epoch`, counted from 0: last + ½ (first − last) (1 + cos(π epoch / epochs)).
    pub fn rate(&self, epoch: u32) -> f64 {
        if epoch >= self.epochs {
            return self.last;
        }
        self.at(f64::from(epoch) / f64::from(self.epochs))
    }

    /// Learning rate after the fraction `share`, 0…1, of the schedule.
    pub fn at(&self, share: f64) -> f64 {
        self.last + 0.5 * (self.first - self.last) * (1.0 + (PI * share.clamp(0.0, 1.0)).cos())
    }
}
