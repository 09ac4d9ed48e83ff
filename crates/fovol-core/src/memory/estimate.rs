use super::{Shortage, available};

/// Number of parts that an error lists, largest first.
const LISTED: usize = 4;

/// Estimate of the memory that some work will need at once, added up before the work begins.
///
/// Count only parts that certainly exist at the same time. A low estimate refuses too late, and a high one refuses work
/// that would have fitted.
///
/// ```
/// use fovol_core::memory::Estimate;
///
/// let frame = Estimate::new("a frame of 2x2").with("colours", 4 * 16);
/// assert_eq!(frame.total(), 64);
/// frame.check("a smaller --size needs less")?;
/// # Ok::<(), fovol_core::memory::Shortage>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Estimate {
    what: String,
    parts: Vec<(String, u64)>,
}

impl Estimate {
    /// Empty estimate for `what`, such as "rendering frames of 1280x720".
    pub fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), parts: Vec::new() }
    }

    /// Adds `bytes` for `part`.
    #[must_use]
    pub fn with(mut self, part: impl Into<String>, bytes: u64) -> Self {
        self.parts.push((part.into(), bytes));
        self
    }

    /// Sum of all parts in bytes.
    pub fn total(&self) -> u64 {
        self.parts.iter().fold(0, |sum, (_, bytes)| sum.saturating_add(*bytes))
    }

    /// Returns an error if the estimate exceeds the [`available()`] memory. `advice` tells the user how to need less.
    /// Nothing is refused if the available memory is unknown.
    ///
    /// # Errors
    /// A [`Shortage`] with the largest parts and the advice.
    pub fn check(&self, advice: &'static str) -> Result<(), Shortage> {
        self.check_against(available(), advice)
    }

    fn check_against(&self, available: Option<u64>, advice: &'static str) -> Result<(), Shortage> {
        let needed = self.total();
        if available.is_none_or(|available| needed <= available) {
            return Ok(());
        }
        let mut parts = self.parts.clone();
        parts.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
        parts.retain(|(_, bytes)| *bytes > 0);
        parts.truncate(LISTED);
        Err(Shortage { what: self.what.clone(), needed, available, parts, advice })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_never_refused() {
        let estimate = Estimate::new("work").with("a", 60).with("b", 40);
        estimate.check_against(Some(100), "").unwrap();
        estimate.check_against(None, "").unwrap();
        assert!(estimate.check_against(Some(99), "").is_err());
        let endless = estimate.with("c", u64::MAX);
        assert_eq!(endless.total(), u64::MAX);
        endless.check_against(None, "").unwrap();
    }

    #[test]
    fn the_largest_parts_are_listed() {
        let all = (1..10).fold(Estimate::new("work"), |sum, i| sum.with(format!("part {i}"), i));
        let shortage = all.with("nothing", 0).check_against(Some(10), "give less").unwrap_err();
        let listed: Vec<u64> = shortage.parts.iter().map(|(_, bytes)| *bytes).collect();
        assert_eq!((shortage.needed, listed), (45, vec![9, 8, 7, 6]));
        assert!(shortage.to_string().ends_with("part 6 6 bytes); give less"), "{shortage}");
    }
}
