use std::fmt;

/// Error: too little memory, with advice how to need less.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shortage {
    /// The work that needs the memory, such as "rendering frames of 64x64".
    pub what: String,
    /// Needed bytes.
    pub needed: u64,
    /// Available bytes, if known.
    pub available: Option<u64>,
    /// Largest parts of the needed memory with their bytes, largest first.
    pub parts: Vec<(String, u64)>,
    /// Advice how to need less memory.
    pub advice: &'static str,
}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "out of memory: {} for {}", shown(self.needed), self.what)?;
        if let Some(available) = self.available {
            write!(f, ", and {} are available", shown(available))?;
        }
        for (i, (part, bytes)) in self.parts.iter().enumerate() {
            write!(f, "{}{part} {}", if i == 0 { " (" } else { ", " }, shown(*bytes))?;
        }
        write!(f, "{}; {}", if self.parts.is_empty() { "" } else { ")" }, self.advice)
    }
}

impl std::error::Error for Shortage {}

/// Formats `bytes` in a fitting unit.
fn shown(bytes: u64) -> String {
    match bytes as f64 {
        few if few < 1e3 => format!("{bytes} bytes"),
        some if some < 999.5e3 => format!("{:.0} kB", some / 1e3),
        some if some < 999.5e6 => format!("{:.0} MB", some / 1e6),
        many => format!("{:.1} GB", many / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_what_needs_how_much_and_what_helps() {
        let mut shortage = Shortage {
            what: "a frame".into(),
            needed: 1_500_000_000,
            available: None,
            parts: Vec::new(),
            advice: "give less",
        };
        assert_eq!(shortage.to_string(), "out of memory: 1.5 GB for a frame; give less");
        shortage.available = Some(999_600_000);
        shortage.parts = vec![("colours".into(), 1_499_999_999), ("words".into(), 1_999)];
        assert_eq!(
            shortage.to_string(),
            "out of memory: 1.5 GB for a frame, and 1.0 GB are available (colours 1.5 GB, words 2 kB); give less"
        );
    }
}
