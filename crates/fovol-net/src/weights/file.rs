//! Weights files. This project writes safetensors: f32, f16 or bf16, with configuration and facts in the header.

#[cfg(feature = "pytorch")]
use super::StateDict;
use super::{Array, Weights, one_line, shown};
use crate::{Error, Result};
use half::{bf16, f16};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Header key of the configuration.
const CONFIG: &str = "fovolnet.config";
/// Header key of the ranges of activations.
const RANGES: &str = "fovolnet.ranges";

/// Number format of weights on disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// 32-bit floats.
    F32,
    /// 16-bit floats (binary16).
    F16,
}

/// Largest value of a tensor, as written in files: one number for all channels, or one for each.
#[derive(Deserialize)]
#[serde(untagged)]
enum Range {
    One(f32),
    Each(Vec<f32>),
}

impl Range {
    fn numbers(self) -> Vec<f32> {
        match self {
            Self::One(most) => vec![most],
            Self::Each(most) => most,
        }
    }
}

impl Weights {
    /// Reads a `.safetensors` file, or the state dict of a named network that PyTorch saved (`.pt`, `.pth`). The
    /// contents decide which format it is. State dicts need the cargo feature `pytorch`.
    ///
    /// # Errors
    /// A file that is missing or damaged, and weights of no known network.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = |source| Error::Io { verb: "read", path: path.into(), source };
        let bytes = fovol_core::input::read(path).map_err(failed)?;
        Self::parse(&bytes).map_err(|problem| Error::File { path: path.into(), problem })
    }

    /// Reads the bytes of a weights file; formats as in [`Self::read`]. `StateDict::weights` reads state dicts of
    /// networks without a name.
    ///
    /// # Errors
    /// The problem and how to mend it, in one line.
    pub fn parse(bytes: &[u8]) -> std::result::Result<Self, String> {
        #[cfg(feature = "pytorch")]
        if StateDict::is_likely(bytes) {
            let tensors = StateDict::parse(bytes)?;
            return tensors.weights(&tensors.network()?.config());
        }
        Self::parse_safetensors(bytes)
    }

    fn parse_safetensors(bytes: &[u8]) -> std::result::Result<Self, String> {
        let damaged = |e: safetensors::SafeTensorError| {
            let text = one_line(&e);
            let pytorch = if cfg!(feature = "pytorch") {
                "and none that PyTorch saved"
            } else {
                "and this program reads no files of PyTorch"
            };
            format!("it is no sound safetensors file ({text}), {pytorch}; copy or download it again")
        };
        let file = SafeTensors::deserialize(bytes).map_err(damaged)?;
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let mut facts: BTreeMap<String, String> =
            header.metadata().clone().unwrap_or_default().into_iter().collect();
        let config = facts.remove(CONFIG).ok_or_else(|| {
            format!(
                "its header has no `{CONFIG}`, which says what network it is of; export it again with one"
            )
        })?;
        let config = serde_json::from_str(&config).map_err(|e| {
            format!("its `{CONFIG}` is of no network known here ({}); use a newer version", one_line(&e))
        })?;
        let ranges = facts.remove(RANGES).map(|ranges| {
            let problem = |e| {
                format!("its `{RANGES}` cannot be understood ({}); calibrate the weights again", one_line(&e))
            };
            serde_json::from_str::<BTreeMap<String, Range>>(&ranges).map_err(problem)
        });
        let ranges = ranges.transpose()?.unwrap_or_default();
        let ranges = ranges.into_iter().map(|(name, range)| (name, range.numbers())).collect();
        let mut arrays = BTreeMap::new();
        for (name, view) in file.tensors() {
            let values = numbers(&view).ok_or_else(|| {
                format!("`{}` has {:?} numbers; store it as F32, F16 or BF16", shown(&name), view.dtype())
            })?;
            arrays.insert(name, Array { shape: view.shape().to_vec(), values });
        }
        Ok(Self { arrays, config, facts, ranges })
    }

    /// Encodes the weights as the bytes of a `.safetensors` file.
    ///
    /// # Errors
    /// A configuration that cannot be written as JSON.
    pub fn to_bytes(&self, storage: Storage) -> Result<Vec<u8>> {
        let failed = |e: String| Error::Config(format!("the weights cannot be written: {e}"));
        let config = serde_json::to_string(&self.config).map_err(|e| failed(e.to_string()))?;
        let mut header: HashMap<String, String> = self.facts.clone().into_iter().collect();
        header.insert(CONFIG.into(), config);
        if !self.ranges.is_empty() {
            let ranges = serde_json::to_string(&self.ranges).map_err(|e| failed(e.to_string()))?;
            header.insert(RANGES.into(), ranges);
        }
        let (dtype, encode): (_, fn(f32) -> Vec<u8>) = match storage {
            Storage::F32 => (Dtype::F32, |v| v.to_le_bytes().to_vec()),
            Storage::F16 => (Dtype::F16, |v| f16::from_f32(v).to_le_bytes().to_vec()),
        };
        let data: Vec<(&String, &Array, Vec<u8>)> = self
            .arrays
            .iter()
            .map(|(name, array)| (name, array, array.values.iter().flat_map(|&v| encode(v)).collect()))
            .collect();
        let views = data
            .iter()
            .map(|(name, array, bytes)| {
                Ok((name.as_str(), TensorView::new(dtype, array.shape.clone(), bytes)?))
            })
            .collect::<std::result::Result<Vec<_>, safetensors::SafeTensorError>>();
        let views = views.map_err(|e| failed(e.to_string()))?;
        serialize(views, Some(header)).map_err(|e| failed(e.to_string()))
    }
}

/// Converts the numbers of `view` to f32. `None` for types other than f32, f16 and bf16.
fn numbers(view: &TensorView<'_>) -> Option<Vec<f32>> {
    let pairs = || view.data().chunks_exact(2).map(|b| [b[0], b[1]]);
    Some(match view.dtype() {
        Dtype::F32 => {
            view.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
        }
        Dtype::F16 => pairs().map(|b| f16::from_le_bytes(b).to_f32()).collect(),
        Dtype::BF16 => pairs().map(|b| bf16::from_le_bytes(b).to_f32()).collect(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Named, NetworkConfig, WNetConfig};
    use proptest::prelude::*;

    fn small() -> Weights {
        let config = WNetConfig::paper().with(|options| {
            (options.encoder, options.decoder) = (vec![2, 3], vec![2]);
        });
        Weights::random(&NetworkConfig::WNet(config.unwrap()), 3).unwrap()
    }

    #[test]
    fn files_come_back_as_they_were() {
        let weights = small();
        assert_eq!(Weights::parse(&weights.to_bytes(Storage::F32).unwrap()).unwrap(), weights);
        let halved = Weights::parse(&weights.to_bytes(Storage::F16).unwrap()).unwrap();
        let (a, b) = (&weights.arrays["output.weight"], &halved.arrays["output.weight"]);
        assert!(a.values.iter().zip(&b.values).all(|(a, b)| (a - b).abs() <= a.abs() * 1e-3));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("w.safetensors");
        std::fs::write(&path, weights.to_bytes(Storage::F32).unwrap()).unwrap();
        assert_eq!(Weights::read(&path).unwrap(), weights);
        assert!(Weights::read(&folder.path().join("none")).unwrap_err().to_string().contains("cannot read"));
    }

    #[test]
    fn misfits_are_named() {
        let plan = small().config.plan().unwrap();
        small().check(&plan).unwrap();
        let mut missing = small();
        missing.arrays.remove("output.bias");
        missing.arrays.insert("more".into(), Array { shape: vec![1], values: vec![0.0] });
        let error = missing.check(&plan).unwrap_err().to_string();
        assert!(
            error.contains("`output.bias` is missing") && error.contains("`more` is not part"),
            "{error}"
        );
        let other = Named::WNetPaper.config().plan().unwrap();
        let error = small().check(&other).unwrap_err().to_string();
        assert!(error.contains("shape") && error.contains("more;") && !error.contains('\n'), "{error}");
        let mut infinite = small();
        infinite.arrays.get_mut("output.bias").unwrap().values[0] = f32::INFINITY;
        assert!(infinite.check(&plan).unwrap_err().to_string().contains("not finite"));
    }

    proptest! {
        #[test]
        fn damaged_files_are_one_line_errors(at in 0usize..4000, byte in any::<u8>(), length in 0usize..4000) {
            let mut bytes = small().to_bytes(Storage::F32).unwrap();
            let (at, length) = (at % bytes.len(), length % bytes.len());
            bytes[at] = byte;
            for bytes in [&bytes[..], &bytes[..length]] {
                if let Err(problem) = Weights::parse(bytes) {
                    prop_assert!(!problem.contains(char::is_control), "{problem}");
                }
            }
        }
    }
}
