use fovol_net::plan::Named;
use std::fmt;
use std::str::FromStr;

/// Random weights of a network, made from a seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct RandomWeights {
    /// Network.
    pub network: Named,
    /// Random seed.
    pub seed: u64,
}

impl fmt::Display for RandomWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.network, self.seed)
    }
}

impl FromStr for RandomWeights {
    type Err = String;

    /// Parses `wnet-fast` or `wnet-fast:7`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, seed) = text.split_once(':').unwrap_or((text, "0"));
        let seed = seed.parse().map_err(|_| format!("`{seed}` is no seed; write NAME or NAME:NUMBER"))?;
        Ok(Self { network: name.parse()?, seed })
    }
}
