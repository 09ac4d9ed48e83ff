use std::fmt;
use std::str::FromStr;

/// How a GPU interpolates voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Filtering {
    /// In f32, as on the CPU.
    #[default]
    Exact,
    /// By texture samplers, where these filter the type of the voxels.
    ///
    /// A sample takes one access. Weights come in steps of 1/256, which steep transfer functions make visible.
    Hardware,
}

impl Filtering {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Hardware];

    /// The name that [`FromStr`] reads and [`fmt::Display`] writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Hardware => "hardware",
        }
    }
}

impl fmt::Display for Filtering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Filtering {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|filtering| filtering.name() == text);
        found.ok_or_else(|| {
            format!("`{text}` is no way to filter; use {}", Self::ALL.map(Self::name).join(" or "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_as_written() {
        for filtering in Filtering::ALL {
            assert_eq!(filtering.to_string().parse(), Ok(filtering));
        }
        assert!("linear".parse::<Filtering>().unwrap_err().contains("exact or hardware"));
    }
}
