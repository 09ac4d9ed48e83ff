//! Learned arrays by name: read from safetensors files and PyTorch state dicts, or random from a seed.

mod file;
#[cfg(feature = "pytorch")]
mod pytorch;
pub(crate) mod random;
mod shipped;

pub use file::Storage;
#[cfg(feature = "pytorch")]
pub use pytorch::StateDict;

use crate::plan::{NetworkConfig, Parameter, Plan};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;

/// An array of f32 and its shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Lengths of the dimensions, slowest first.
    pub shape: Vec<usize>,
    /// Elements in row-major order.
    pub values: Vec<f32>,
}

/// Weights of a network, under the names of its [`Plan`], and metadata.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    arrays: BTreeMap<String, Array>,
    /// Configuration of the network.
    pub config: NetworkConfig,
    /// Metadata: training, origin and so on.
    pub facts: BTreeMap<String, String>,
    /// Largest values of activations, for int8 arithmetic. Keys name tensors; values have one number for all
    /// channels, or one for each. Further keys have the ranges of transformed inputs of convolutions. See
    /// [`calibrate`](crate::cpu::calibrate).
    pub ranges: BTreeMap<String, Vec<f32>>,
}

impl Weights {
    /// Makes weights of `arrays`, without metadata.
    pub fn new(config: NetworkConfig, arrays: BTreeMap<String, Array>) -> Self {
        Self { arrays, config, facts: BTreeMap::new(), ranges: BTreeMap::new() }
    }

    /// Makes random weights for tests and speed measurements. Equal names and seeds give equal weights.
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

    /// All arrays by name.
    pub fn arrays(&self) -> &BTreeMap<String, Array> {
        &self.arrays
    }

    /// Returns the elements of one array.
    ///
    /// # Errors
    /// An array that is missing.
    pub fn values(&self, name: &str) -> Result<&[f32]> {
        let array = self.arrays.get(name).ok_or_else(|| Error::Weights(format!("`{name}` is missing")))?;
        Ok(&array.values)
    }

    /// Checks that these are the weights of `plan`.
    ///
    /// # Errors
    /// The first arrays that are missing, superfluous, of another shape or not finite.
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

/// Lists the differences between arrays of these names and shapes and the `parameters` of a plan, one text each.
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

/// Formats a library's error on one line: control characters, which may come from the file, become spaces.
fn one_line(error: &impl fmt::Display) -> String {
    error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Formats a name from a file for an error message: escaped, on one line, and shortened.
fn shown(name: &str) -> String {
    const LONGEST: usize = 80;
    let mut shown: String = name.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if name.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}
