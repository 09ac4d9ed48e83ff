//! `multiscales`: the axes of an image and its levels of resolution.

use crate::volume::zarr::json::Object;
use serde_json::Value;

/// An image in several resolutions.
#[derive(Debug, Clone, PartialEq)]
pub struct Multiscale {
    /// Names of the axes; none if it does not say them.
    pub axes: Option<Vec<Option<String>>>,
    /// Units of the axes.
    pub units: Vec<Option<String>>,
    /// The levels, the finest first.
    pub levels: Vec<Level>,
}

/// One level of resolution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Level {
    /// The path of its array, from the group on.
    pub path: String,
    /// The distance between values along each axis; empty if it is not said.
    pub scale: Vec<f64>,
    /// The position of the first value along each axis; empty if it is not said.
    pub translation: Vec<f64>,
}

/// Axes of images before version 0.3.
pub const USUAL_AXES: [&str; 5] = ["t", "c", "z", "y", "x"];

impl Multiscale {
    /// The first image in the metadata `ome`.
    ///
    /// # Errors
    /// Metadata without levels.
    pub fn of(ome: &Object) -> Result<Self, String> {
        let said = ome.get("multiscales").and_then(|list| list.get(0)).unwrap_or(&Value::Null);
        let list = |value: &Value, key: &str| value.get(key).and_then(Value::as_array).cloned();
        let axes = list(said, "axes").or_else(|| list(said.get("coordinateSystems")?.get(0)?, "axes"));
        let common = Transform::of(said);
        let levels: Vec<Level> = list(said, "datasets")
            .unwrap_or_default()
            .iter()
            .filter_map(|dataset| {
                let own = Transform::of(dataset).then(&common);
                let path = dataset.get("path")?.as_str()?.to_owned();
                Some(Level { path, scale: own.scale, translation: own.translation })
            })
            .collect();
        if levels.is_empty() {
            return Err("has `multiscales` without datasets; write it again".into());
        }
        let units = axes.iter().flatten().map(|axis| Some(axis.get("unit")?.as_str()?.to_owned())).collect();
        let axes = axes.map(|axes| axes.iter().map(name).collect());
        Ok(Self { axes, units, levels })
    }
}

/// The name of an axis: version 0.3 has it alone. A time or channel goes by its type.
fn name(axis: &Value) -> Option<String> {
    match axis.get("type").and_then(Value::as_str) {
        Some("time") => Some("t".into()),
        Some("channel") => Some("c".into()),
        _ => axis.as_str().or_else(|| axis.get("name")?.as_str()).map(str::to_owned),
    }
}

/// A scale and a translation after it; empty where they are not said.
#[derive(Debug, Default)]
struct Transform {
    scale: Vec<f64>,
    translation: Vec<f64>,
}

impl Transform {
    /// The transformations of a level, or of all levels, one after another.
    fn of(said: &Value) -> Self {
        let all = said.get("coordinateTransformations").and_then(Value::as_array);
        let numbers = |value: &Value, key: &str| -> Vec<f64> {
            let list = value.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
            list.iter().map(|number| number.as_f64().unwrap_or(f64::NAN)).collect()
        };
        all.into_iter().flatten().fold(Self::default(), |before, next| {
            before.then(&Self { scale: numbers(next, "scale"), translation: numbers(next, "translation") })
        })
    }

    /// This one, then `next`.
    fn then(self, next: &Self) -> Self {
        let scaled = |values: Vec<f64>| match (values.is_empty(), next.scale.is_empty()) {
            (true, _) | (_, true) => values,
            _ => values.iter().zip(&next.scale).map(|(value, factor)| value * factor).collect(),
        };
        let scale = if self.scale.is_empty() { next.scale.clone() } else { scaled(self.scale) };
        let moved = scaled(self.translation);
        let translation = match (moved.is_empty(), next.translation.is_empty()) {
            (true, _) => next.translation.clone(),
            (_, true) => moved,
            _ => moved.iter().zip(&next.translation).map(|(value, way)| value + way).collect(),
        };
        Self { scale, translation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn transformations_follow_each_other() {
        let ome = json!({"multiscales": [{
            "axes": [{"name": "z", "type": "space", "unit": "micrometer"}, "y", {"name": "frames", "type": "time"}],
            "datasets": [{"path": "0", "coordinateTransformations": [
                {"type": "scale", "scale": [1, 2, 4]}, {"type": "translation", "translation": [1, 1, 1]}]}, {}],
            "coordinateTransformations": [{"type": "scale", "scale": [10, 1, 0.5]}],
        }]});
        let found = Multiscale::of(ome.as_object().unwrap()).unwrap();
        assert_eq!(found.axes.unwrap(), ["z", "y", "t"].map(|name| Some(name.to_owned())));
        assert_eq!(found.units[0].as_deref(), Some("micrometer"));
        let level =
            Level { path: "0".into(), scale: vec![10.0, 2.0, 2.0], translation: vec![10.0, 1.0, 0.5] };
        assert_eq!(found.levels, [level]);
    }

    #[test]
    fn levels_must_be_there() {
        assert!(Multiscale::of(&Object::new()).is_err());
        assert!(Multiscale::of(json!({"multiscales": [{"datasets": [7]}]}).as_object().unwrap()).is_err());
    }
}
