use clap::Args;
use fovolnet::simd::{GatherMethod, Simd};

/// Variable of the environment that chooses as `--simd` does.
const VARIABLE: &str = "FOVOLNET_SIMD";
/// Variable of the environment that chooses how vectors gather: auto, loads or hardware.
const GATHERS: &str = "FOVOLNET_GATHERS";

/// Instruction set of the whole program.
#[derive(Args)]
pub struct InstructionSet {
    /// Instruction set of marcher and networks: auto, scalar, portable, avx2, avx512 or amx [default: FOVOLNET_SIMD, or auto]
    #[arg(long, value_name = "SET", global = true, value_parser = parsed, display_order = 900)]
    simd: Option<Choice>,
}

/// A set, or the fastest one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Choice(Option<Simd>);

/// Parses `auto` or the name of a set of this processor.
fn parsed(text: &str) -> Result<Choice, String> {
    let set = (text != "auto").then(|| Simd::named(text, &Simd::choices())).transpose();
    set.map(Choice)
}

impl InstructionSet {
    /// Makes the chosen set, and the way to gather, those of this process.
    ///
    /// # Errors
    /// A variable of the environment that names none.
    pub fn choose(&self) -> Result<(), String> {
        let choice = match (self.simd, std::env::var(VARIABLE)) {
            (Some(choice), _) => choice,
            (None, Ok(text)) if !text.is_empty() => {
                parsed(&text).map_err(|problem| format!("{VARIABLE}: {problem}"))?
            }
            (None, _) => Choice(None),
        };
        choice.0.into_iter().for_each(Simd::choose);
        match std::env::var(GATHERS) {
            Ok(text) if !text.is_empty() && text != "auto" => {
                GatherMethod::named(&text).map_err(|problem| format!("{GATHERS}: {problem}"))?.choose();
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_names_and_auto_is_any() {
        assert_eq!(parsed("auto"), Ok(Choice(None)));
        assert_eq!(parsed("scalar"), Ok(Choice(Some(Simd::Scalar))));
        assert!(parsed("mmx").unwrap_err().contains("portable"));
    }
}
