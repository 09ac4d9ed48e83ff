//! Memory of what was computed from the values of a volume.

use crate::Statistics;
use std::sync::{Mutex, OnceLock};

/// Results that stay while a volume's values do.
#[derive(Debug, Default)]
pub struct Found {
    /// Statistics of the values.
    pub statistics: OnceLock<Statistics>,
    /// The last histogram that was asked for.
    pub histogram: Mutex<Option<(Bins, Vec<u64>)>>,
    /// The smallest value above 0, if there is one.
    pub least_positive: OnceLock<Option<f64>>,
    /// The labels, if the values look like labels.
    pub labels: OnceLock<Option<Vec<f64>>>,
}

/// Equal parts of the range `lo` to `hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bins {
    /// How many parts.
    pub count: usize,
    /// Lower end of the first.
    pub lo: f64,
    /// Upper end of the last.
    pub hi: f64,
}
