//! `image-label`: names and colours of the values of a label map.

use crate::volume::zarr::json::Object;
use fovol_core::Label;
use serde_json::Value;
use std::collections::BTreeMap;

/// Most labels that are listed.
const MOST: usize = 1 << 16;

/// Whether the metadata `ome` of a group at `path` are those of a label map.
pub fn is_label(ome: &Object, path: &str) -> bool {
    ome.contains_key("image-label") || path.rsplit('/').nth(1) == Some("labels")
}

/// The labels that the metadata `ome` describes, by their values.
pub fn labels(ome: &Object) -> Vec<Label> {
    let entries = |key: &str| {
        let list = ome.get("image-label").and_then(|label| label.get(key)).and_then(Value::as_array);
        let valued = |entry: &Value| Some((entry.get("label-value")?.as_i64()?, entry.clone()));
        list.into_iter().flatten().take(MOST).filter_map(valued).collect::<Vec<_>>()
    };
    let mut found = BTreeMap::new();
    let unnamed = |value| Label { value, name: String::new(), colour: None };
    for (value, entry) in entries("colors") {
        found.entry(value).or_insert_with(|| unnamed(value)).colour = entry.get("rgba").and_then(colour);
    }
    for (value, entry) in entries("properties") {
        let name = ["name", "label", "class", "type"].iter().find_map(|key| entry.get(key)?.as_str());
        found.entry(value).or_insert_with(|| unnamed(value)).name = name.unwrap_or_default().to_owned();
    }
    found.into_values().collect()
}

/// A colour of whole numbers, or of parts of 1 as some programs write it.
fn colour(rgba: &Value) -> Option<[u8; 3]> {
    let list = rgba.as_array()?;
    let is_whole = list.iter().all(Value::is_u64);
    let channel = |at: usize| {
        let value = list.get(at)?.as_f64()?;
        Some(if is_whole { value } else { value * 255.0 }.round().clamp(0.0, 255.0) as u8)
    };
    Some([channel(0)?, channel(1)?, channel(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_have_names_and_colours() {
        let ome = json!({"image-label": {
            "colors": [{"label-value": 4, "rgba": [0, 255, 7, 255]}, {"label-value": 1, "rgba": [1.0, 0.5, 0.0, 1.0]}],
            "properties": [{"label-value": 4, "class": "nucleus", "area": 9}, {"area": 1}]}});
        let label = |value, name: &str, colour| Label { value, name: name.into(), colour: Some(colour) };
        assert_eq!(
            labels(ome.as_object().unwrap()),
            [label(1, "", [255, 128, 0]), label(4, "nucleus", [0, 255, 7])]
        );
        assert!(is_label(&Object::new(), "a/labels/b") && !is_label(&Object::new(), "labels"));
    }
}
