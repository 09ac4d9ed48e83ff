//! Version 3: `zarr.json`. <https://zarr-specs.readthedocs.io/en/latest/v3/core/index.html>.

use super::{Array, Keys, Node, check_shapes};
use crate::volume::zarr::codec::Chain;
use crate::volume::zarr::element;
use crate::volume::zarr::json::{Object, configured, named, whole_numbers};
use serde_json::Value;

/// The group or array of the content of `zarr.json`.
///
/// # Errors
/// Metadata of neither.
pub fn node(mut said: Object) -> Result<Node, String> {
    let attributes = match said.remove("attributes") {
        Some(Value::Object(attributes)) => attributes,
        _ => Object::new(),
    };
    match said.get("node_type").and_then(Value::as_str) {
        Some("group") => Ok(Node::Group(attributes)),
        Some("array") => Ok(Node::Array(array(&said, attributes).map(Box::new))),
        _ => Err("says neither `group` nor `array` as its `node_type`; write it again".into()),
    }
}

fn array(said: &Object, attributes: Object) -> Result<Array, String> {
    let wrong = |name: &str| format!("has metadata without a sound `{name}`; write it again");
    let shape = whole_numbers(said.get("shape")).ok_or_else(|| wrong("shape"))?;
    let grid = said.get("chunk_grid").ok_or_else(|| wrong("chunk_grid"))?;
    if named(grid) != "regular" {
        return Err(format!(
            "has a chunk grid `{}`, which is not read; write it with regular chunks",
            named(grid)
        ));
    }
    let chunk = whole_numbers(configured(grid, "chunk_shape")).ok_or_else(|| wrong("chunk_grid"))?;
    check_shapes(&shape, &chunk)?;
    if said.get("storage_transformers").and_then(Value::as_array).is_some_and(|list| !list.is_empty()) {
        return Err("has storage transformers, which are not read; write it without them".into());
    }
    let dtype = element::of_v3(said.get("data_type").unwrap_or(&Value::Null))?;
    let codecs = said.get("codecs").and_then(Value::as_array).ok_or_else(|| wrong("codecs"))?;
    let (codecs, element) = Chain::of_v3(&chunk, dtype, codecs)?;
    Ok(Array {
        fill: element::fill(said.get("fill_value"), element)?,
        fill_is_missing: false,
        keys: keys(said.get("chunk_key_encoding").unwrap_or(&Value::Null))?,
        names: said
            .get("dimension_names")
            .and_then(Value::as_array)
            .map(|names| names.iter().map(|name| name.as_str().map(str::to_owned)).collect())
            .unwrap_or_default(),
        shape,
        chunk,
        element,
        codecs,
        attributes,
    })
}

/// Names of chunks by their encoding.
fn keys(encoding: &Value) -> Result<Keys, String> {
    let (prefix, usual) = match named(encoding) {
        "default" | "" => ("c", '/'),
        "v2" => ("", '.'),
        other => {
            return Err(format!("names its chunks by `{other}`, which is not read; write it by `default`"));
        }
    };
    let separator = match configured(encoding, "separator").and_then(Value::as_str) {
        Some("/") => '/',
        Some(".") => '.',
        _ => usual,
    };
    Ok(Keys { prefix, separator })
}
