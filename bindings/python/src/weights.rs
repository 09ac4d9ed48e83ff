//! Weights of networks, for other programs.

use crate::errors::{raised, wrong};
use fovolnet::core::path_of_text;
use fovolnet::io::atomic;
use fovolnet::net::weights::Storage;
use fovolnet::net::{Weights, onnx};
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Writes the network `weights` as ONNX, opset 17. Returns the number that height and width are multiples of.
#[pyfunction]
pub fn export_onnx(py: Python<'_>, path: &str, weights: &str) -> PyResult<usize> {
    let path = path_of_text(path);
    py.detach(|| {
        let weights = Weights::named_or_read(weights).map_err(|error| raised(&error))?;
        let plan = weights.config.plan().map_err(wrong)?;
        let facts: Vec<(&str, String)> =
            weights.facts.iter().map(|(key, value)| (key.as_str(), value.clone())).collect();
        let bytes = onnx::export(&plan, &weights, &facts).map_err(|error| raised(&error))?;
        atomic::write_bytes(&path, &bytes).map_err(|error| raised(&error))?;
        Ok(plan.multiple())
    })
}

/// Arrays of the network `weights`: float32, from their names.
#[pyfunction]
pub fn weights<'py>(py: Python<'py>, weights: &str) -> PyResult<Bound<'py, PyDict>> {
    let weights = py.detach(|| Weights::named_or_read(weights)).map_err(|error| raised(&error))?;
    let arrays = PyDict::new(py);
    for (name, array) in weights.arrays() {
        let values = array.values.clone().into_pyarray(py);
        arrays.set_item(name, values.reshape(array.shape.clone())?)?;
    }
    Ok(arrays)
}

/// Bytes of the network `weights` as a safetensors file, which says how the network is built.
#[pyfunction]
pub fn safetensors(py: Python<'_>, weights: &str) -> PyResult<Vec<u8>> {
    py.detach(|| Weights::named_or_read(weights)?.to_bytes(Storage::F32)).map_err(|error| raised(&error))
}
