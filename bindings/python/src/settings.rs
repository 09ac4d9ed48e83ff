//! Settings from JSON with the names of the command line's flags.

use crate::errors::{raised, wrong};
use fovolnet::{RenderOverrides, RenderSettings, SpeedSettings, VolumeSettings};
use pyo3::PyResult;
use serde::de::DeserializeOwned;

/// Settings of pictures.
pub fn of_pictures(json: &str) -> PyResult<RenderSettings> {
    overrides(json)?.resolve().map_err(|error| raised(&error))
}

/// Settings of pictures, as far as they are given.
pub fn overrides(json: &str) -> PyResult<RenderOverrides> {
    parsed(json)
}

/// Settings of speed: a device by its name, and a number of threads.
pub fn of_speed(device: Option<&str>, threads: Option<usize>) -> PyResult<SpeedSettings> {
    let device = device.map(|device| device.parse().map_err(wrong)).transpose()?;
    Ok(SpeedSettings { device, threads, ..SpeedSettings::default() })
}

/// Settings for reading files.
pub fn of_volumes(json: &str) -> PyResult<VolumeSettings> {
    parsed(json)
}

/// Settings of `json`; errors name the wrong one as Python writes it.
fn parsed<T: DeserializeOwned>(json: &str) -> PyResult<T> {
    serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_str(json)).map_err(|error| {
        let name = error.path().to_string().replace('-', "_");
        let text = error.inner().to_string();
        let text = text.split(" at line ").next().unwrap_or_default();
        wrong(if name == "." { text.to_owned() } else { format!("{name}: {text}") })
    })
}
