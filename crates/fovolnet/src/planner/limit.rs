use crate::{Error, Quality, RenderOverrides, Result};

/// Limit of the cost of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Milliseconds a frame.
    Time(f64),
    /// The work of a frame made as the settings say. The clock is not asked: equal settings give equal choices.
    Work,
}

impl RenderOverrides {
    /// Limit of the planner; `None` if frames are not planned.
    ///
    /// # Errors
    /// [`Error::Contradiction`] of a budget with fixed quality; a budget that is no time.
    pub fn limit(&self) -> Result<Option<Limit>> {
        match (self.quality, self.budget) {
            (Some(Quality::Fixed), Some(_)) => Err(Error::Contradiction(
                "--quality fixed takes the flags as written and has no --budget; leave out one of them"
                    .into(),
            )),
            (None | Some(Quality::Fixed), None) => Ok(None),
            (Some(Quality::Auto), None) => Ok(Some(Limit::Work)),
            (_, Some(ms)) if ms > 0.0 && ms.is_finite() => Ok(Some(Limit::Time(ms))),
            (_, Some(ms)) => Err(Error::Setting(format!(
                "a budget of {ms} ms is no time for a frame; give --budget a number of milliseconds above 0"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_planned_and_nothing_else_unless_asked_for() {
        let limit = |quality, budget| RenderOverrides { quality, budget, ..Default::default() }.limit();
        assert_eq!(limit(None, None).unwrap(), None);
        assert_eq!(limit(Some(Quality::Fixed), None).unwrap(), None);
        assert_eq!(limit(Some(Quality::Auto), None).unwrap(), Some(Limit::Work));
        assert_eq!(limit(None, Some(40.0)).unwrap(), Some(Limit::Time(40.0)));
        assert!(limit(Some(Quality::Fixed), Some(40.0)).unwrap_err().to_string().contains("leave out one"));
        for bad in [0.0, -3.0, f64::NAN] {
            assert!(limit(None, Some(bad)).unwrap_err().to_string().contains("above 0"));
        }
    }
}
