//! Version 2: `.zarray`, `.zgroup`, `.zattrs`.
//! <https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html>.

use super::{Array, Keys, Node, check_shapes};
use crate::volume::zarr::codec::Chain;
use crate::volume::zarr::element;
use crate::volume::zarr::json::{Object, whole_numbers};
use serde_json::Value;

/// The group whose attributes are in `.zattrs`, if that is there.
pub fn group(attributes: Option<Object>) -> Node {
    Node::Group(attributes.unwrap_or_default())
}

/// The array of the content of `.zarray` and of `.zattrs`.
pub fn array(said: &Object, attributes: Option<Object>) -> Node {
    Node::Array(parsed(said, attributes.unwrap_or_default()).map(Box::new))
}

fn parsed(said: &Object, attributes: Object) -> Result<Array, String> {
    let lengths = |name: &str| {
        whole_numbers(said.get(name))
            .ok_or_else(|| format!("has metadata without a sound `{name}`; write it again"))
    };
    let (shape, chunk) = (lengths("shape")?, lengths("chunks")?);
    check_shapes(&shape, &chunk)?;
    let element = element::of_v2(said.get("dtype").unwrap_or(&Value::Null))?;
    let is_fortran = said.get("order").and_then(Value::as_str) == Some("F");
    let filters = said.get("filters").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let compressor = said.get("compressor").filter(|compressor| !compressor.is_null());
    let codecs = Chain::of_v2(shape.len(), element, is_fortran, filters, compressor)?;
    let names = attributes.get("_ARRAY_DIMENSIONS").and_then(Value::as_array);
    let fill_value = said.get("fill_value");
    Ok(Array {
        fill: element::fill(fill_value, element)?,
        fill_is_missing: names.is_some() && fill_value.is_some_and(|value| !value.is_null()),
        names: names
            .map(|names| names.iter().map(|name| name.as_str().map(str::to_owned)).collect())
            .unwrap_or_default(),
        keys: Keys {
            prefix: "",
            separator: if said.get("dimension_separator").and_then(Value::as_str) == Some("/") {
                '/'
            } else {
                '.'
            },
        },
        shape,
        chunk,
        element,
        codecs,
        attributes,
    })
}
