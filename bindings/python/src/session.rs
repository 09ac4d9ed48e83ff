//! Session files.

use crate::errors::raised;
use crate::settings;
use fovolnet::core::path_of_text;
use fovolnet::{RenderOverrides, Session, VolumeSettings};
use pyo3::prelude::*;

/// Reads the session file `path`: the name of its volume, and as JSON the settings to read the volume and to render it.
///
/// Raises where the volume is missing or has changed.
#[pyfunction]
pub fn read_session(py: Python<'_>, path: &str) -> PyResult<(String, String, String)> {
    let path = path_of_text(path);
    let session = py.detach(|| -> fovolnet::Result<_> {
        let session = Session::read(&path)?;
        session.check_volume(&path)?;
        session.check_transfer_function(&path)?;
        session.check_unchanged(&path)?;
        Ok(session)
    });
    let session = session.map_err(|error| raised(&error))?;
    Ok((session.volume, json_of(&session.read)?, json_of(&session.render)?))
}

/// Writes the session of the volume `source` to `path`. The settings are JSON objects.
#[pyfunction]
pub fn write_session(py: Python<'_>, path: &str, source: &str, read: &str, render: &str) -> PyResult<()> {
    let read: VolumeSettings = settings::of_volumes(read)?;
    let render: RenderOverrides = settings::overrides(render)?;
    let path = path_of_text(path);
    py.detach(|| Session::new(source, read, render)?.write(&path)).map_err(|error| raised(&error))
}

/// `settings` as JSON, without those that are not given.
fn json_of(settings: &impl serde::Serialize) -> PyResult<String> {
    let mut value = serde_json::to_value(settings).map_err(|error| raised(&error))?;
    if let Some(fields) = value.as_object_mut() {
        fields.retain(|_, field| !field.is_null());
    }
    Ok(value.to_string())
}
