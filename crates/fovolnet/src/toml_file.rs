use crate::{Error, Result};
use serde::Deserialize;
use std::path::Path;

/// Reads the TOML file that the flag `flag` names; `expected` says what the flag takes.
pub fn read<T: for<'de> Deserialize<'de>>(file: &str, flag: &str, expected: &str) -> Result<T> {
    let path = Path::new(file);
    if !path.exists() {
        return Err(Error::Setting(format!("`{file}` is no file; {flag} takes {expected}")));
    }
    let text = std::fs::read_to_string(path).map_err(|e| fovol_io::Error::io("read", path, e))?;
    toml::from_str(&text).map_err(|e| {
        let reason = e.message().lines().next().unwrap_or_default().to_owned();
        Error::Setting(format!("{file}: {reason}; {flag} takes {expected}"))
    })
}
