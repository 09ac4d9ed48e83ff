//! Learned arrays by name: safetensors files, state dicts of PyTorch, and seeded random ones.

mod file;
pub(crate) mod random;

pub use file::Storage;

use crate::plan::{NetworkConfig, Plan};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// An array of f32 and its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Lengths, slowest first.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f32>,
}

/// The weights of a network, named as its [`Plan`] names them, and what is known about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    arrays: BTreeMap<String, Array>,
    /// Which network they are of.
    pub config: NetworkConfig,
    /// Other facts: how they were trained, where they come from.
    pub facts: BTreeMap<String, String>,
    /// The largest value that each tensor of the network reaches, where that is known: for bytes.
    pub ranges: BTreeMap<String, f32>,
}

impl Weights {
    /// Weights from `arrays`.
    pub fn new(config: NetworkConfig, arrays: BTreeMap<String, Array>) -> Self {
        Self { arrays, config, facts: BTreeMap::new(), ranges: BTreeMap::new() }
    }

    /// Seeded random weights, good for tests and for measuring speed: the same name and seed, the same weights.
    ///
    /// # Errors
    /// A configuration that makes no network.
    pub fn random(config: &NetworkConfig, seed: u64) -> Result<Self> {
        let plan = config.plan().map_err(Error::Config)?;
        let arrays = plan.parameters().into_iter().map(|parameter| {
            let values = random::values(&parameter, seed);
            (parameter.name, Array { shape: parameter.shape, values })
        });
        let mut weights = Self::new(config.clone(), arrays.collect());
        weights.facts.insert("training".into(), format!("none: random, seed {seed}"));
        Ok(weights)
    }

    /// The arrays by name.
    pub fn arrays(&self) -> &BTreeMap<String, Array> {
        &self.arrays
    }

    /// The numbers of one array.
    ///
    /// # Errors
    /// A name that is not there.
    pub fn values(&self, name: &str) -> Result<&[f32]> {
        let array = self.arrays.get(name).ok_or_else(|| Error::Weights(format!("`{name}` is missing")))?;
        Ok(&array.values)
    }

    /// Whether these are the weights of `plan`.
    ///
    /// # Errors
    /// The first arrays that are missing, not wanted, of another shape or not finite.
    pub fn check(&self, plan: &Plan) -> Result<()> {
        let mut problems = Vec::new();
        let parameters = plan.parameters();
        for parameter in &parameters {
            match self.arrays.get(&parameter.name) {
                None => problems.push(format!("`{}` is missing", parameter.name)),
                Some(array) if array.shape != parameter.shape => problems.push(format!(
                    "`{}` has the shape {:?}, not {:?}",
                    parameter.name, array.shape, parameter.shape
                )),
                Some(array) if array.values.iter().any(|v| !v.is_finite()) => {
                    problems.push(format!("`{}` has numbers that are not finite", parameter.name));
                }
                Some(_) => {}
            }
        }
        let extra = self.arrays.keys().filter(|name| parameters.iter().all(|p| p.name != **name));
        problems.extend(extra.map(|name| format!("`{}` is not part of it", name.escape_debug())));
        if problems.is_empty() {
            return Ok(());
        }
        let more = problems.len().saturating_sub(3);
        let tail = if more > 0 { format!(", and {more} more") } else { String::new() };
        problems.truncate(3);
        Err(Error::Weights(problems.join(", ") + &tail))
    }
}
