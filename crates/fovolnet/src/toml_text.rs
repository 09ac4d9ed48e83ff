use crate::{Error, Result};
use serde::Deserialize;
use std::path::Path;

/// Reads the TOML file that `text` names, or `text` itself where it is TOML: it stands for the flag `flag`, and `expected`
/// says what that takes.
pub fn read<T: for<'de> Deserialize<'de>>(text: &str, flag: &str, expected: &str) -> Result<T> {
    let path = Path::new(text);
    let (what, text) = if path.exists() {
        (text, std::fs::read_to_string(path).map_err(|e| fovol_io::Error::io("read", path, e))?)
    } else if text.contains('=') {
        (flag, text.to_owned())
    } else {
        return Err(Error::Setting(format!("`{text}` is no file; {flag} takes {expected}")));
    };
    toml::from_str(&text).map_err(|e| {
        let reason = e.message().lines().next().unwrap_or_default();
        Error::Setting(format!("{what}: {reason}; {flag} takes {expected}"))
    })
}
