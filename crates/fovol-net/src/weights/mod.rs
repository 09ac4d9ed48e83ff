//! Learned arrays by name: from safetensors files and state dicts of PyTorch, and seeded random ones.

mod file;
mod pytorch;
pub(crate) mod random;
mod shipped;

pub use file::Storage;
pub use pytorch::StateDict;

use crate::plan::{NetworkConfig, Parameter, Plan};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;

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
    /// The largest value that tensors of the network reach, where that is known: one for all channels, or one for each. And
    /// what inputs of convolutions do once they are transformed. For bytes; see [`calibrate`](crate::cpu::calibrate).
    pub ranges: BTreeMap<String, Vec<f32>>,
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
        let shapes = self.arrays.iter().map(|(name, array)| (name.as_str(), array.shape.as_slice()));
        let mut problems = misfits(&plan.parameters(), &shapes.collect());
        let infinite = self.arrays.iter().filter(|(_, array)| array.values.iter().any(|v| !v.is_finite()));
        problems
            .extend(infinite.map(|(name, _)| format!("`{}` has numbers that are not finite", shown(name))));
        if problems.is_empty() {
            return Ok(());
        }
        let more = problems.len().saturating_sub(3);
        let tail = if more > 0 { format!(", and {more} more") } else { String::new() };
        problems.truncate(3);
        Err(Error::Weights(problems.join(", ") + &tail))
    }
}

/// What keeps arrays of these names and shapes from being those of `parameters`, one by one.
fn misfits(parameters: &[Parameter], shapes: &BTreeMap<&str, &[usize]>) -> Vec<String> {
    let mut problems = Vec::new();
    for Parameter { name, shape } in parameters {
        match shapes.get(name.as_str()) {
            None => problems.push(format!("`{name}` is missing")),
            Some(found) if *found != shape.as_slice() => {
                problems.push(format!("`{name}` has the shape {found:?}, not {shape:?}"));
            }
            Some(_) => {}
        }
    }
    let extra = shapes.keys().filter(|name| parameters.iter().all(|p| p.name != **name));
    problems.extend(extra.map(|name| format!("`{}` is not part of it", shown(name))));
    problems
}

/// What a library says of a file, without what it took from there that would break the line.
fn one_line(error: &impl fmt::Display) -> String {
    error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A name from a file as it can be part of a message: one line, not long.
fn shown(name: &str) -> String {
    const LONGEST: usize = 80;
    let mut shown: String = name.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if name.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}
