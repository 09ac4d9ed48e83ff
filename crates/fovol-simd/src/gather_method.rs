use std::sync::OnceLock;

/// How vectors load from an address per lane. Both ways give the same bits.
///
/// Intel's processors have fast gathers, AMD's up to Zen 4 are faster with plain loads. A process measures both in less
/// than a millisecond, before it first runs vectors of an instruction set, unless it has chosen one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GatherMethod {
    /// One plain load for each lane.
    Loads,
    /// The processor's gather instructions.
    Hardware,
}

static CHOSEN: OnceLock<GatherMethod> = OnceLock::new();

impl GatherMethod {
    /// Sets the method of this process, so that none is measured. The first choice stays; choose before any vectors run.
    pub fn choose(self) {
        let _ = CHOSEN.set(self);
    }

    /// Method that was chosen for this process, if any.
    pub fn chosen() -> Option<Self> {
        CHOSEN.get().copied()
    }

    /// Name in flags and variables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Loads => "loads",
            Self::Hardware => "hardware",
        }
    }

    /// Finds the method with the name `text`.
    ///
    /// # Errors
    /// Another name: a message that lists those that exist.
    pub fn named(text: &str) -> Result<Self, String> {
        [Self::Loads, Self::Hardware]
            .into_iter()
            .find(|method| method.name() == text)
            .ok_or_else(|| format!("`{text}` is no way to gather; use loads or hardware"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_are_found_by_their_names() {
        for method in [GatherMethod::Loads, GatherMethod::Hardware] {
            assert_eq!(GatherMethod::named(method.name()), Ok(method));
        }
        assert!(GatherMethod::named("magic").unwrap_err().contains("hardware"));
    }
}
